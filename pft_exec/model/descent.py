r"""Damped least squares on the tool's pose: one descent from a start to the nearest solution inside the limits.

One step is

.. math:: \Delta q = z + J^T (J J^T + \lambda^2 I)^{-1} (e - J z), \quad \lambda^2 = c \, e^T e + \lambda_0^2

with `e` the pose error (6,), rotations weighed by a lever, and `z` the pull towards the posture, which acts in the null
space and fades with the error. Damping that vanishes with the error is of [Sugihara2011]_; a joint that meets its
limit stops there and the others take over its share, as in [Flacco2012]_.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio
from numba import njit
from numpy.typing import NDArray

from pft_exec.geometry import Array
from pft_exec.model.arm import Arm

Flags = NDArray[np.bool_]

LEVER = 0.3  # m per rad; about a forearm, so that both halves of the error weigh alike
_DAMPING = 1e-2  # c
_LEAST_DAMPING = 1e-12  # lambda_0 squared, m^2; keeps a singular step finite
_PULL = 0.3  # share of the way to the posture that one iteration goes while the error is large
_PULL_FADES = 0.05  # m; below this error the pull fades in proportion
_LARGEST_STEP = 0.5  # rad in one iteration
_SMALL_ENOUGH = 2e-7  # m; weighted error at which a descent ends
_PATIENCE = 8  # iterations without progress after which it gives up


class Descent(NamedTuple):
    """Where a descent ended: configuration (n,), error (6,) m and rad, Jacobian (6, n), weighted error m."""

    configuration: Array
    error: Array
    jacobian: Array
    size: float


def descend(arm: Arm, goal: tuple[Array, Array], start: Array, posture: Array, iterations: int) -> Descent:
    """Descend from `start` to `goal`, position (3,) and rotation matrix (3, 3) in the base frame; keeps the best."""
    best = here = _looked_at(arm, goal, start)
    stale = 0
    for _ in range(iterations):
        if best.size < _SMALL_ENOUGH or stale > _PATIENCE:
            break
        here = _looked_at(arm, goal, here.configuration + _step(arm, here, posture))
        stale = 0 if here.size < 0.99 * best.size else stale + 1
        best = here if here.size < best.size else best
    return best


def _looked_at(arm: Arm, goal: tuple[Array, Array], q: Array) -> Descent:
    position, rotation, jacobian = arm.kinematics(q)
    turn = pinocchio.log3(goal[1] @ rotation.T)
    error, size = _pose_error(goal[0], position, turn)
    return Descent(q, error, jacobian, size)


def _step(arm: Arm, here: Descent, posture: Array) -> Array:
    limits = arm.limits
    step: Array = bounded_step(
        here.jacobian, here.error, here.size, here.configuration, posture, limits.lower, limits.upper
    )
    return step


@njit(cache=True)
def _pose_error(goal: Array, position: Array, turn: Array) -> tuple[Array, float]:
    error = np.empty(6)
    size = 0.0
    for i in range(3):
        error[i] = goal[i] - position[i]
        error[3 + i] = turn[i]
        size += error[i] ** 2 + (LEVER * turn[i]) ** 2
    return error, np.sqrt(size)


@njit(cache=True)
def bounded_step(
    jacobian: Array, error: Array, size: float, q: Array, posture: Array, lower: Array, upper: Array
) -> Array:
    """One step (n,), rad, between the limits: joints that would leave stop there, the others take over their share.

    Parameters
    ----------
    jacobian, error : (6, n) and (6,)
        Of the tool; linear, then angular, base frame.
    size : float, m
        Weighted norm of the error.
    q, posture, lower, upper : (n,), rad
    """
    count = len(q)
    damping = _DAMPING * size * size + _LEAST_DAMPING
    pull = (posture - q) * (_PULL * min(1.0, size / _PULL_FADES))
    step = np.zeros(count)
    is_free = np.ones(count, dtype=np.bool_)
    for _ in range(count):
        _damped_step(jacobian, error, pull, damping, is_free, step)
        if not _stop_at_limits(q, lower, upper, is_free, step):
            break
    return step


@njit(cache=True)
def _stop_at_limits(q: Array, lower: Array, upper: Array, is_free: Flags, step: Array) -> bool:
    """Stop joints whose step leaves the limits, in place; whether any joint was stopped."""
    largest = 0.0
    for i in range(len(q)):
        largest = max(largest, abs(step[i])) if is_free[i] else largest
    shrink = min(1.0, _LARGEST_STEP / largest) if largest > 0.0 else 1.0
    is_stopped = False
    for i in range(len(q)):
        if is_free[i]:
            step[i] *= shrink
            bounded = min(max(step[i], lower[i] - q[i]), upper[i] - q[i])
            if bounded != step[i]:
                step[i], is_free[i], is_stopped = bounded, False, True
    return is_stopped


@njit(cache=True)
def _damped_step(jacobian: Array, error: Array, pull: Array, damping: float, is_free: Flags, step: Array) -> None:
    """Write into `step` the damped step of the free joints, given the steps of the stopped ones."""
    squared = np.zeros((6, 6))
    rest = np.empty(6)
    for i in range(6):
        weight = 1.0 if i < 3 else LEVER
        rest[i] = weight * error[i]
        for k in range(len(step)):
            rest[i] -= weight * jacobian[i, k] * (pull[k] if is_free[k] else step[k])
        for j in range(i + 1):
            total = damping if i == j else 0.0
            for k in range(len(step)):
                if is_free[k]:
                    total += jacobian[i, k] * jacobian[j, k] * weight * (1.0 if j < 3 else LEVER)
            squared[i, j] = total
    _solve_in_place(squared, rest)
    for k in range(len(step)):
        if is_free[k]:
            step[k] = pull[k]
            for i in range(6):
                step[k] += jacobian[i, k] * rest[i] * (1.0 if i < 3 else LEVER)


@njit(cache=True)
def _solve_in_place(lower: Array, vector: Array) -> None:
    """Solve ``A x = vector`` for symmetric positive definite A, lower half given, by its Cholesky factor."""
    count = len(vector)
    for j in range(count):
        for k in range(j):
            lower[j, j] -= lower[j, k] ** 2
        lower[j, j] = np.sqrt(max(lower[j, j], 1e-30))
        for i in range(j + 1, count):
            for k in range(j):
                lower[i, j] -= lower[i, k] * lower[j, k]
            lower[i, j] /= lower[j, j]
        for k in range(j):
            vector[j] -= lower[j, k] * vector[k]
        vector[j] /= lower[j, j]
    for j in range(count - 1, -1, -1):
        for i in range(j + 1, count):
            vector[j] -= lower[i, j] * vector[i]
        vector[j] /= lower[j, j]
