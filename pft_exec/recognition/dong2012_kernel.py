"""One sample of Algorithm 4 of [Dong2012]_ for all tubes: the compiled kernel of ``method="dong2012"``.

The published algorithm keeps the matrices of the alignment and walks back along the path at each sample. The sum of log
likelihoods along the path and its length can be carried along the dynamic program instead, so that one column is all
that is kept; the tests compare this with the full matrices.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def _difference(position, quaternion, mean, turn, delta):  # type: ignore[no-untyped-def]
    """Write (position, rotation vector of mean^-1 * sample) into `delta`; return the raw distance of line 1."""
    square = 0.0
    for a in range(3):
        delta[a] = position[a] - mean[a]
        square += delta[a] ** 2
    if len(delta) == 3:
        return np.sqrt(square)
    x, y, z, w = -turn[0], -turn[1], -turn[2], turn[3]
    p, q, r, s = quaternion
    real = w * s - x * p - y * q - z * r
    sign = -1.0 if real < 0.0 else 1.0
    for a in range(4):
        square += (sign * quaternion[a] - turn[a]) ** 2
    delta[3] = sign * (w * p + x * s + y * r - z * q)
    delta[4] = sign * (w * q - x * r + y * s + z * p)
    delta[5] = sign * (w * r + x * q - y * p + z * s)
    sine = np.sqrt(delta[3] ** 2 + delta[4] ** 2 + delta[5] ** 2)
    ratio = 2.0 * np.arctan2(sine, sign * real) / sine if sine > 1e-9 else 2.0
    for a in range(3, 6):
        delta[a] *= ratio
    return np.sqrt(square)


@njit(cache=True, error_model="numpy")
def align_sample(  # type: ignore[no-untyped-def]
    offset, length, mean, turn, precision, normalizer, time, deviation,
    now, first, position, quaternion, distance_floor, cost, total, steps, local, here, match, likelihood,
):  # fmt: skip
    """Add one column to the alignment with every tube; write n* and the mean log likelihood along its path."""
    size = precision.shape[1]
    delta = np.empty(size)
    for j in range(len(offset)):
        start, end = offset[j], offset[j] + length[j]
        best = np.inf
        for n in range(start, end):
            distance = _difference(position, quaternion, mean[n], turn[n], delta)
            square = 0.0
            for a in range(size):
                row = 0.0
                for b in range(size):
                    row += precision[n, a, b] * delta[b]
                square += delta[a] * row
            local[n] = distance  # line 1
            here[n] = normalizer[n] - 0.5 * square
            log_density = -0.5 * ((now - time[n]) / deviation[n]) ** 2 - np.log(deviation[n])  # line 2
            weighted = np.log(max(distance, distance_floor)) - log_density  # lines 3 and 4, up to a constant
            if weighted < best:
                best = weighted
                match[j] = n - start  # line 5
        diagonal_cost, diagonal_total, diagonal_steps = np.inf, 0.0, 0.0
        for n in range(start, end):  # line 6: one column; ties go to diagonal, then tube, then time
            least, carried, count = diagonal_cost, diagonal_total, diagonal_steps
            if n == start and first:
                least, carried, count = 0.0, 0.0, 0.0
            if n > start and cost[n - 1] < least:
                least, carried, count = cost[n - 1], total[n - 1], steps[n - 1]
            if not first and cost[n] < least:
                least, carried, count = cost[n], total[n], steps[n]
            diagonal_cost, diagonal_total, diagonal_steps = cost[n], total[n], steps[n]
            if first:
                diagonal_cost = np.inf
            cost[n] = local[n] + least
            total[n] = carried + here[n]
            steps[n] = count + 1.0
        chosen = start + match[j]
        likelihood[j] = total[chosen] / steps[chosen]  # line 7, without the prior
