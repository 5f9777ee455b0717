"""One sample of Algorithm 4 of [Dong2012]_ for all tubes: the compiled kernel of ``method="dong2012"``.

The published algorithm keeps the matrices of the alignment and walks back along the path at each sample. The sum of log
likelihoods along the path and its length can be carried along the dynamic program instead, so that one column is all
that is kept; the tests compare this with the full matrices.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from pft_exec.recognition.elementary import take_logarithm


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
    p, q, r, s = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
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
def _square(delta, precision):  # type: ignore[no-untyped-def]
    square = 0.0
    for a in range(len(delta)):
        row = 0.0
        for b in range(len(delta)):
            row += precision[a, b] * delta[b]
        square += delta[a] * row
    return square


@njit(cache=True, error_model="numpy")
def _match(distance, time, deviation, log_deviation, now, distance_floor, score, spare):  # type: ignore[no-untyped-def]
    """Find n* (lines 2 to 5): the step that is near at a plausible time."""
    for n in range(len(distance)):
        score[n] = max(distance[n], distance_floor)
    take_logarithm(score, spare)
    for n in range(len(distance)):
        late = (now - time[n]) / deviation[n]
        score[n] += 0.5 * late * late + log_deviation[n]  # lines 3 and 4, up to a constant
    return np.argmin(score)  # line 5


@njit(cache=True, error_model="numpy")
def _add_column(begin, end, first, local, cost, total, steps):  # type: ignore[no-untyped-def]
    """Add a column to the alignment (line 6); ties go to diagonal, then tube, then time."""
    diagonal_cost, diagonal_total, diagonal_steps = np.inf, 0.0, 0.0
    for n in range(begin, end):
        least, carried, count = diagonal_cost, diagonal_total, diagonal_steps
        if n == begin and first:
            least, carried, count = 0.0, 0.0, 0.0
        if n > begin and cost[n - 1] < least:
            least, carried, count = cost[n - 1], total[n - 1], steps[n - 1]
        if not first and cost[n] < least:
            least, carried, count = cost[n], total[n], steps[n]
        diagonal_cost, diagonal_total, diagonal_steps = cost[n], total[n], steps[n]
        if first:
            diagonal_cost = np.inf
        cost[n] = local[0, n] + least
        total[n] = carried + local[1, n]
        steps[n] = count + 1.0


@njit(cache=True, error_model="numpy")
def align_sample(  # type: ignore[no-untyped-def]
    offset, length, mean, turn, precision, normalizer, timing, now, first, position, quaternion, distance_floor,
    cost, total, steps, local, match, likelihood,
):  # fmt: skip
    """Add one column to the alignment with every tube; write n* and the mean log likelihood along its path.

    Rows of `timing` are time, its deviation, and the logarithm of that. `local` is room for the distance of line 1, the
    log likelihood of the sample at each step, and two rows more.
    """
    delta = np.empty(precision.shape[1])
    for j in range(len(offset)):
        begin, end = offset[j], offset[j] + length[j]
        for n in range(begin, end):
            local[0, n] = _difference(position, quaternion, mean[n], turn[n], delta)  # line 1
            local[1, n] = normalizer[n] - 0.5 * _square(delta, precision[n])
        time, deviation, log_deviation = timing[0, begin:end], timing[1, begin:end], timing[2, begin:end]
        score, spare = local[2, begin:end], local[3, begin:end]
        chosen = begin + _match(local[0, begin:end], time, deviation, log_deviation, now, distance_floor, score, spare)
        _add_column(begin, end, first, local, cost, total, steps)
        match[j] = chosen - begin
        likelihood[j] = total[chosen] / steps[chosen]  # line 7, without the prior
