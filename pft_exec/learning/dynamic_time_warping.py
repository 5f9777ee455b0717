"""Dynamic time warping: which sample of one path corresponds to which of another, in compiled code.

In the flow: `alignment` warps the demonstrations of a motion to a common timeline. Exact, O(N M) in time; the paths are
resampled first, so that long recordings cost no more.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from pft_exec.geometry import Array


@njit(cache=True)
def _local_costs(first, second, first_turn, second_turn, turn_weight):  # type: ignore[no-untyped-def]
    count, other = len(first), len(second)
    costs = np.empty((count, other))
    for n in range(count):
        for m in range(other):
            square = 0.0
            for a in range(first.shape[1]):
                square += (first[n, a] - second[m, a]) ** 2
            if turn_weight > 0.0:
                cosine = 0.0
                for a in range(4):
                    cosine += first_turn[n, a] * second_turn[m, a]
                square += (turn_weight * 2.0 * np.arccos(min(abs(cosine), 1.0))) ** 2
            costs[n, m] = np.sqrt(square)
    return costs


@njit(cache=True)
def _accumulate(costs):  # type: ignore[no-untyped-def]
    count, other = costs.shape
    total = np.full((count + 1, other + 1), np.inf)
    total[0, 0] = 0.0
    for n in range(count):
        for m in range(other):
            before = min(total[n, m], total[n, m + 1], total[n + 1, m])
            total[n + 1, m + 1] = costs[n, m] + before
    return total


@njit(cache=True)
def _matched_means(total):  # type: ignore[no-untyped-def]
    count, other = total.shape[0] - 1, total.shape[1] - 1
    sums, hits = np.zeros(count), np.zeros(count)
    n, m = count - 1, other - 1
    while True:
        sums[n] += m
        hits[n] += 1.0
        if n == 0 and m == 0:
            break
        diagonal, up, left = total[n, m], total[n, m + 1], total[n + 1, m]
        if diagonal <= up and diagonal <= left:
            n, m = n - 1, m - 1
        elif up <= left:
            n -= 1
        else:
            m -= 1
    return sums / hits


def matched_samples(
    reference: Array,
    path: Array,
    reference_turn: Array | None = None,
    path_turn: Array | None = None,
    turn_weight: float = 0.0,
) -> Array:
    """Mean index of the samples of `path` that each sample of `reference` is aligned with.

    Parameters
    ----------
    reference : (N, D)
    path : (M, D)
        In the same unit and frame.
    reference_turn, path_turn : (N, 4), (M, 4), (x, y, z, w), or None
        Orientations, compared by their geodesic distance.
    turn_weight : float
        What 1 rad counts, in the unit of the paths.

    Returns
    -------
    (N,)
        Non-decreasing, in [0, M - 1].

    Notes
    -----
    Steps (1, 0), (0, 1), (1, 1) of equal weight; ties go to the diagonal, then along the reference.
    """
    none = np.empty((0, 4))
    has_turn = reference_turn is not None and path_turn is not None
    costs = _local_costs(
        np.ascontiguousarray(reference),
        np.ascontiguousarray(path),
        np.ascontiguousarray(reference_turn) if has_turn else none,
        np.ascontiguousarray(path_turn) if has_turn else none,
        turn_weight if has_turn else 0.0,
    )
    matched: Array = _matched_means(_accumulate(costs))
    return matched
