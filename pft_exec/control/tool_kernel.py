"""What a control period computes of the tool's error and target, compiled."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pft_exec.geometry import Array

_SMALL_SINE = 1e-6  # below it, angle / sine is 2 to double precision


@njit(cache=True, fastmath=False)
def matrix_of(quaternion: Array) -> Array:
    """Rotation matrix (3, 3) of a unit quaternion (4,), (x, y, z, w)."""
    x, y, z, w = quaternion
    matrix = np.empty((3, 3))
    matrix[0, 0], matrix[0, 1], matrix[0, 2] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    matrix[1, 0], matrix[1, 1], matrix[1, 2] = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    matrix[2, 0], matrix[2, 1], matrix[2, 2] = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    return matrix


@njit(cache=True, fastmath=False)
def rotation_vector(reference: Array, quaternion: Array) -> tuple[float, float, float]:
    """Rotation vector, rad, of ``reference^-1 * quaternion``, unit quaternions (4,), (x, y, z, w)."""
    a, b, c, d = -reference[0], -reference[1], -reference[2], reference[3]
    e, f, g, h = quaternion
    x, y, z = d * e + a * h + b * g - c * f, d * f - a * g + b * h + c * e, d * g + a * f - b * e + c * h
    w = d * h - a * e - b * f - c * g
    sine = math.sqrt(x * x + y * y + z * z)
    ratio = 2.0 if sine <= _SMALL_SINE else 2.0 * math.atan2(sine, abs(w)) / sine
    if w < 0.0:
        ratio = -ratio
    return ratio * x, ratio * y, ratio * z


@njit(cache=True, fastmath=False)
def error_of(
    measured: tuple[Array, Array, Array], position: Array, quaternion: Array, rotation: Array, velocity: Array
) -> Array:
    """Error (12,) of a measured position (3,), quaternion (4,), velocity (6,) from those of a reference.

    `rotation` (3, 3) is the reference's. Base axes but for the angular parts, in the tool axes of the reference.
    """
    error = np.empty(12)
    error[3:6] = rotation_vector(quaternion, measured[1])
    for i in range(3):
        error[i] = measured[0][i] - position[i]
        error[6 + i] = measured[2][i] - velocity[i]
        error[9 + i] = 0.0
        for j in range(3):
            error[9 + i] += rotation[j, i] * (measured[2][3 + j] - velocity[3 + j])
    return error


@njit(cache=True, fastmath=False)
def between(values: Array, phase: float) -> Array:
    """Matrix between those (N, i, j) that are evenly spaced in phase, held beyond either end."""
    place = min(max(phase, 0.0), 1.0) * (len(values) - 1)
    index = min(int(place), len(values) - 2)
    matrix: Array = values[index] + (place - index) * (values[index + 1] - values[index])
    return matrix


@njit(cache=True, fastmath=False)
def turn_rows(rotation: Array, matrix: Array) -> None:
    """Turn the last three rows of a matrix (6, m) by a rotation (3, 3), in place."""
    for j in range(matrix.shape[1]):
        x, y, z = matrix[3, j], matrix[4, j], matrix[5, j]
        for i in range(3):
            matrix[3 + i, j] = rotation[i, 0] * x + rotation[i, 1] * y + rotation[i, 2] * z


@njit(cache=True, fastmath=False)
def weight_in_base(rotation: Array, weight: Array) -> Array:
    """Weight (6, 6) with angular rows and columns turned from tool into base axes."""
    turned = weight.copy()
    turn_rows(rotation, turned)
    turn_rows(rotation, turned.T)
    return turned


@njit(cache=True, fastmath=False)
def corrected(rotation: Array, acceleration: Array, gain: Array, error: Array) -> Array:
    """Tool acceleration (6,), base frame: a target's, less what a gain (6, 12) makes of an error (12,)."""
    answer = np.zeros((6, 1))
    for i in range(6):
        for k in range(12):
            answer[i, 0] += gain[i, k] * error[k]
    turn_rows(rotation, answer)
    return acceleration - answer[:, 0]


@njit(cache=True, fastmath=False)
def cost_of_missing(jacobian: Array, missing: Array, weight: Array) -> tuple[Array, Array, float]:
    """H (n, n), c (n,) and constant of ``1/2 |J x + missing|^2_W``, with missing (6,) and W (6, 6)."""
    n = jacobian.shape[1]
    H, c, constant = np.zeros((n, n)), np.zeros(n), 0.0
    for i in range(6):
        weighted = 0.0
        for j in range(6):
            weighted += weight[i, j] * missing[j]
        constant += 0.5 * missing[i] * weighted
        for k in range(n):
            c[k] += jacobian[i, k] * weighted
    for k in range(n):
        for i in range(6):
            weighted = 0.0
            for j in range(6):
                weighted += jacobian[j, k] * weight[j, i]
            for m in range(n):
                H[k, m] += weighted * jacobian[i, m]
    return H, c, constant


@njit(cache=True, fastmath=False)
def aim(
    compliance: tuple[Array, Array],
    phase: float,
    target: tuple[Array, Array],
    error: Array,
    jacobian: Array,
    drift: Array,
) -> tuple[Array, Array, float]:
    """Cost of not following a tool target.

    Parameters
    ----------
    compliance : gains (N, 6, 12) and weights (N, 6, 6), evenly in phase
    phase : float
    target : rotation (3, 3) and acceleration (6,)
    error : (12,)
    jacobian, drift : (6, n) and (6,)
        Of the measured tool.

    Returns
    -------
    H (n, n), c (n,), constant
    """
    rotation, acceleration = target
    weight = weight_in_base(rotation, between(compliance[1], phase))
    wanted = corrected(rotation, acceleration, between(compliance[0], phase), error)
    return cost_of_missing(jacobian, drift - wanted, weight)
