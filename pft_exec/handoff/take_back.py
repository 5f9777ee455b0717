r"""Taking back: the person's force at the tool, felt in the joints, ends the robot's authority.

No force sensor is needed. What the motors, springs, friction and gravity do not explain of the joints' motion must come
from outside:

.. math:: r \leftarrow r + (1 - e^{-\lambda h})\,(M \tfrac{\Delta v}{h} + b - \tau - \tau_{cb} + f - r),

the generalized momentum observer [DeLuca2005]_ in discrete time, with control period h and bandwidth :math:`\lambda`.
The force at the tool is the least-squares solution of :math:`J^T F = r`, weighed by the inverse inertia. The low pass
costs a strong push several milliseconds, which `SuddenPush` does without.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pft_exec.exceptions import ControlError
from pft_exec.geometry import Array
from pft_exec.handoff.felt import feel, follow_within, wrenches_of
from pft_exec.handoff.sudden_push import SuddenPush
from pft_exec.model import Arm, ArmDynamics

BANDWIDTH = 220.0
"""1/s; half of a sudden force is seen after 3 ms."""
THRESHOLD = 15.0
"""N; a friction error of a fifth is felt as 4 N, half a kilogram of unknown payload as 7 N (measured)."""
HOLD_TIME = 0.002
"""s for which the force must last: an impact is shorter."""
USUAL_TIME = 0.3
"""s over which a force that lasts becomes usual."""
USUAL_LIMIT = 10.0
"""N; more than this never becomes usual: one kilogram that nobody told of."""


@dataclass(frozen=True, eq=False)
class ExternalForce:
    """What the arm feels from outside.

    Parameters
    ----------
    torque : (n,), N m
        At the joints.
    force : (3,), N
        At the tool, base frame.
    moment : (3,), N m
        At the tool, base frame.
    sudden : (3,), N
        The force of the last control period alone: at once, but with all the noise.
    """

    torque: Array
    force: Array
    moment: Array
    sudden: Array


class ForceObserver:
    """Estimate the force from outside, once per control period.

    Parameters
    ----------
    arm : Arm
    control_period : float, s
    bandwidth : float, 1/s

    Raises
    ------
    ControlError
        If period or bandwidth is not positive.
    """

    def __init__(self, arm: Arm, control_period: float, bandwidth: float = BANDWIDTH) -> None:
        if not (control_period > 0.0 and bandwidth > 0.0):
            raise ControlError(
                f"control period (s) and bandwidth (1/s) must be positive; got {control_period}, {bandwidth}."
            )
        self.arm = arm
        self.control_period = control_period
        self._share = 1.0 - math.exp(-bandwidth * control_period)
        self._residual = np.zeros(len(arm.joint_names))
        self._friction = arm.friction.coulomb, arm.friction.viscous
        self._before: tuple[Array, Array, Array] | None = None
        """At the last call: mass matrix, velocity, torque of all but the motors."""
        self._estimate = ExternalForce(self._residual, *np.zeros((3, 3)))

    def update(self, q: Array, v: Array, torque: Array | None) -> ExternalForce:
        """Estimate from a measured state and the motor torque that led to it.

        Parameters
        ----------
        q, v : (n,), rad, rad/s
            Measured now; one that is not finite leaves the estimate as it is.
        torque : (n,), N m, or None
            Commanded in the control period that ends now; None where it is not known.
        """
        if not math.isfinite(q.dot(v)):  # of any number that is not finite, neither is the product
            self._before = None
            self._estimate = replace(self._estimate, sudden=self._estimate.force)
            return self._estimate
        dynamics = self.arm.dynamics(q, v)
        speed = v.copy()
        now = dynamics.mass_matrix, dynamics.bias, dynamics.jacobian, self.arm.counterbalance(q), speed
        if self._before is None or torque is None:
            share, before, torque = 0.0, (dynamics.mass_matrix, speed, self._residual), self._residual
        else:
            share, before = self._share, self._before
        felt = feel(self._residual, share, before, now, self._friction, torque, self.control_period)
        self._residual, passive, (smooth, alone) = felt
        self._before = dynamics.mass_matrix, speed, passive
        self._estimate = ExternalForce(self._residual, smooth[:3], smooth[3:], alone[:3])
        return self._estimate


def tool_wrench(dynamics: ArmDynamics, torque: Array) -> Array:
    """Wrench (6,) at the tool, N and N m, base frame, that explains joint torques (n,) best."""
    wrench: Array = wrenches_of(dynamics.mass_matrix, dynamics.jacobian, torque[None])[0]
    return wrench


class TakeBack:
    """Notice that the person takes the arm back.

    What lasts is not a person but a model that is wrong (a payload that nobody told of, friction): the mean of the last
    moments, up to a limit, is taken off. A push counts from the threshold on, one that grows slowly at the latest from
    threshold and limit together. While the hand that led still lets go, nothing counts.

    A push that is told period by period, unsmoothed, counts as soon as its impulse beyond the threshold stands out.

    Parameters
    ----------
    threshold : float, N
    hold_time : float, s

    Raises
    ------
    ControlError
        If the threshold is not positive or the time negative.
    """

    def __init__(self, threshold: float = THRESHOLD, hold_time: float = HOLD_TIME) -> None:
        if not (threshold > 0.0 and hold_time >= 0.0):
            raise ControlError(
                f"threshold (N) must be positive and hold time (s) not negative; got {threshold}, {hold_time}."
            )
        self.threshold = threshold
        self.hold_time = hold_time
        self.usual: Array = np.zeros(3)
        """(3,), N: the part of the force that lasts."""
        self._since: float | None = None
        self._before: float | None = None
        self._waits_until = -math.inf
        self._sudden = SuddenPush(hold_time)

    def wait(self, until: float) -> None:
        """Let nothing count until the force has been small once, or until a time, s."""
        self._waits_until = until
        self._since, self._before, self.usual = None, None, np.zeros(3)
        self._sudden.forget()

    def resume(self, usual: Array, threshold: float) -> None:
        """Begin again with a force (3,), N, that is usual, and another threshold, N."""
        self.threshold, self.usual = threshold, follow_within(usual, usual, 0.0, USUAL_LIMIT)
        self._since, self._before, self._waits_until = None, None, -math.inf
        self._sudden.forget()

    def update(self, time: float, force: Array, sudden: Array | None = None) -> bool:
        """Whether the person takes back.

        Parameters
        ----------
        time : float, s
        force : (3,), N
            Felt, base frame; counts when it has been above the threshold for the hold time.
        sudden : (3,), N, or None
            Of the last control period alone.
        """
        is_strong = math.dist(force.tolist(), self.usual.tolist()) >= self.threshold
        if time < self._waits_until:
            self._waits_until = self._waits_until if is_strong else -math.inf
            return False
        is_sudden = sudden is not None and self._sudden.update(time, sudden, self.usual, self.threshold)
        if not is_strong:
            self._get_used_to(time, force)
            self._since = None
            return is_sudden
        self._since = time if self._since is None else self._since
        return is_sudden or time - self._since >= self.hold_time - 1e-9

    def _get_used_to(self, time: float, force: Array) -> None:
        elapsed = 0.0 if self._before is None else time - self._before
        share = 1.0 - math.exp(-elapsed / USUAL_TIME)
        self.usual = follow_within(self.usual, force, share, USUAL_LIMIT)
        self._before = time
