"""One sample through the forward filters of all tubes: the compiled kernel of ``method="phase"``.

All tubes lie packed behind one another: component j owns ``length[j]`` states from ``offset[j]`` on, one a step, of
which those in a window from ``low[j]`` to ``high[j]`` are possible. Each loop runs along a row of that window, without
a branch, so that the compiler makes vector instructions of it. A plain numpy version of the same sums stands beside
the tests.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from pft_exec.recognition.elementary import exponentiate, take_logarithm

REACH = 5  # the most steps in one tick
ROWS = 6  # of spare room: slower, mixed (between `REACH` zeros), score, spent, for the logarithm, mass


@njit(cache=True, fastmath=True, error_model="numpy")
def _sum_rates(state, begin, end, total):  # type: ignore[no-untyped-def]
    """Write the probability of each phase, whatever the pace, to `total`."""
    total[:] = state[0, begin:end]
    for r in range(1, len(state)):
        row = state[r, begin:end]
        for k in range(len(total)):
            total[k] += row[k]


@njit(cache=True, fastmath=True, error_model="numpy")
def _mix(slower, row, faster, change, mixed):  # type: ignore[no-untyped-def]
    """Write one pace's phases after people changed pace to `mixed`, between zeros; `slower` becomes this pace's."""
    width = len(slower)
    for k in range(REACH):
        mixed[k] = 0.0
        mixed[REACH + width + k] = 0.0
    moved = mixed[REACH : REACH + width]
    gained, kept, lost = change[0], change[1], change[2]
    for k in range(width):
        now = row[k]
        moved[k] = gained * slower[k] + kept * now + lost * faster[k]
        slower[k] = now


@njit(cache=True, fastmath=True, error_model="numpy")
def _advance(mixed, step, row):  # type: ignore[no-untyped-def]
    """Go on by 0 to `REACH` steps: `row` is the convolution of `mixed` with the probabilities of the steps."""
    s0, s1, s2, s3, s4, s5 = step[0], step[1], step[2], step[3], step[4], step[5]
    for k in range(len(row)):
        near = s0 * mixed[k + 5] + s1 * mixed[k + 4] + s2 * mixed[k + 3]
        row[k] = near + (s3 * mixed[k + 2] + s4 * mixed[k + 1] + s5 * mixed[k])


@njit(cache=True, fastmath=True, error_model="numpy")
def _stop_at_end(mixed, step, row, low, high, count):  # type: ignore[no-untyped-def]
    """Steps that lead beyond the end lead to the end."""
    for i in range(max(low, count - REACH), high + 1):
        for s in range(count - i, REACH + 1):
            row[count - 1 - low] += step[s] * mixed[REACH + i - low]


@njit(cache=True, fastmath=True, error_model="numpy")
def _leave_start(waiting, step, idle, row, count):  # type: ignore[no-untyped-def]
    """Those at the very start wait there with probability `idle`."""
    share = (1.0 - idle) * waiting / (1.0 - step[0])
    row[0] += idle * waiting
    for s in range(1, REACH + 1):
        row[min(s, count - 1)] += share * step[s]


@njit(cache=True, fastmath=True, error_model="numpy")
def _predict(state, first, count, low, high, steps, change, idle, spare):  # type: ignore[no-untyped-def]
    """One tick: the pace may change, then the phase goes on by 0, 1, 2, ... steps. Returns the window's new end."""
    top, begin = min(high + REACH, count - 1), first + low
    slower, mixed, end = spare[0, : high - low + 1], spare[1], first + high + 1
    slower[:] = 0.0
    for r in range(len(state)):
        row = state[r, begin : first + top + 1]
        faster = state[min(r + 1, len(state) - 1), begin:end]
        _mix(slower, row, faster, change[r], mixed)
        waiting = mixed[REACH]
        if low == 0:
            mixed[REACH] = 0.0
        _advance(mixed, steps[r], row)
        _stop_at_end(mixed, steps[r], row, low, high, count)
        if low == 0:
            _leave_start(waiting, steps[r], idle, row, count)
    return top


@njit(cache=True, fastmath=True, error_model="numpy")
def _add_position(sample, begin, end, mean, white, square):  # type: ignore[no-untyped-def]
    """Add squared Mahalanobis distances of the position from the states of a window."""
    x, y, z = sample[0], sample[1], sample[2]
    mx, my, mz = mean[0, begin:end], mean[1, begin:end], mean[2, begin:end]
    xx, xy, yy = white[0, begin:end], white[1, begin:end], white[2, begin:end]
    xz, yz, zz = white[3, begin:end], white[4, begin:end], white[5, begin:end]
    for k in range(len(square)):
        p, q, r = x - mx[k], y - my[k], z - mz[k]
        a = xx[k] * p
        b = xy[k] * p + yy[k] * q
        c = xz[k] * p + yz[k] * q + zz[k] * r
        square[k] += a * a + b * b + c * c


