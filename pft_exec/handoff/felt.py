"""What the joints feel, compiled: it is computed in every control period, whoever has the arm."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pft_exec.geometry import Array
from pft_exec.geometry.definite import factorize, substitute_back, substitute_forward

SMOOTHING_SPEED = 0.05
"""rad/s; the sign of a slower measured velocity is uncertain."""


_LEAST_NOISE = 1e-10  # N^2 s^2; added in every direction


@njit(cache=True, fastmath=False)
def passive_torque(springs: Array, bias: Array, coulomb: Array, viscous: Array, v: Array) -> Array:
    """Torque (n,), N m, of everything but the motors and what is outside."""
    torque = np.empty(len(v))
    for k in range(len(v)):
        torque[k] = springs[k] - bias[k] - coulomb[k] * math.tanh(v[k] / SMOOTHING_SPEED) - viscous[k] * v[k]
    return torque


@njit(cache=True, fastmath=False)
def unexplained_torque(mass_matrix: Array, change: Array, passive: Array, torque: Array, period: float) -> Array:
    """Torque (n,), N m, that explains a change of velocity (n,), rad/s, in a control period, besides what is known."""
    rest = np.empty(len(change))
    for k in range(len(change)):
        inertial = 0.0
        for j in range(len(change)):
            inertial += mass_matrix[k, j] * change[j]
        rest[k] = inertial / period - passive[k] - torque[k]
    return rest


@njit(cache=True, fastmath=False)
def wrenches_of(mass_matrix: Array, jacobian: Array, torques: Array) -> Array:
    """Solve ``(J M^-1 J^T + eps) F = J M^-1 r`` for F (m, 6), N and N m, with torques r (m, n), N m."""
    factor = mass_matrix.copy()
    factorize(factor)
    rows = np.empty((6, len(factor)))  # L^-1 J^T, transposed
    square = 1e-9 * np.eye(6)
    for i in range(6):
        rows[i] = jacobian[i]
        substitute_forward(factor, rows[i])
        for k in range(len(factor)):
            for j in range(i + 1):
                square[i, j] += rows[i, k] * rows[j, k]
    factorize(square)
    wrenches, rest = np.zeros((len(torques), 6)), torques.copy()
    for m in range(len(torques)):
        substitute_forward(factor, rest[m])
        for i in range(6):
            for k in range(len(factor)):
                wrenches[m, i] += rows[i, k] * rest[m, k]
        substitute_forward(square, wrenches[m])
        substitute_back(square, wrenches[m])
    return wrenches


@njit(cache=True, fastmath=False)
def feel(
    residual: Array,
    share: float,
    before: tuple[Array, Array, Array],
    now: tuple[Array, Array, Array, Array, Array],
    friction: tuple[Array, Array],
    torque: Array,
    period: float,
) -> tuple[Array, Array, Array]:
    """One step of the observer.

    Parameters
    ----------
    residual, torque : (n,), N m
        Of the period before; the motors' in the period that ends now.
    share : float
        By which the residual follows; 0 leaves it.
    before : mass matrix (n, n), velocity (n,), passive torque (n,)
        Where the period began.
    now : mass matrix (n, n), bias (n,), Jacobian (6, n), springs (n,), velocity (n,)
    friction : (n,), (n,)
        Coulomb and viscous.
    period : float, s

    Returns
    -------
    residual : (n,)
    passive : (n,)
    wrenches : (2, 6)
        Of the residual, and of the period alone; the former's where the residual is left.
    """
    mass_matrix, bias, jacobian, springs, v = now
    torques = np.empty((2, len(v)))
    torques[0], torques[1] = residual, residual
    if share > 0.0:
        torques[1] = unexplained_torque(before[0], v - before[1], before[2], torque, period)
        torques[0] += share * (torques[1] - torques[0])
    passive = passive_torque(springs, bias, friction[0], friction[1], v)
    return torques[0].copy(), passive, wrenches_of(mass_matrix, jacobian, torques)


@njit(cache=True, fastmath=False)
def follow_means(mean: Array, mean_force: Array, variance: float, torque: Array, force: Array, share: float) -> float:
    """Let the means of torque (n,) and force (3,) follow, in place; the force's variance, N^2, about its mean."""
    for k in range(len(mean)):
        mean[k] += share * (torque[k] - mean[k])
    square = 0.0
    for k in range(len(mean_force)):
        mean_force[k] += share * (force[k] - mean_force[k])
        square += (force[k] - mean_force[k]) ** 2
    return variance + share * (square - variance)


@njit(cache=True, fastmath=False)
def gather(
    total: Array, before: Array, change: Array, force: Array, usual: Array, allowed: float, period: float
) -> float:
    """Add a force (3,), N, beyond what is usual for a period, s, to an impulse (3,), N s, but for what is allowed, N.

    In place; also of the force (3,) before, and of its change (3,), N. Returns the size of the impulse.
    """
    square = 0.0
    for k in range(len(total)):
        total[k] += period * (force[k] - usual[k])
        square += total[k] ** 2
        change[k] = force[k] - before[k]
        before[k] = force[k]
    size = math.sqrt(square)
    left = max(size - period * allowed, 0.0)
    for k in range(len(total)):
        total[k] *= left / max(size, 1e-12)
    return left


@njit(cache=True, fastmath=False)
def follow_scatter(scatter: Array, change: Array, share: float) -> None:
    """Let the scatter (3, 3), N^2, of changes (3,), N, follow by a share, in place."""
    for i in range(len(change)):
        for j in range(len(change)):
            scatter[i, j] += share * (change[i] * change[j] - scatter[i, j])


@njit(cache=True, fastmath=False)
def standing_out(total: Array, noise: Array) -> float:
    """Deviations of its noise (3, 3), N^2 s^2, by which an impulse (3,), N s, stands out."""
    factor, rest = noise.copy(), total.copy()
    for k in range(len(total)):
        factor[k, k] += _LEAST_NOISE
    factorize(factor)
    substitute_forward(factor, rest)
    square = 0.0
    for k in range(len(rest)):
        square += rest[k] ** 2
    return math.sqrt(square)


@njit(cache=True, fastmath=False)
def follow_within(mean: Array, force: Array, share: float, limit: float) -> Array:
    """A mean (3,), N, that follows a force (3,), N, by a share, as far as a limit, N."""
    after, square = np.empty(len(mean)), 0.0
    for k in range(len(mean)):
        after[k] = mean[k] + share * (force[k] - mean[k])
        square += after[k] ** 2
    return after * min(1.0, limit / max(math.sqrt(square), 1e-9))
