"""What a control period makes of its objectives and limits, and of its solution, compiled.

The same as `objectives`, `limits` and `assemble` say one by one; those are for whoever puts a program together.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pft_exec.control.limits import largest_acceleration
from pft_exec.geometry import Array


@njit(cache=True, fastmath=False)
def draw_to(
    configuration: Array, velocity: Array, acceleration: Array, q: Array, v: Array, aside: Array, stiffness: float
) -> Array:
    """Joint accelerations (n,), rad/s^2, that draw q, v to a reference, critically damped, and a step aside (n,)."""
    damping, drawn = 2.0 * math.sqrt(stiffness), np.empty(len(q))
    for k in range(len(q)):
        towards = stiffness * (configuration[k] - q[k]) + damping * (velocity[k] - v[k])
        drawn[k] = acceleration[k] + towards + aside[k]
    return drawn


@njit(cache=True, fastmath=False)
def compose(
    tracking: tuple[Array, Array],
    posture: Array,
    weight: float,
    load: Array,
    box: Array,
    period: float,
    q: Array,
    v: Array,
) -> tuple[Array, Array, Array, Array]:
    """Cost H (n, n), c (n,) and limits (2n,), (2n,) of a control period.

    Parameters
    ----------
    tracking : H (n, n), c (n,)
    posture : (n,), rad/s^2
        Accelerations wanted with a weight beside the tracking.
    weight : float
    load : (n,), N m
        What the motors must hold besides inertia.
    box : (5, n)
        Limits of torque, of the configuration from below and above, of velocity and acceleration.
    period : float, s
    q, v : (n,), rad, rad/s

    Notes
    -----
    The first n limits are of the accelerations themselves, the others of the torque's rows.
    """
    n = len(q)
    torque, least, most, speed, hardest = box[0], box[1], box[2], box[3], box[4]
    H, c = tracking[0].copy(), tracking[1] - weight * posture
    lower, upper = np.empty(2 * n), np.empty(2 * n)
    for k in range(n):
        H[k, k] += weight
        upper[k] = largest_acceleration(most[k] - q[k], v[k], speed[k], hardest[k], period)
        lower[k] = min(-largest_acceleration(q[k] - least[k], -v[k], speed[k], hardest[k], period), upper[k])
        lower[n + k], upper[n + k] = -torque[k] - load[k], torque[k] - load[k]
    return H, c, lower, upper


@njit(cache=True, fastmath=False)
def conclude(
    x: Array,
    multipliers: Array,
    tracking: tuple[Array, Array],
    posture: Array,
    weight: float,
    mass_matrix: Array,
    load: Array,
    limit: Array,
    active: float,
) -> tuple[Array, NDArray[np.bool_], float, float]:
    """Motor torque (n,), N m, active rows (2n,), and what tracking (but for its constant) and posture cost at x (n,).

    Parameters
    ----------
    x : (n,), rad/s^2
    multipliers : (m,)
        The first 2n are looked at.
    tracking, posture, weight, load
        As of `compose`.
    mass_matrix : (n, n), kg m^2
    limit : (n,), N m
        The torque keeps it already, but for the solver's rounding.
    active : float
        A multiplier above this makes its row active.
    """
    n = len(x)
    torque, is_active = np.empty(n), np.empty(2 * n, dtype=np.bool_)
    following, keeping = 0.0, 0.0
    for k in range(n):
        inertial, curved = 0.0, 0.0
        for j in range(n):
            inertial += mass_matrix[k, j] * x[j]
            curved += tracking[0][k, j] * x[j]
        torque[k] = min(max(inertial + load[k], -limit[k]), limit[k])
        following += x[k] * (0.5 * curved + tracking[1][k])
        keeping += 0.5 * weight * (x[k] - posture[k]) ** 2
        is_active[k], is_active[n + k] = abs(multipliers[k]) > active, abs(multipliers[n + k]) > active
    return torque, is_active, following, keeping