@njit(cache=True, fastmath=True, error_model="numpy")
def _add_direction(sample, begin, end, mean, white, gain, square):  # type: ignore[no-untyped-def]
    """Add squared Mahalanobis distances of the direction from what the position lets expect at each state."""
    x, y, z, dx, dy, dz = sample[0], sample[1], sample[2], sample[3], sample[4], sample[5]
    mx, my, mz = mean[0, begin:end], mean[1, begin:end], mean[2, begin:end]
    nx, ny, nz = mean[3, begin:end], mean[4, begin:end], mean[5, begin:end]
    xx, xy, yy = white[6, begin:end], white[7, begin:end], white[8, begin:end]
    xz, yz, zz = white[9, begin:end], white[10, begin:end], white[11, begin:end]
    g0, g1, g2 = gain[0, begin:end], gain[1, begin:end], gain[2, begin:end]
    g3, g4, g5 = gain[3, begin:end], gain[4, begin:end], gain[5, begin:end]
    g6, g7, g8 = gain[6, begin:end], gain[7, begin:end], gain[8, begin:end]
    for k in range(len(square)):
        u, v, w = x - mx[k], y - my[k], z - mz[k]
        p = dx - nx[k] - (g0[k] * u + g1[k] * v + g2[k] * w)
        q = dy - ny[k] - (g3[k] * u + g4[k] * v + g5[k] * w)
        r = dz - nz[k] - (g6[k] * u + g7[k] * v + g8[k] * w)
        a = xx[k] * p
        b = xy[k] * p + yy[k] * q
        c = xz[k] * p + yz[k] * q + zz[k] * r
        square[k] += a * a + b * b + c * c


@njit(cache=True, fastmath=True, error_model="numpy")
def _add_turn(quaternion, begin, end, turned, white, square):  # type: ignore[no-untyped-def]
    """Add squared Mahalanobis distances of a quaternion: of twice the vector part of mean^-1 * sample."""
    x, y, z, w = 2.0 * quaternion[0], 2.0 * quaternion[1], 2.0 * quaternion[2], 2.0 * quaternion[3]
    tx, ty, tz, tw = turned[0, begin:end], turned[1, begin:end], turned[2, begin:end], turned[3, begin:end]
    xx, xy, yy = white[12, begin:end], white[13, begin:end], white[14, begin:end]
    xz, yz, zz = white[15, begin:end], white[16, begin:end], white[17, begin:end]
    for k in range(len(square)):
        p = tw[k] * x - tx[k] * w - ty[k] * z + tz[k] * y  # its sign does not matter: it is squared
        q = tw[k] * y - ty[k] * w - tz[k] * x + tx[k] * z
        r = tw[k] * z - tz[k] * w - tx[k] * y + ty[k] * x
        a = xx[k] * p
        b = xy[k] * p + yy[k] * q
        c = xz[k] * p + yz[k] * q + zz[k] * r
        square[k] += a * a + b * b + c * c


@njit(cache=True, fastmath=True, error_model="numpy")
def _add_signal(value, mean, scale, square):  # type: ignore[no-untyped-def]
    for k in range(len(square)):
        square[k] += ((value - mean[k]) * scale[k]) ** 2


@njit(cache=True, error_model="numpy")
def _square(begin, end, sample, mean, white, gain, turned, signals, heard, signal_mean, signal_scale, square):  # type: ignore[no-untyped-def]
    """Write squared Mahalanobis distances of position, direction, quaternion and signals from states of a window."""
    square[:] = 0.0
    _add_position(sample, begin, end, mean, white, square)
    _add_direction(sample, begin, end, mean, white, gain, square)
    if np.any(sample[6:10] != 0.0):
        _add_turn(sample[6:10], begin, end, turned, white, square)
    for c in range(len(signals)):
        if heard[c]:
            _add_signal(signals[c], signal_mean[c, begin:end], signal_scale[c, begin:end], square)


@njit(cache=True, fastmath=True, error_model="numpy")
def _spend(square, freedom, half, spare):  # type: ignore[no-untyped-def]
    """Replace squared distances by what they cost under a Student t: (freedom + size) / 2 log(1 + d^2 / freedom)."""
    inverse = 1.0 / freedom
    for k in range(len(square)):
        square[k] = 1.0 + square[k] * inverse
    take_logarithm(square, spare)
    for k in range(len(square)):
        square[k] *= half


