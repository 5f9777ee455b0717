r"""Gravity compensation: the arm floats, a little damped; what teaching uses and what every fault falls back to.

.. math:: \tau = g(q) - \tau_{cb}(q) - \tau_{wall}(q, v) + \tau_{guiding}(q, v),

clipped at the torque limits. Near a joint's soft limit a wall, a spring and damper that begins a margin before the
limit, turns the arm back under the hand. While a hand leads, the last term makes the arm light where the tool moves and
heavy where only the elbow would swing,

.. math:: \tau_{guiding} = \sigma f_c \tanh(v / v_s) - D v - D_n N(q)\, v,

with a share of the Coulomb friction (less than all of it: the arm stays passive), a damping, and a damping of the
motion that leaves the tool where it is; N projects onto the null space of the Jacobian, so no hand feels it. Derivation
ours.

Every damping D, of a hand's guidance, of a stop and of the walls, is taken in the form that a torque held for a period
bears (`held_damping`): with the plain one a light wrist at 500 Hz swings ever wider, past its velocity limit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pft_exec.control.command import Command
from pft_exec.control.held_damping import held_damping
from pft_exec.geometry import Array
from pft_exec.model import Arm, ArmDynamics, JointFriction

TEACH_DAMPING = 0.3
"""N m s/rad; of every joint."""
SWIVEL_DAMPING = 2.0
"""N m s/rad; of the motion that leaves the tool where it is: the elbow drifts 0.04 rad instead of 0.09 (measured)."""
FRICTION_SHARE = 0.6
"""Share of the Coulomb friction that is compensated: a hand needs 11.6 N where it needed 15.7 N (measured)."""
FRICTION_SPEED = 0.02
"""rad/s over which the compensation of friction comes in."""
WALL_MARGIN = 0.05
"""rad before the soft limit at which the wall begins."""
WALL_SHARE = 0.5
"""Share of a joint's torque limit that the wall pushes with at the soft limit itself."""
WALL_DAMPING = 2.0
"""N m s/rad; of motion into the wall, so that the arm is not thrown back."""
STOP_SHARE = 0.2
"""Share of its torque limit with which a joint that turns at 1 rad/s is braked in a stop."""


class GravityCompensation:
    """Let an arm float.

    Parameters
    ----------
    arm : Arm
    damping : float, (n,) or None, N m s/rad
        Of every joint, and nothing else: for stops (`stop_damping`). None is for a hand that leads (`guiding_torque`).
        Less where the joint's inertia is too small for it.
    period : float, s
        For which a torque is held.
    """

    def __init__(self, arm: Arm, damping: float | Array | None = None, period: float = 0.001) -> None:
        self.arm = arm
        self.damping = damping
        self.period = period
        self._zero = np.zeros(len(arm.joint_names))
        self._last = self._zero
        self._lowest, self._highest = arm.limits.lower + WALL_MARGIN, arm.limits.upper - WALL_MARGIN

    def carry(self, arm: Arm) -> None:
        """Go on with another model of the same arm: a payload was grasped or released.

        Raises
        ------
        ConfigurationError
            If the model has other joints.
        """
        arm.check_configuration(self._zero)
        self.arm = arm

    def update(
        self,
        time: float,
        q: Array,
        v: Array,
        status: str = "gravity compensation",
        unseen: NDArray[np.bool_] | None = None,
    ) -> Command:
        """Torque for one control period; never raises.

        Parameters
        ----------
        time : float, s
        q, v : (n,), rad, rad/s
            Measured. Where one is not finite, the last good configuration is held up, without damping.
        status : str
            Passed on to the command.
        unseen : (n,), bool, optional
            Joints whose state is believed, not measured. They are held up, no more: a wall or a damping that answers
            to a state which does not change is a push that nothing ends.
        """
        del time
        if not np.isfinite(q).all():
            q, v, status = self._last, self._zero, f"{status}; configuration not finite"
        if not np.isfinite(v).all():
            v, status = self._zero, f"{status}; velocity not finite"
        self._last = np.array(q, dtype=float)
        if unseen is not None and unseen.any():
            v = np.where(unseen, 0.0, v)
        return self._command(self._last, v, status, unseen)

    def _command(self, q: Array, v: Array, status: str, unseen: NDArray[np.bool_] | None) -> Command:
        limit = self.arm.limits.torque
        still = self.arm.dynamics(q, self._zero)
        spring, damping = self._wall(q, v)
        if unseen is not None:
            spring = np.where(unseen, 0.0, spring)
        torque = still.bias - self.arm.counterbalance(q) - spring
        if self.damping is None:
            torque += lightening_torque(self.arm.friction, v)
            damping = damping + guiding_damping(still.jacobian)
        else:
            damping = damping + np.diag(np.broadcast_to(self.damping, q.shape))
        torque -= held_damping(still.mass_matrix, damping, self.period) @ v
        return Command(
            torque=np.minimum(np.maximum(torque, -limit), limit),
            acceleration=self._zero,
            configuration=q,
            velocity=v,
            reference_acceleration=self._zero,
            position=still.position,
            quaternion=still.quaternion,
            phase=0.0,
            error=np.zeros(6),
            torque_active=np.abs(torque) >= limit,
            bound_active=np.zeros(len(q), dtype=bool),
            status=status,
            fallback=False,
        )

    def _wall(self, q: Array, v: Array) -> tuple[Array, Array]:
        """What the walls before the limits do: torque (n,), N m, to be taken away, and damping (n, n), N m s/rad."""
        above, below = q - self._highest, self._lowest - q
        if max(above.max(), below.max()) <= 0.0:
            return self._zero, np.zeros((len(q), len(q)))
        depth = np.maximum(above, 0.0) - np.maximum(below, 0.0)
        spring: Array = WALL_SHARE * self.arm.limits.torque / WALL_MARGIN * depth
        return spring, np.diag(np.where(depth * v > 0.0, WALL_DAMPING, 0.0))


def stop_damping(arm: Arm) -> Array:
    """Damping (n,), N m s/rad, that brings an arm to rest, and keeps it slow under a load that no model knows."""
    damping: Array = STOP_SHARE * arm.limits.torque
    return damping


def guiding_torque(friction: JointFriction, v: Array, dynamics: ArmDynamics, period: float) -> Array:
    """Torque (n,), N m, that lets a hand lead: see the formula of this module.

    Parameters
    ----------
    friction : JointFriction
    v : (n,), rad/s
    dynamics : ArmDynamics
        Of the arm where it is: its Jacobian and its mass matrix.
    period : float, s
        For which the torque is held.
    """
    damping = held_damping(dynamics.mass_matrix, guiding_damping(dynamics.jacobian), period)
    torque: Array = lightening_torque(friction, v) - damping @ v
    return torque


def lightening_torque(friction: JointFriction, v: Array) -> Array:
    """Torque (n,), N m, that takes a share of the Coulomb friction off a hand at a velocity (n,), rad/s."""
    torque: Array = FRICTION_SHARE * friction.coulomb * np.tanh(v / FRICTION_SPEED)
    return torque


def guiding_damping(jacobian: Array) -> Array:
    """Damping (n, n), N m s/rad, under a hand: little of every joint, more of what the Jacobian (6, n) does not see."""
    null = np.linalg.svd(jacobian)[2][6:]
    damping: Array = TEACH_DAMPING * np.eye(jacobian.shape[1]) + SWIVEL_DAMPING * (null.T @ null)
    return damping
