"""One sample through the forward filters of all tubes: the compiled kernel of ``method="phase"``.

All tubes lie packed behind one another: component j owns ``length[j]`` states from ``offset[j]`` on, one a step.
A plain numpy version of the same sums stands beside the tests.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, fastmath=True, error_model="numpy")
def _predict(state, spare, first, count, low, high, steps, prior, switch, idle):  # type: ignore[no-untyped-def]
    """One tick: the pace may change, then the phase goes on by 0, 1, 2, ... steps. Returns the window's new end."""
    rates, sizes = steps.shape
    reach = sizes - 1
    top, width = min(high + reach, count - 1), high - low + 1
    total = spare[rates]
    for k in range(width):
        total[k] = 0.0
    for r in range(rates):
        for k in range(width):
            total[k] += state[r, first + low + k]
    for r in range(rates):
        mixed, step = spare[r], steps[r]
        for k in range(reach):
            mixed[k] = 0.0
            mixed[reach + width + k] = 0.0
        for k in range(width):
            mixed[reach + k] = (1.0 - switch) * state[r, first + low + k] + switch * prior[r] * total[k]
        waiting = mixed[reach] if low == 0 else 0.0
        if low == 0:
            mixed[reach] = 0.0
        row = state[r, first + low : first + top + 1]
        for k in range(len(row)):
            row[k] = step[0] * mixed[reach + k]
        for s in range(1, sizes):
            earlier = mixed[reach - s : reach - s + len(row)]
            for k in range(len(row)):
                row[k] += step[s] * earlier[k]
        for i in range(max(low, count - reach), high + 1):
            for s in range(count - i, sizes):
                state[r, first + count - 1] += step[s] * mixed[reach + i - low]
        if low == 0:
            share = (1.0 - idle) * waiting / (1.0 - step[0])
            state[r, first] += idle * waiting
            for s in range(1, sizes):
                state[r, first + min(s, count - 1)] += share * step[s]
    return top


@njit(cache=True, fastmath=True, error_model="numpy")
def _square_distances(begin, end, sample, mean, white, turned, use, square):  # type: ignore[no-untyped-def]
    """Squared Mahalanobis distances of the sample (position, direction, quaternion) from states begin to end - 1."""
    for i in range(begin, end):
        x, y, z = sample[0] - mean[0, i], sample[1] - mean[1, i], sample[2] - mean[2, i]
        a = white[0, i] * x
        b = white[1, i] * x + white[2, i] * y
        c = white[3, i] * x + white[4, i] * y + white[5, i] * z
        square[i] = a * a + b * b + c * c
    for i in range(begin, end):
        x, y, z = sample[3] - mean[3, i], sample[4] - mean[4, i], sample[5] - mean[5, i]
        a = white[6, i] * x
        b = white[7, i] * x + white[8, i] * y
        c = white[9, i] * x + white[10, i] * y + white[11, i] * z
        square[i] += a * a + b * b + c * c
    if use:
        qx, qy, qz, qw = sample[6], sample[7], sample[8], sample[9]
        for i in range(begin, end):
            mx, my, mz, mw = turned[0, i], turned[1, i], turned[2, i], turned[3, i]
            w = mw * qw + mx * qx + my * qy + mz * qz
            sign = 2.0 if w >= 0.0 else -2.0
            x = sign * (mw * qx - mx * qw - my * qz + mz * qy)
            y = sign * (mw * qy - my * qw - mz * qx + mx * qz)
            z = sign * (mw * qz - mz * qw - mx * qy + my * qx)
            a = white[12, i] * x
            b = white[13, i] * x + white[14, i] * y
            c = white[15, i] * x + white[16, i] * y + white[17, i] * z
            square[i] += a * a + b * b + c * c


@njit(cache=True, fastmath=True, error_model="numpy")
def filter_sample(  # type: ignore[no-untyped-def]
    offset, length, mean, white, turned, left, signal_mean, signal_scale, steps, prior, switch, idle, tick,
    sample, signals, heard, log_scale, extra, size, freedom, elapsed, weight, negligible,
    state, spare, square, score, pending, low, high, out,
):  # fmt: skip
    """Filter one sample through every component; `out` rows: log evidence, phase, time left (s), mean distance."""
    rates = state.shape[0]
    use = sample[6] * sample[6] + sample[7] * sample[7] + sample[8] * sample[8] + sample[9] * sample[9] > 0.0
    for j in range(len(offset)):
        first, count = offset[j], length[j]
        pending[j] += elapsed
        ticks = min(int(pending[j] / tick[j]), count)
        pending[j] = min(pending[j] - ticks * tick[j], tick[j])
        for _ in range(ticks):
            high[j] = _predict(state, spare, first, count, low[j], high[j], steps[j], prior, switch[j], idle[j])
        begin, end = first + low[j], first + high[j] + 1
        _square_distances(begin, end, sample, mean, white, turned, use, square)
        for c in range(len(signals)):
            if heard[c]:
                for i in range(begin, end):
                    square[i] += ((signals[c] - signal_mean[c, i]) * signal_scale[c, i]) ** 2
        top = -1e300
        half = 0.5 * (freedom[j] + size)
        for i in range(begin, end):
            mass = 0.0
            for r in range(rates):
                mass += state[r, i]
            if mass <= negligible:
                for r in range(rates):
                    state[r, i] = 0.0
                continue
            square[i] = half * np.log1p(square[i] / freedom[j])
            score[i] = weight * (log_scale[i] + extra[i] - square[i])
            top = max(top, score[i])
        total, phase, remaining, distance = 0.0, 0.0, 0.0, 0.0
        for i in range(begin, end):
            mass = 0.0
            for r in range(rates):
                mass += state[r, i]
            if mass == 0.0:
                continue
            factor = np.exp(score[i] - top)
            for r in range(rates):
                state[r, i] *= factor
            mass *= factor
            total += mass
            phase += mass * (i - first)
            remaining += mass * left[i]
            distance += mass * square[i]
        inverse = 1.0 / total
        for r in range(rates):
            for i in range(begin, end):
                state[r, i] *= inverse
        lowest, highest = low[j], high[j]
        while lowest < highest:
            mass = 0.0
            for r in range(rates):
                mass += state[r, first + lowest]
            if mass > 0.0:
                break
            lowest += 1
        while highest > lowest:
            mass = 0.0
            for r in range(rates):
                mass += state[r, first + highest]
            if mass > 0.0:
                break
            highest -= 1
        low[j], high[j] = lowest, highest
        out[0, j] = top + np.log(total)
        out[1, j] = phase * inverse / max(count - 1, 1)
        out[2, j] = remaining * inverse
        out[3, j] = distance * inverse