@njit(cache=True, fastmath=True, error_model="numpy")
def _weigh(mass, spent, log_scale, extra, weight, negligible, factor, spare):  # type: ignore[no-untyped-def]
    """Write factors by which phases gain to `factor`, none for negligible ones. Returns the log of their unit."""
    top = -1e300
    for k in range(len(mass)):
        factor[k] = weight * (log_scale[k] + extra[k] - spent[k])
    for k in range(len(mass)):
        top = max(top, factor[k] if mass[k] > negligible else -1e300)
    for k in range(len(mass)):
        factor[k] = min(factor[k] - top, 0.0)
    exponentiate(factor, spare)
    for k in range(len(mass)):
        factor[k] = factor[k] if mass[k] > negligible else 0.0
    return top


@njit(cache=True, fastmath=True, error_model="numpy")
def _sum_up(mass, factor, left):  # type: ignore[no-untyped-def]
    """Multiply masses by factors; their sum, and sums weighted by them: steps from the window's begin, time left."""
    total, phase, remaining = 0.0, 0.0, 0.0
    for k in range(len(mass)):
        mass[k] *= factor[k]
        total += mass[k]
        phase += mass[k] * k
        remaining += mass[k] * left[k]
    return total, phase, remaining


@njit(cache=True, fastmath=True, error_model="numpy")
def _sum_products(mass, factor, values):  # type: ignore[no-untyped-def]
    """Sums of masses times factors, and of these times values."""
    total, weighted = 0.0, 0.0
    for k in range(len(mass)):
        here = mass[k] * factor[k]
        total += here
        weighted += here * values[k]
    return total, weighted


@njit(cache=True, fastmath=True, error_model="numpy")
def _condition(state, begin, end, factor, inverse):  # type: ignore[no-untyped-def]
    """Multiply each phase by its factor, and make all sum to 1."""
    for k in range(len(factor)):
        factor[k] *= inverse
    for r in range(len(state)):
        row = state[r, begin:end]
        for k in range(len(factor)):
            row[k] *= factor[k]


@njit(cache=True, error_model="numpy")
def _possible(mass, low, high):  # type: ignore[no-untyped-def]
    """The window without the phases at its ends that have no mass."""
    begin = low
    while begin < high and mass[begin - low] <= 0.0:
        begin += 1
    while high > begin and mass[high - low] <= 0.0:
        high -= 1
    return begin, high


@njit(cache=True, error_model="numpy")
def filter_sample(  # type: ignore[no-untyped-def]
    offset, length, mean, white, gain, turned, left, signal_mean, signal_scale, steps, change, idle, tick,
    sample, signals, heard, log_scale, extra, speed, size, freedom, elapsed, weight, negligible, placing, present,
    state, spare, pending, low, high, out,
):  # fmt: skip
    """Filter one sample through every component.

    `speed` (S,) is the density of the present speed. Rows of `out`: log evidence, phase, time left (s), mean distance,
    and what the sample says now: log of the mean, over where the hand may be, of its speed's density times its own to
    the power `present`.
    """
    for j in range(len(offset)):
        first, count = offset[j], length[j]
        pending[j] += elapsed
        ticks = min(int(pending[j] / tick[j]), count)
        pending[j] = min(pending[j] - ticks * tick[j], tick[j])
        for _ in range(ticks):
            high[j] = _predict(state, first, count, low[j], high[j], steps[j], change[j], idle[j], spare)
        begin, end = first + low[j], first + high[j] + 1
        mass, score, spent = spare[5, : end - begin], spare[2, : end - begin], spare[3, : end - begin]
        room, scale, said = spare[4], log_scale[begin:end], extra[begin:end]
        _sum_rates(state, begin, end, mass)
        _square(begin, end, sample, mean, white, gain, turned, signals, heard, signal_mean, signal_scale, spent)
        _spend(spent, freedom[j], 0.5 * (freedom[j] + size), room)
        top = _weigh(mass, spent, scale, said, weight, negligible, score, room)
        total, phase, remaining = _sum_up(mass, score, left[begin:end])
        _condition(state, begin, end, score, 1.0 / total)
        out[0, j] = top + np.log(total)
        out[1, j] = min((low[j] + phase / total) / max(count - 1, 1), 1.0)
        out[2, j] = remaining / total
        _weigh(mass, spent, scale, said, placing, 0.0, score, room)
        near, distance = _sum_products(mass, score, spent)
        out[3, j] = distance / near
        top = _weigh(mass, spent, scale, said, present, 0.0, score, room)
        out[4, j] = top + np.log(_sum_products(mass, score, speed[begin:end])[1] / total)
        low[j], high[j] = _possible(mass, low[j], high[j])
