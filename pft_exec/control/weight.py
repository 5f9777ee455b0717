r"""The weight that the arm carries and its model does not know: estimated slowly, within bounds, and held.

What the joints do and what was commanded differ by the torque of forces from outside,

.. math:: \rho = M \frac{\Delta \dot q}{\Delta t} + h + f - \tau = J^T F ,

from which the wrench F at the tool follows by least squares, each joint weighed by its friction, which is what is
known worst. Its vertical part is a weight, if it lasts: a low pass of a second, between bounds. A person's force is
meant to move the arm and must not be cancelled: the horizontal parts and the moments are left alone, and while a
horizontal force of more than a few newtons is felt somebody is there, and the estimate rests.

Where the arm is taken over from a hand, the hand has borne the weight until now: nothing is known of it then, and much
half a second later. The rate at which the estimate follows is that of a Kalman-Bucy filter of a mass that wanders,

.. math:: \dot K = 1 / T^2 - K^2, \qquad K(0) = 1 / T_0,

from the short time :math:`T_0` in which a weight shows to the low pass of time T. Derivation ours.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pft_exec.geometry import Array
from pft_exec.geometry.definite import factorize, substitute_back, substitute_forward
from pft_exec.model import Arm, ArmDynamics

GRAVITY = 9.81
"""m/s^2."""
TIME_CONSTANT = 1.0
"""s; of the estimate: far longer than a push, far shorter than a motion."""
FIRST_TIME = 0.03
"""s; the same, where nothing is known."""
FEELING_TIME = 0.05
"""s; of the wrench by which a person is told from a weight."""
HORIZONTAL = 4.0
"""N; a horizontal force above this is a person's."""
BOUNDS = (-0.25, 0.75)
"""kg; a weight beyond these is not believed."""
_LEAST_FRICTION = 0.1  # N m; of a joint whose friction the model states as less


class WeightEstimate:
    """Estimates what mass, kg, the tool carries besides the model's.

    Parameters
    ----------
    arm : Arm
    """

    def __init__(self, arm: Arm) -> None:
        self.restart(arm)

    def restart(self, arm: Arm) -> None:
        """Forget everything: another model, or another task."""
        self._weights: Array = np.asarray(1.0 / (arm.friction.coulomb + _LEAST_FRICTION) ** 2, dtype=float)
        self._begin(1.0 / TIME_CONSTANT)

    def expect(self) -> None:
        """Nothing is known of the weight: somebody else has borne it until now."""
        self._begin(1.0 / FIRST_TIME)

    def _begin(self, rate: float) -> None:
        """Begin with no weight, and follow what is felt at a rate, 1/s."""
        self.mass, self._rate = 0.0, rate
        self.force: Array = np.zeros(3)
        self._before: tuple[float, Array, ArmDynamics, Array] | None = None

    def remember(self, time: float, v: Array, dynamics: ArmDynamics, missing: Array) -> None:
        """Remember a control period.

        Parameters
        ----------
        time : float, s
        v : (n,), rad/s
            At its beginning.
        dynamics : ArmDynamics
        missing : (n,), N m
            Bias, less counterbalance, plus friction, less the torque that was commanded.
        """
        self._before = (time, v.copy(), dynamics, missing)

    def forget(self) -> None:
        """The period that follows cannot be judged: somebody else moves the arm."""
        self._before = None

    def update(self, time: float, v: Array) -> float:
        """Mass, kg, after the velocity (n,), rad/s, that the remembered period led to."""
        if self._before is None or not 0.0 < time - self._before[0] < FEELING_TIME:
            return self.mass
        begin, before, dynamics, missing = self._before
        period = time - begin
        force = _felt(dynamics.mass_matrix, dynamics.jacobian, self._weights, v, before, missing, period)
        self.force += min(1.0, period / FEELING_TIME) * (force - self.force)
        if math.hypot(self.force[0], self.force[1]) < HORIZONTAL:
            found = min(max(-self.force[2] / GRAVITY, BOUNDS[0]), BOUNDS[1])
            self.mass += (1.0 - math.exp(-period * self._rate)) * (found - self.mass)
            self._rate += period * (TIME_CONSTANT**-2 - self._rate**2) / (1.0 + period * self._rate)
        return self.mass


@njit(cache=True, fastmath=False)
def _residual(mass_matrix: Array, acceleration: Array, missing: Array) -> Array:
    """Torque (n,), N m, that nothing known explains."""
    residual = missing.copy()
    for k in range(len(missing)):
        for j in range(len(missing)):
            residual[k] += mass_matrix[k, j] * acceleration[j]
    return residual


@njit(cache=True, fastmath=False)
def _force(jacobian: Array, weights: Array, residual: Array) -> Array:
    """Force (3,), N, of the wrench at the tool that explains a joint torque (n,), N m, best."""
    square, wrench = np.zeros((6, 6)), np.zeros(6)
    for i in range(6):
        for k in range(len(residual)):
            weighted = jacobian[i, k] * weights[k]
            wrench[i] += weighted * residual[k]
            for j in range(i + 1):
                square[i, j] += weighted * jacobian[j, k]
        square[i, i] += 1e-4 * square[i, i] + 1e-9
    factorize(square)
    substitute_forward(square, wrench)
    substitute_back(square, wrench)
    return wrench[:3]


@njit(cache=True, fastmath=False)
def _felt(
    mass_matrix: Array, jacobian: Array, weights: Array, v: Array, before: Array, missing: Array, period: float
) -> Array:
    """Force (3,), N, at the tool that explains a change of velocity (n,), rad/s, within a period, s."""
    return _force(jacobian, weights, _residual(mass_matrix, (v - before) / period, missing))


def weight_torque(mass: float, jacobian: Array) -> Array:
    """Torque (n,), N m, that holds a mass, kg, at the tool of a Jacobian (6, n)."""
    torque: Array = mass * GRAVITY * jacobian[2]
    return torque
