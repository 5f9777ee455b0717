"""Recordings read at other times than they were sampled, and the arc length along a path."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array
from pft_exec.learning.turning import turn_between, turn_by

STILL = 1e-4  # of how far away it is: the extent of a tool that never moves, so that a covariance stays regular

Places = tuple[NDArray[np.int64], Array]  # index (M,) of the sample before, and share (M,) of the way to the next


@njit(cache=True, fastmath=False)
def _find(time, wanted, place, ratio):  # type: ignore[no-untyped-def]
    """Places of `wanted` (M,) among times (N,), in place; quick where `wanted` increases."""
    n, last = 0, len(time) - 2
    for m in range(len(wanted)):
        if wanted[m] < time[n]:
            n = 0
        while n < last and time[n + 1] <= wanted[m]:
            n += 1
        place[m] = n
        ratio[m] = min(max((wanted[m] - time[n]) / (time[n + 1] - time[n]), 0.0), 1.0)


def extent_of(paths: Sequence[Array]) -> float:
    """Median size of paths, each (N, 3), m; where nothing moves, a small one by how far away they are."""
    extent = float(np.median([np.linalg.norm(np.ptp(path, axis=0)) for path in paths]))
    far = max(float(np.abs(path).max()) for path in paths)
    return extent if extent > 1e-9 * far else STILL * (far or 1.0)


def places_of(time: Array, wanted: Array) -> Places:
    """Where times `wanted` (M,), increasing, lie among the samples taken at `time` (N,)."""
    place, ratio = np.empty(len(wanted), dtype=np.int64), np.empty(len(wanted))
    _find(np.ascontiguousarray(time), np.ascontiguousarray(wanted), place, ratio)
    return place, ratio


def rows_at(values: Array, places: Places) -> Array:
    """Columns of `values` (N, D), or one (N,), linearly interpolated at M places: (M, D) or (M,)."""
    place, ratio = places
    ratio = ratio.reshape(-1, *(1,) * (values.ndim - 1))
    rows: Array = values[place] * (1.0 - ratio) + values[place + 1] * ratio
    return rows


def quaternions_at(quaternions: Array, places: Places) -> Array:
    """Quaternions (N, 4) (x, y, z, w), geodesically interpolated at M places: (M, 4)."""
    place, ratio = places
    first = quaternions[place]
    turned: Array = turn_by(first, turn_between(first, quaternions[place + 1]) * ratio[:, None])
    return turned


def nearest_at(values: NDArray[np.int64], places: Places) -> NDArray[np.int64]:
    """Values (N,) at the samples nearest to M places."""
    place, ratio = places
    nearest: NDArray[np.int64] = values[place + (ratio > 0.5)]
    return nearest


def own_time(demonstration: Demonstration) -> Array:
    """Times (N,), s, from the first sample."""
    time: Array = demonstration.time - demonstration.time[0]
    return time


def arc_length(paths: Array) -> Array:
    """Share of the length passed (..., N) along paths (..., N, 3): 0 to 1; evenly spaced where nothing moves."""
    steps = np.linalg.norm(np.diff(paths, axis=-2), axis=-1)
    passed = np.concatenate([np.zeros((*steps.shape[:-1], 1)), np.cumsum(steps, axis=-1)], axis=-1)
    total = passed[..., -1:]
    even = np.broadcast_to(np.linspace(0.0, 1.0, paths.shape[-2]), passed.shape)
    share: Array = np.where(total > 0.0, passed / np.where(total > 0.0, total, 1.0), even)
    return share
