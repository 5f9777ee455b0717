"""Recordings read at other times than they were sampled, and the arc length along a path."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array, interpolate_quaternion, read_only


def rows_at(time: Array, values: Array, wanted: Array) -> Array:
    """Columns of `values` (N, D) given at `time` (N,), linearly interpolated at `wanted` (M,): (M, D)."""
    place, ratio = _places(time, wanted)
    rows: Array = values[place] * (1.0 - ratio)[:, None] + values[place + 1] * ratio[:, None]
    return rows


def quaternions_at(time: Array, quaternions: Array, wanted: Array) -> Array:
    """Quaternions (N, 4) (x, y, z, w) given at `time`, geodesically interpolated at `wanted` (M,): (M, 4)."""
    place, ratio = _places(time, wanted)
    return interpolate_quaternion(quaternions[place], quaternions[place + 1], ratio)


def nearest_at(time: Array, values: NDArray[np.int64], wanted: Array) -> NDArray[np.int64]:
    """Values (N,) at the samples nearest to `wanted` (M,)."""
    place, ratio = _places(time, wanted)
    nearest: NDArray[np.int64] = values[place + (ratio > 0.5)]
    return nearest


def _places(time: Array, wanted: Array) -> tuple[NDArray[np.int64], Array]:
    place: NDArray[np.int64] = np.clip(np.searchsorted(time, wanted, side="right") - 1, 0, len(time) - 2)
    ratio = np.clip((wanted - time[place]) / (time[place + 1] - time[place]), 0.0, 1.0)
    return place, ratio


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


@lru_cache(maxsize=32)
def smoothing(count: int, width: float) -> Array:
    """Matrix (N, N), read-only, that averages over neighbours with Gaussian weights of deviation `width` steps."""
    steps = np.arange(count)
    weights = np.exp(-0.5 * ((steps[:, None] - steps[None, :]) / max(width, 1e-9)) ** 2)
    return read_only(weights / weights.sum(axis=1, keepdims=True))
