"""One sample through the forward filters of all tubes: the compiled kernel of ``method="phase"``.

All tubes lie packed behind one another: component j owns ``length[j]`` states from ``offset[j]`` on, one a step.
A plain numpy version of the same sums stands beside the tests.
"""

from __future__ import annotations

import numpy as np
from numba import njit

NEGLIGIBLE = 1e-14  # probability below which a state is dropped


@njit(cache=True, fastmath=True, error_model="numpy")
def _predict(state, spare, first, count, low, high, steps, prior, switch, idle):  # type: ignore[no-untyped-def]
    """One step of time: the pace may change, then the phase goes on by 0, 1, 2, ... steps. Returns the new window."""
    rates, sizes = steps.shape
    top = min(high + sizes - 1, count - 1)
    for r in range(rates):
        for i in range(low, top + 1):
            spare[r, i] = 0.0
    for i in range(low, high + 1):
        total = 0.0
        for r in range(rates):
            total += state[r, first + i]
        if total < NEGLIGIBLE:
            continue
        for r in range(rates):
            mass = (1.0 - switch) * state[r, first + i] + switch * prior[r] * total
            if i == 0:
                spare[r, 0] += idle * mass
                share = (1.0 - idle) * mass / (1.0 - steps[r, 0])
                for s in range(1, sizes):
                    spare[r, min(s, count - 1)] += share * steps[r, s]
            elif i + sizes <= count:
                for s in range(sizes):
                    spare[r, i + s] += mass * steps[r, s]
            else:
                for s in range(sizes):
                    spare[r, min(i + s, count - 1)] += mass * steps[r, s]
    for r in range(rates):
        for i in range(low, top + 1):
            state[r, first + i] = spare[r, i]
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
    sample, signals, heard, log_scale, extra, size, freedom, elapsed, weight,
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
            square[i] = half * np.log1p(square[i] / freedom[j])
            score[i] = weight * (log_scale[i] + extra[i] - square[i])
            top = max(top, score[i])
        total, phase, remaining, distance = 0.0, 0.0, 0.0, 0.0
        for i in range(begin, end):
            factor = np.exp(score[i] - top)
            mass = 0.0
            for r in range(rates):
                state[r, i] *= factor
                mass += state[r, i]
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
            if mass >= NEGLIGIBLE:
                break
            for r in range(rates):
                state[r, first + lowest] = 0.0
            lowest += 1
        while highest > lowest:
            mass = 0.0
            for r in range(rates):
                mass += state[r, first + highest]
            if mass >= NEGLIGIBLE:
                break
            for r in range(rates):
                state[r, first + highest] = 0.0
            highest -= 1
        low[j], high[j] = lowest, highest
        out[0, j] = top + np.log(total)
        out[1, j] = phase * inverse / max(count - 1, 1)
        out[2, j] = remaining * inverse
        out[3, j] = distance * inverse
