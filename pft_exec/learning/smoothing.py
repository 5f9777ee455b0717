"""Averages over neighbouring steps with Gaussian weights, compiled.

By a loop over the band of weights that count, not by a product of matrices: a threaded library of linear algebra takes
longer to wake its threads than to average a hundred steps, most of all on a computer that is busy.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numba import njit

from pft_exec.geometry import Array, read_only

REACH = 8.8  # deviations, beyond which a weight is lost in rounding


@lru_cache(maxsize=32)
def _weights(count: int, width: float) -> Array:
    """Weights (N, N), read-only, of every step in the average at each, with a deviation of `width` steps."""
    steps = np.arange(count)
    weights = np.exp(-0.5 * ((steps[:, None] - steps[None, :]) / max(width, 1e-9)) ** 2)
    return read_only(weights / weights.sum(axis=1, keepdims=True))


@njit(cache=True, fastmath=False)
def _average(values, weights, reach):  # type: ignore[no-untyped-def]
    """Averages (N, P) of values (N, P) by weights (N, N) that reach `reach` steps."""
    steps, columns = values.shape
    averaged = np.zeros((steps, columns))
    for n in range(steps):
        for m in range(max(n - reach, 0), min(n + reach + 1, steps)):
            weight = weights[n, m]
            for p in range(columns):
                averaged[n, p] += weight * values[m, p]
    return averaged


def smoothed(values: Array, width: float) -> Array:
    """Values (N, ...) averaged over the steps around each, with Gaussian weights of deviation `width` steps."""
    steps = len(values)
    flat = np.ascontiguousarray(values).reshape(steps, -1)
    averaged: Array = _average(flat, _weights(steps, width), int(np.ceil(REACH * width)))
    return averaged.reshape(values.shape)
