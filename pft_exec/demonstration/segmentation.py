"""Segmentation: pieces of a recording, its discrete changes, and a recording without its idle ends."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pft_exec.demonstration.demonstration import Demonstration
from pft_exec.geometry import Array

IDLE_SPEED = 0.02  # of the greatest smoothed speed; a resting hand's tremor stays below, the slowest motion above
IDLE_WINDOW = 0.02  # of the duration over which speed is measured, so that tremor and quantization average out
SUDDEN = 8.0  # times its median speed: a signal that changes faster does something; noise and a steady drift do not
LEVEL = 0.05  # of its greatest size: a signal that changes by less does nothing; a held thing settles between the pads


def split_at_keyframes(demonstration: Demonstration) -> list[Demonstration]:
    """The pieces between keyframes, each a demonstration labelled ``label/1``, ``label/2``, ...

    Neighbours share the sample at the keyframe, so that each piece begins where the last one ends
    ([Dong2012]_, section 4.1). A demonstration without keyframes is returned as it is.
    """
    if not demonstration.keyframes:
        return [demonstration]
    cuts = [int(index) for index in np.searchsorted(demonstration.time, demonstration.keyframes)]
    return _pieces(demonstration, cuts)


def split_at_discrete_changes(demonstration: Demonstration) -> list[Demonstration]:
    """The pieces between changes of any discrete signal, labelled ``label/1``, ``label/2``, ...

    A change at sample n ends a piece there and begins the next. A demonstration in which nothing changes is
    returned as it is.
    """
    changes = discrete_changes(demonstration)
    return _pieces(demonstration, [int(index) for index in changes]) if len(changes) else [demonstration]


def discrete_changes(demonstration: Demonstration) -> NDArray[np.int64]:
    """Samples (M,) at which a discrete signal has another value than one sample before, increasing."""
    changed = np.zeros(len(demonstration), dtype=bool)
    for values in demonstration.discrete.values():
        changed[1:] |= np.diff(values) != 0
    return np.flatnonzero(changed).astype(np.int64)


def moving_range(demonstration: Demonstration) -> tuple[int, int]:
    """First and one past the last sample of the motion itself, idle ends left out; at least two samples.

    Idle means slower than `IDLE_SPEED` of the greatest speed, over `IDLE_WINDOW` of the duration, in position and in
    orientation alike, while no discrete signal changes and no continuous one changes to another level at more than
    `SUDDEN` times its usual speed: a gripper that closes while the tool rests is part of the motion. A recording in
    which nothing moves or changes is all motion.
    """
    window = _window(demonstration.time)
    busy = (_speed(demonstration, window) > IDLE_SPEED) | _sudden(demonstration, window)
    changes = discrete_changes(demonstration)
    busy[changes] = busy[changes - 1] = True
    if not busy.any():
        return 0, len(demonstration)
    moving = np.flatnonzero(busy)
    start, stop = int(moving[0]), int(moving[-1]) + 1
    start = min(start, len(demonstration) - 2)
    return start, max(stop, start + 2)


def without_idle_ends(demonstration: Demonstration) -> Demonstration:
    """The demonstration from the first to the last sample that moves; times stay as they were recorded."""
    return demonstration.segment(*moving_range(demonstration))


def _pieces(demonstration: Demonstration, cuts: list[int]) -> list[Demonstration]:
    inner = sorted({min(max(cut, 1), len(demonstration) - 2) for cut in cuts} if len(demonstration) > 2 else set())
    bounds = [0, *inner, len(demonstration) - 1]
    pieces = [demonstration.segment(start, stop + 1) for start, stop in pairwise(bounds)]
    return [_relabeled(piece, f"{demonstration.label}/{number}") for number, piece in enumerate(pieces, start=1)]


def _relabeled(demonstration: Demonstration, label: str) -> Demonstration:
    return replace(demonstration, label=label)


def _speed(demonstration: Demonstration, window: _Window) -> Array:
    """Speed (N,) of the tool, each channel divided by its own greatest, the faster channel counts."""
    speed = np.zeros(len(demonstration))
    for values in (demonstration.position, demonstration.quaternion):
        if values is None:
            continue
        rates = _rates(window, values)
        channel = np.sqrt(np.einsum("ni,ni->n", rates, rates))
        if channel.max() > 0.0:
            speed = np.maximum(speed, channel / channel.max())
    return speed


def _sudden(demonstration: Demonstration, window: _Window) -> NDArray[np.bool_]:
    """Samples (N,) at which a continuous signal goes to another level, much faster than it usually changes."""
    sudden = np.zeros(len(demonstration), dtype=bool)
    for values in demonstration.continuous.values():
        rate = np.abs(_rates(window, values))
        quick = rate > max(SUDDEN * float(np.median(rate)), IDLE_SPEED * float(rate.max()))
        sudden |= _to_another_level(values, quick)
    return sudden


def _to_another_level(values: Array, quick: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Those quick samples (N,), not at the start, before and after which a signal's level differs by `LEVEL`."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], quick, [False]]).astype(int)))
    least, kept = LEVEL * float(np.abs(values).max()), np.zeros(len(values), dtype=bool)
    for k in range(0, len(edges), 2):
        before = values[edges[k - 1] if k else 0 : edges[k] + 1]
        after = values[edges[k + 1] - 1 : edges[k + 2] + 1 if k + 2 < len(edges) else len(values)]
        kept[edges[k] : edges[k + 1]] = edges[k] > 0 and abs(np.median(after) - np.median(before)) >= least
    return kept


_Window = tuple[NDArray[np.int64], NDArray[np.int64], Array]  # samples (N,) before and after each, and the time between


def _window(time: Array) -> _Window:
    """Window of `IDLE_WINDOW` of the duration around each sample."""
    half = 0.5 * IDLE_WINDOW * float(time[-1] - time[0])
    before = np.maximum(np.searchsorted(time, time - half, side="right") - 1, 0)
    after = np.minimum(np.searchsorted(time, time + half, side="left"), len(time) - 1)
    return before, after, np.maximum(time[after] - time[before], np.finfo(float).tiny)


def _rates(window: _Window, values: Array) -> Array:
    """Rates of change (N, ...) of values (N, ...) over the window of each sample."""
    before, after, span = window
    rates: Array = (values[after] - values[before]) / span.reshape(-1, *(1,) * (values.ndim - 1))
    return rates
