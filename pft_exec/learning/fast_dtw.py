"""FastDTW: approximate dynamic time warping in linear time and memory [Salvador2007]_.

In the flow: what [Dong2012]_, Algorithm 3 aligns with. Two sequences are halved until they are short, aligned exactly,
and the path is refined from level to level inside a window of some cells around it.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pft_exec.geometry import Array

RADIUS = 1  # cells around the projected path; [Dong2012]_ does not say, the inventors begin with 1


@njit(cache=True)
def _windowed_path(first, second, low, high):  # type: ignore[no-untyped-def]
    """Warping path (L, 2) through the cells low[n] <= m < high[n]."""
    count, width = first.shape
    offset = np.zeros(count + 1, dtype=np.int64)
    for n in range(count):
        offset[n + 1] = offset[n] + high[n] - low[n]
    total = np.full(offset[count], np.inf)
    step = np.zeros(offset[count], dtype=np.int8)
    for n in range(count):
        for m in range(low[n], high[n]):
            cost = 0.0
            for a in range(width):
                cost += (first[n, a] - second[m, a]) ** 2
            here = offset[n] + m - low[n]
            best, move = np.inf, 0
            if n == 0 and m == 0:
                best = 0.0
            if n > 0 and low[n - 1] <= m - 1 < high[n - 1]:
                best, move = total[offset[n - 1] + m - 1 - low[n - 1]], 0
            if n > 0 and low[n - 1] <= m < high[n - 1] and total[offset[n - 1] + m - low[n - 1]] < best:
                best, move = total[offset[n - 1] + m - low[n - 1]], 1
            if m > low[n] and total[here - 1] < best:
                best, move = total[here - 1], 2
            total[here] = best + np.sqrt(cost)
            step[here] = move
    path = np.empty((count + len(second), 2), dtype=np.int64)
    n, m, length = count - 1, len(second) - 1, 0
    while True:
        path[length, 0], path[length, 1] = n, m
        length += 1
        if n == 0 and m == 0:
            break
        move = step[offset[n] + m - low[n]]
        if move != 2:
            n -= 1
        if move != 1:
            m -= 1
    return path[:length][::-1].copy()


@njit(cache=True)
def _project(path, count, other, radius):  # type: ignore[no-untyped-def]
    """Rows' windows at twice the resolution: the cells of a coarse path, and `radius` coarse cells around them."""
    rows = path[-1, 0] + 1
    coarse_low, coarse_high = np.full(rows, other, dtype=np.int64), np.zeros(rows, dtype=np.int64)
    for index in range(len(path)):
        n, m = path[index]
        for row in range(max(n - radius, 0), min(n + radius + 1, rows)):
            coarse_low[row] = min(coarse_low[row], m - radius)
            coarse_high[row] = max(coarse_high[row], m + radius + 1)
    low, high = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    for n in range(count):
        row = min(n // 2, rows - 1)
        low[n] = min(max(2 * coarse_low[row], 0), other - 1)
        high[n] = min(2 * coarse_high[row], other)
    low[0], high[count - 1] = 0, other
    for n in range(1, count):
        low[n] = min(low[n], high[n - 1] - 1)
        high[n] = max(high[n], high[n - 1])
    return low, high


def _halved(values: Array) -> Array:
    """Means of neighbouring rows; an odd last row is left to the finer level."""
    even = len(values) // 2 * 2
    half: Array = 0.5 * (values[0:even:2] + values[1:even:2])
    return half


def align_fast(first: Array, second: Array, radius: int = RADIUS) -> NDArray[np.int64]:
    """Warping path of two sequences.

    Parameters
    ----------
    first : (N, D)
    second : (M, D)
        Compared by Euclidean distance; steps (1, 0), (0, 1), (1, 1) of equal weight; ties go to the diagonal, then
        along `first`.
    radius : int
        Cells around the projected path that are searched; the larger, the nearer to exact.

    Returns
    -------
    (L, 2)
        Indices into the two, from (0, 0) to (N - 1, M - 1); max(N, M) <= L <= N + M - 1.
    """
    levels = [(np.ascontiguousarray(first), np.ascontiguousarray(second))]
    while min(len(levels[-1][0]), len(levels[-1][1])) > 2 * (radius + 2):
        levels.append((_halved(levels[-1][0]), _halved(levels[-1][1])))
    coarse, other = levels[-1]
    low = np.zeros(len(coarse), dtype=np.int64)
    path: NDArray[np.int64] = _windowed_path(coarse, other, low, low + len(other))
    for fine, wide in reversed(levels[:-1]):
        path = _windowed_path(fine, wide, *_project(path, len(fine), len(wide), radius))
    return path
