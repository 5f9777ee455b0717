"""How probable the hand's way so far is, given one motion of the planar world: compiled.

The chances of a trial (`planar_hand`) are many and the samples sharp, so that drawing them from their law would never
meet the samples. They are drawn near the most probable ones instead and weighed: damped Gauss-Newton steps find these,
the curvature there is the law drawn from, and the mean of true density over that of the draw is the probability of the
prefix, without bias.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from pft_exec.evaluation.baselines.planar_hand import place_hand

_STEP = 1e-4  # of a finite difference
_MOST_DAMPING = 1e6
_ROUNDS = 20  # of Gauss-Newton steps, at most
_ENOUGH = 1e-3  # twice the log density that a step must gain for another


@njit(cache=True, error_model="numpy")
def _cost(trial, time, seen, noise, center, precision, z, path):  # type: ignore[no-untyped-def]
    """Twice the negative log density, but for constants, of chances `z` (d,) and samples `seen` (T, 2)."""
    kind, start, places, scatter, style, pausing = trial
    place_hand(kind, start, places, scatter, style, pausing, z, time, path)
    total = 0.0
    for t in range(len(time)):
        variance = noise[0] ** 2 + (noise[1] * path[t, 2]) ** 2
        square = (seen[t, 0] - path[t, 0]) ** 2 + (seen[t, 1] - path[t, 1]) ** 2
        total += square / variance + 2.0 * np.log(variance)
    for i in range(len(z)):
        total += precision[i] * (z[i] - center[i]) ** 2
    return total


@njit(cache=True, error_model="numpy")
def _linearize(trial, time, seen, noise, center, precision, z, path):  # type: ignore[no-untyped-def]
    """Curvature (d, d) and negative gradient (d,) of half the cost at `z`, where the noise is what it is there."""
    kind, start, places, scatter, style, pausing = trial
    size, count = len(z), len(time)
    slopes, moved, left = np.empty((size, 2 * count)), np.empty((count, 3)), np.empty(2 * count)
    place_hand(kind, start, places, scatter, style, pausing, z, time, path)
    deviation = np.sqrt(noise[0] ** 2 + (noise[1] * path[:, 2]) ** 2)
    for i in range(size):
        kept = z[i]
        z[i] = kept + _STEP
        place_hand(kind, start, places, scatter, style, pausing, z, time, moved)
        z[i] = kept
        for a in range(2):
            slopes[i, a::2] = (moved[:, a] - path[:, a]) / (_STEP * deviation)
    for a in range(2):
        left[a::2] = (seen[:, a] - path[:, a]) / deviation
    curvature = slopes @ slopes.T + np.diag(precision)
    descent = slopes @ left - precision * (z - center)
    return curvature, descent


@njit(cache=True, error_model="numpy")
def _climb(trial, time, seen, noise, center, precision, z, path):  # type: ignore[no-untyped-def]
    """Improve `z` in place by damped Gauss-Newton steps; returns the cost where they end."""
    damping = 1e-3
    cost = _cost(trial, time, seen, noise, center, precision, z, path)
    for _ in range(_ROUNDS):
        curvature, descent = _linearize(trial, time, seen, noise, center, precision, z, path)
        gained = 0.0
        while damping < _MOST_DAMPING:
            tried = z + np.linalg.solve(curvature + damping * np.diag(np.diag(curvature)), descent)
            new = _cost(trial, time, seen, noise, center, precision, tried, path)
            if new < cost:
                gained, cost, damping = cost - new, new, 0.1 * damping
                z[:] = tried
                break
            damping *= 10.0
        if gained < _ENOUGH:
            break
    return cost


@njit(cache=True, error_model="numpy")
def weigh_prefix(trial, cell, time, seen, noise, starts, draws, z):  # type: ignore[no-untyped-def]
    """Log density of samples `seen` (T, 2) under one motion and one cell of pauses, but for a constant of all motions.

    Parameters
    ----------
    trial : tuple
        The first six arguments of `place_hand`.
    cell : (2, 2)
        Least (row 0) and greatest of the two chances of a pause.
    noise : (2,)
        Standard deviation of a reading, and of the tremor, in units of the world.
    starts : (K, d)
        Where searches for the most probable chances begin.
    draws : (S, d)
        Standard normal.
    z : (d,)
        The most probable chances are written here.
    """
    pausing, size = trial[5], len(z)
    center, precision = np.zeros(size), np.ones(size)
    center[3:5], precision[3:5] = 0.5 * (cell[0] + cell[1]), 12.0 / (cell[1] - cell[0]) ** 2
    path, least = np.empty((len(time), 3)), np.inf
    for k in range(len(starts)):
        tried = starts[k].copy()
        cost = _climb(trial, time, seen, noise, center, precision, tried, path)
        if cost < least:
            least = cost
            z[:] = tried
    curvature, _ = _linearize(trial, time, seen, noise, center, precision, z, path)
    factor = np.ascontiguousarray(np.linalg.inv(np.linalg.cholesky(curvature)).T)
    log_volume = np.log(np.abs(np.diag(factor))).sum()
    if pausing:
        precision[3:5] = 0.0  # even within the cell
    logs = np.empty(len(draws))
    for s in range(len(draws)):
        drawn = z + factor @ draws[s]
        inside = not pausing or ((drawn[3:5] >= cell[0]) & (drawn[3:5] <= cell[1])).all()
        half = 0.5 * _cost(trial, time, seen, noise, center, precision, drawn, path)
        logs[s] = 0.5 * (draws[s] ** 2).sum() + log_volume - half if inside else -1e300
    top = logs.max()
    constant = np.log(2.0 * np.pi) if pausing else np.log(12.0)  # of two chances that are even, not normal
    return top + np.log(np.exp(logs - top).mean()) + constant
