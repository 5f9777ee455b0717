"""Landmarks: changes of discrete signals that all demonstrations share, such as a gripper that closes.

In the flow: `alignment` brings them to one phase in all demonstrations, so that they stay sharp in the tube; between
them the paths decide.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array
from pft_exec.learning.resampling import own_time

FLICKER = 0.02  # of the duration: a value held for less is an accident, unless all demonstrations show it


def _switches(time: Array, values: NDArray[np.int64], shortest: float) -> tuple[tuple[int, ...], Array]:
    """Values that a discrete signal takes one after the other, and the shares (E,) of the duration between them.

    Values that are held for less than `shortest` of the duration are passed over.
    """
    at = np.flatnonzero(np.diff(values)) + 1
    between = 0.5 * (time[at - 1] + time[at]) / time[-1]
    shown = [int(values[0]), *(int(v) for v in values[at])]
    held = np.diff(np.concatenate([[0.0], between, [1.0]]))
    for index in range(len(shown) - 2, 0, -1):
        if held[index] < shortest:
            del shown[index]
            between = np.delete(between, index - 1)
    kept = [i for i in range(1, len(shown)) if shown[i] != shown[i - 1]]
    return (shown[0], *(shown[i] for i in kept)), between[[i - 1 for i in kept]]


def _common(demonstrations: Sequence[Demonstration], name: str) -> Array:
    """Shares (K, E) of the durations at which a signal takes its next value; no column where the orders differ."""
    for shortest in (0.0, FLICKER):
        found = [_switches(own_time(d), d.discrete[name], shortest) for d in demonstrations]
        if len({values for values, _ in found}) == 1:
            return np.stack([shares for _, shares in found])
    return np.empty((len(demonstrations), 0))


def _is_ordered(landmarks: Array) -> bool:
    """Whether the columns of landmarks (K, L) come in the same order in all rows."""
    ordered = landmarks[:, np.argsort(landmarks.mean(axis=0), kind="stable")]
    return bool(np.all(np.diff(ordered, axis=1) >= 0.0))


def find_landmarks(demonstrations: Sequence[Demonstration], names: Sequence[str]) -> Array:
    """Shares (K, L) of K durations at which L changes of discrete signals happen, increasing along L.

    A signal counts where all demonstrations show the same values one after the other, and as long as its changes come
    in the same order with those of the signals before it.
    """
    found = np.empty((len(demonstrations), 0))
    for name in names:
        joined = np.hstack([found, _common(demonstrations, name)])
        if _is_ordered(joined):
            found = joined
    return found[:, np.argsort(found.mean(axis=0), kind="stable")]


def phases_through(landmarks: Array, steps: int) -> Array:
    """Shares (K, N) of K durations at N even steps, such that every landmark (K, L) falls on its mean share."""
    count = len(landmarks)
    shown = np.hstack([np.zeros((count, 1)), landmarks, np.ones((count, 1))])
    even = np.linspace(0.0, 1.0, steps)
    return np.stack([np.interp(even, shown.mean(axis=0), row) for row in shown])


def passed_landmarks(landmarks: Array, steps: int) -> Array:
    """(N,): how many landmarks (K, L) lie behind each of N even steps."""
    passed: Array = np.searchsorted(landmarks.mean(axis=0), np.linspace(0.0, 1.0, steps)).astype(float)
    return passed


def phases_at(shares: Array, phases: Array) -> Array:
    """Shares (K, N) of K durations at shares (K, N) of the even steps; `phases` (K, N) as of `phases_through`."""
    even = np.linspace(0.0, 1.0, phases.shape[1])
    return np.stack([np.interp(share, even, row) for share, row in zip(shares, phases, strict=True)])
