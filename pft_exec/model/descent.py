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

from pft_exec.geometry import Array
from pft_exec.model.arm import Arm

LEVER = 0.3  # m per rad; about a forearm, so that both halves of the error weigh alike
_WEIGHT = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])
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
    error = np.empty(6)
    error[:3] = goal[0] - position
    error[3:] = pinocchio.log3(goal[1] @ rotation.T)
    weighted = error * _WEIGHT
    return Descent(q, error, jacobian, float(np.sqrt(weighted @ weighted)))


def _step(arm: Arm, here: Descent, posture: Array) -> Array:
    q, limits = here.configuration, arm.limits
    error, jacobian = here.error * _WEIGHT, here.jacobian * _WEIGHT[:, None]
    damping = _DAMPING * here.size**2 + _LEAST_DAMPING
    pull = _PULL * min(1.0, here.size / _PULL_FADES) * (posture - q)
    step = _damped(jacobian, error, pull, damping)
    step *= min(1.0, _LARGEST_STEP / float(np.abs(step).max() + 1e-300))
    down, up = limits.lower - q, limits.upper - q
    if (step >= down).all() and (step <= up).all():
        return step
    return _within(jacobian, error, pull, damping, down, up)


def _damped(jacobian: Array, error: Array, pull: Array, damping: float) -> Array:
    squared = jacobian @ jacobian.T
    squared.flat[::7] += damping
    step: Array = pull + jacobian.T @ np.linalg.solve(squared, error - jacobian @ pull)
    return step


def _within(jacobian: Array, error: Array, pull: Array, damping: float, down: Array, up: Array) -> Array:
    """Step between `down` and `up`: joints that would leave stop there, the others take over their share."""
    is_free = np.ones(len(pull), dtype=bool)
    fixed = np.zeros(len(pull))
    for _ in range(len(pull)):
        step = np.where(is_free, _damped(jacobian * is_free, error - jacobian @ fixed, pull * is_free, damping), fixed)
        bounded = np.clip(step, np.maximum(down, -_LARGEST_STEP), np.minimum(up, _LARGEST_STEP))
        leaving = is_free & (bounded != step)
        if not leaving.any():
            break
        fixed = np.where(leaving, bounded, fixed)
        is_free &= ~leaving
    return bounded
