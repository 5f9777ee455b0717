r"""The payload of an arm, from a recording of a lift: least squares on the joint-torque residual.

A point mass m at c in the tool frame adds the torque :math:`J_v^T m a + J_\omega^T (R\, m c \times a)` with
:math:`a = \ddot x + g` of the tool, which is linear in (m, m c). What is left of the commanded torque when the model's
is taken away is fitted to it, each joint weighed by its friction, and less while it hardly moves, for then dry friction
may be anything. The center is drawn to the tool: it shows only in so far as the tool turns. Derivation ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pft_exec.control.friction import friction_torque
from pft_exec.exceptions import ControlError
from pft_exec.geometry import Array, read_only, rotation_matrix
from pft_exec.model import Arm, ArmDynamics

GRAVITY = 9.81
"""m/s^2."""
CENTER_DEVIATION = 0.05
"""m; how far from the tool a payload's center is expected."""
SLOW = 0.02
"""rad/s below which a joint's dry friction may be anything."""
SLOW_WEIGHT = 0.1
"""Weight of a joint that is that slow."""
WINDOW = 0.05
"""s over which velocities are differenced and torques averaged."""
_LEAST_FRICTION = 0.1  # N m
_ROWS = 20  # samples, at least


@dataclass(frozen=True, eq=False)
class PayloadEstimate:
    """A payload: ``arm.with_payload(estimate.mass, estimate.center)``.

    Parameters
    ----------
    mass : float, kg
    center : (3,), m
        In the tool frame.
    residual : float, N m
        Root mean square of the torque that it leaves unexplained.
    """

    mass: float
    center: Array
    residual: float


def estimate_payload(arm: Arm, time: Array, configuration: Array, velocity: Array, torque: Array) -> PayloadEstimate:
    """Estimate what an arm holds from how it moved, such as the rows of a log while an object was lifted.

    Parameters
    ----------
    arm : Arm
        Without the payload.
    time : (T,), s
    configuration, velocity : (T, n), rad, rad/s
        Measured.
    torque : (T, n), N m
        As commanded from each time on.

    Raises
    ------
    ControlError
        If the shapes do not fit, there are fewer than 20 samples, or a number is not finite.
    """
    _check(arm, time, configuration, velocity, torque)
    rows, residuals = [], []
    for window in _windows(time):
        first, last = window[0], window[-1]
        middle = window[len(window) // 2]
        acceleration = (velocity[last] - velocity[first]) / (time[last] - time[first])
        known = [_known_torque(arm, configuration[k], velocity[k], acceleration) for k in window[:-1]]
        residual = np.mean(torque[window[:-1]] - known, axis=0)
        weight = _trust(arm, velocity[middle])
        dynamics = arm.dynamics(configuration[middle], velocity[middle])
        rows.append(weight[:, None] * _regressor(dynamics, acceleration))
        residuals.append(weight * residual)
    return _fitted(np.array(rows), np.array(residuals), float(_trust(arm, np.ones(len(torque[0]))).mean()))


def _windows(time: Array) -> list[NDArray[np.intp]]:
    """Indices of samples, in stretches of `WINDOW`, s: the noise of one velocity is not to look like acceleration."""
    stretch = np.floor((time - time[0]) / WINDOW).astype(int)
    found = [np.flatnonzero(stretch == value) for value in np.unique(stretch)]
    windows = [np.append(window, window[-1] + 1) if window[-1] + 1 < len(time) else window for window in found]
    return [window for window in windows if len(window) > 1 and time[window[-1]] > time[window[0]]]


def _known_torque(arm: Arm, q: Array, v: Array, acceleration: Array) -> Array:
    """Motor torque (n,), N m, of the arm without payload."""
    dynamics = arm.dynamics(q, v)
    held = dynamics.bias - arm.counterbalance(q) + friction_torque(arm.friction, v)
    known: Array = dynamics.mass_matrix @ acceleration + held
    return known


def _trust(arm: Arm, velocity: Array) -> Array:
    """Weights (n,), 1/(N m), of the joints at a velocity (n,), rad/s."""
    trust: Array = np.where(np.abs(velocity) < SLOW, SLOW_WEIGHT, 1.0) / (arm.friction.coulomb + _LEAST_FRICTION)
    return trust


def _regressor(dynamics: ArmDynamics, acceleration: Array) -> Array:
    """Torques (n, 4), N m, of a kilogram at the tool and of a kilogram metre along each tool axis."""
    tool = dynamics.jacobian @ acceleration + dynamics.jacobian_drift
    felt = tool[:3] + np.array([0.0, 0.0, GRAVITY])
    turning = np.cross(rotation_matrix(dynamics.quaternion).T, felt)  # rows: each tool axis x what is felt
    regressor: Array = np.column_stack([dynamics.jacobian[:3].T @ felt, dynamics.jacobian[3:].T @ turning.T])
    return regressor


def _fitted(rows: Array, residuals: Array, trust: float) -> PayloadEstimate:
    """Least squares of (T, n, 4) on (T, n), with the center drawn to the tool."""
    matrix, vector = rows.reshape(-1, 4), residuals.ravel()
    square = matrix.T @ matrix
    prior = np.diag([0.0, 1.0, 1.0, 1.0]) / CENTER_DEVIATION**2
    mass, *moment = np.linalg.solve(square + prior + 1e-12 * np.eye(4), matrix.T @ vector)
    left = vector - matrix @ np.array([mass, *moment])
    center = np.array(moment) / mass if abs(mass) > 0.05 else np.zeros(3)  # below 50 g a center means nothing
    return PayloadEstimate(float(mass), read_only(center), float(np.sqrt(np.mean(left**2))) / trust)


def _check(arm: Arm, time: Array, *arrays: Array) -> None:
    shape = (len(time), len(arm.joint_names))
    if len(time) < _ROWS or any(np.shape(array) != shape for array in arrays):
        shapes = [np.shape(array) for array in arrays]
        raise ControlError(f"a lift has at least {_ROWS} samples of {shape[1]} joints; got {np.shape(time)}, {shapes}.")
    if not all(np.isfinite(array).all() for array in (time, *arrays)):
        raise ControlError("a lift must be finite: rad, rad/s and N m.")
