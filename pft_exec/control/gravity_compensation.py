r"""Gravity compensation: the arm floats, a little damped; what teaching uses and what every fault falls back to.

.. math:: \tau = g(q) - \tau_{cb}(q) - \tau_{wall}(q, v) + \tau_{guiding}(q, v),

clipped at the torque limits. Near a joint's soft limit a wall, a spring and damper that begins a margin before the
limit, turns the arm back under the hand. While a hand leads, the last term makes the arm light where the tool moves and
heavy where only the elbow would swing,

.. math:: \tau_{guiding} = \sigma f_c \tanh(v / v_s) - D v - D_n N(q)\, v,

with a share of the Coulomb friction (less than all of it: the arm stays passive), a damping, and a damping of the
motion that leaves the tool where it is; N projects onto the null space of the Jacobian, so no hand feels it. Derivation
ours.
"""

from __future__ import annotations

import numpy as np

from pft_exec.control.command import Command
from pft_exec.geometry import Array
from pft_exec.model import Arm, JointFriction

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
STABLE_SHARE = 0.3
"""Share of a joint's speed that damping takes away in a control period at most: more swings, delayed by a period."""


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

    def update(self, time: float, q: Array, v: Array, status: str = "gravity compensation") -> Command:
        """Torque for one control period; never raises.

        Parameters
        ----------
        time : float, s
        q, v : (n,), rad, rad/s
            Measured. Where one is not finite, the last good configuration is held up, without damping.
        status : str
            Passed on to the command.
        """
        del time
        if not np.isfinite(q).all():
            q, v, status = self._last, self._zero, f"{status}; configuration not finite"
        if not np.isfinite(v).all():
            v, status = self._zero, f"{status}; velocity not finite"
        self._last = np.array(q, dtype=float)
        return self._command(self._last, v, status)

    def _command(self, q: Array, v: Array, status: str) -> Command:
        limit = self.arm.limits.torque
        still = self.arm.dynamics(q, self._zero)
        stable = STABLE_SHARE / self.period / np.diag(np.linalg.inv(still.mass_matrix))
        torque = still.bias - self.arm.counterbalance(q) - self.wall_torque(q, v, stable)
        if self.damping is None:
            torque += guiding_torque(self.arm.friction, v, still.jacobian, still.mass_matrix, self.period)
        else:
            torque -= np.minimum(self.damping, stable) * v
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

    def wall_torque(self, q: Array, v: Array, stable: Array | float = np.inf) -> Array:
        """Torque (n,), N m, towards the soft limits that the walls before them take away.

        Parameters
        ----------
        q, v : (n,), rad, rad/s
        stable : (n,), N m s/rad
            Most damping that each joint bears.
        """
        above, below = q - self._highest, self._lowest - q
        if max(above.max(), below.max()) <= 0.0:
            return self._zero
        depth = np.maximum(above, 0.0) - np.maximum(below, 0.0)
        outward = np.where(depth * v > 0.0, v, 0.0)
        damping = np.minimum(WALL_DAMPING, stable)
        wall: Array = WALL_SHARE * self.arm.limits.torque / WALL_MARGIN * depth + damping * outward
        return wall


def stop_damping(arm: Arm) -> Array:
    """Damping (n,), N m s/rad, that brings an arm to rest, and keeps it slow under a load that no model knows."""
    damping: Array = STOP_SHARE * arm.limits.torque
    return damping


def guiding_torque(
    friction: JointFriction, v: Array, jacobian: Array, mass_matrix: Array | None = None, period: float = 0.0
) -> Array:
    """Torque (n,), N m, that lets a hand lead: see the formula of this module.

    Parameters
    ----------
    friction : JointFriction
    v : (n,), rad/s
    jacobian : (6, n)
    mass_matrix : (n, n), kg m^2, or None
        The damping is no more than this inertia bears; None does not ask.
    period : float, s
        For which the torque is held.

    Notes
    -----
    Held for a period h, damping D takes the share of the eigenvalues of h M^-1 D from the speed at once; a light wrist
    at 500 Hz swung with it, and passed its velocity limit.
    """
    null = np.linalg.svd(jacobian)[2][6:]
    lightening = FRICTION_SHARE * friction.coulomb * np.tanh(v / FRICTION_SPEED)
    damping = TEACH_DAMPING * v + SWIVEL_DAMPING * (null.T @ (null @ v))
    if mass_matrix is not None:
        damping *= _bearable(mass_matrix, null, period)
    torque: Array = lightening - damping
    return torque


def _bearable(mass_matrix: Array, null: Array, period: float) -> float:
    """Share of the guiding damping, in (0, 1], that takes at most `STABLE_SHARE` of any speed away in a period."""
    matrix = TEACH_DAMPING * np.eye(len(mass_matrix)) + SWIVEL_DAMPING * (null.T @ null)
    largest = float(np.abs(np.linalg.eigvals(np.linalg.solve(mass_matrix, matrix))).max())
    return min(1.0, STABLE_SHARE / max(period * largest, 1e-12))
