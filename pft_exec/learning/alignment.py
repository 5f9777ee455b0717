"""Alignment: the demonstrations of a motion on one timeline of N steps, by dynamic time warping.

In the flow: the first thing `robust` does. A demonstration is aligned to what the others predict for its own scene, so
that paths to different places are never compared with one another; a fixed number of steps and a prediction by all
others keep the result independent of the order of demonstrations, which the running mean of [Dong2012]_,
Algorithm 3, is not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pft_exec.demonstration import Demonstration
from pft_exec.demonstration.segmentation import without_idle_ends
from pft_exec.geometry import Array, geodesic_distance
from pft_exec.learning.dynamic_time_warping import matched_samples
from pft_exec.learning.resampling import nearest_at, own_time, places_of, quaternions_at, rows_at
from pft_exec.learning.smoothing import smoothed

STEPS = 100  # steps of a tube: 20 ms of a 2 s motion; each of five circles has 20, 1 % of the radius off the arc
TIME_WEIGHT = 0.1  # of the extent that a whole duration counts, so that pauses are not warped at random
TURN_SCALE = 1.0  # rad that counts as much as the extent of the path, where the motion turns less
CALM_STEPS = 2.0  # over which an alignment is averaged before demonstrations are brought in step by it
LANDMARK_WEIGHT = 10.0  # extents that a landmark counts: no step before one is aligned with a step behind it


@dataclass(frozen=True, eq=False)
class AlignedSet:
    """K demonstrations on N common steps, each in its own scene.

    Parameters
    ----------
    position : (K, N, 3), m, world frame
    quaternion : (K, N, 4), (x, y, z, w), or None
    time : (K, N), s
        When each step was passed, from the first moving sample.
    continuous, discrete : {name: (K, N)}
        Signals that every demonstration has.
    """

    position: Array
    quaternion: Array | None
    time: Array
    continuous: Mapping[str, Array]
    discrete: Mapping[str, NDArray[np.int64]]


def shared_names(signals: Sequence[Mapping[str, object]]) -> tuple[str, ...]:
    """Names that every demonstration has, sorted."""
    return tuple(sorted(set(signals[0]).intersection(*signals[1:])))


def moving_parts(demonstrations: Sequence[Demonstration]) -> list[Demonstration]:
    """The demonstrations without their idle ends."""
    return [without_idle_ends(d) for d in demonstrations]


def sample_at(demonstrations: Sequence[Demonstration], phase: Array) -> AlignedSet:
    """K demonstrations at shares (K, N) of their durations."""
    time = phase * np.array([[d.duration] for d in demonstrations])
    places = [places_of(own_time(d), row) for d, row in zip(demonstrations, time, strict=True)]
    rows = list(zip(demonstrations, places, strict=True))
    turns = [quaternions_at(d.quaternion, at) for d, at in rows if d.quaternion is not None]
    continuous = shared_names([d.continuous for d in demonstrations])
    discrete = shared_names([d.discrete for d in demonstrations])
    return AlignedSet(
        position=np.stack([rows_at(d.position, at) for d, at in rows]),
        quaternion=np.stack(turns) if turns else None,
        time=time,
        continuous={name: np.stack([rows_at(d.continuous[name], at) for d, at in rows]) for name in continuous},
        discrete={name: np.stack([nearest_at(d.discrete[name], at) for d, at in rows]) for name in discrete},
    )


def turn_weight(quaternion: Array | None) -> float:
    """Extents that one radian counts as in demonstrations (K, N, 4); 0 where there is no orientation."""
    if quaternion is None:
        return 0.0
    return 1.0 / max(float(geodesic_distance(quaternion[:, :1], quaternion).max()), TURN_SCALE)


def warped_phases(path: Array, turns: Array | None, even: AlignedSet, passed: Array) -> Array:
    """Shares (K, N) of the even steps at which demonstrations pass the steps of paths predicted for them.

    Parameters
    ----------
    path : (K, N, 3), m
        Prediction for each demonstration's scene.
    turns : (K, N, 4), (x, y, z, w), or None
    even : AlignedSet
        The demonstrations at even steps.
    passed : (N,)
        How many landmarks lie behind each step, in the paths and in the demonstrations.
    """
    steps = path.shape[1]
    extent = max(float(np.median(np.linalg.norm(np.ptp(even.position, axis=1), axis=1))), 1e-12)
    clock = np.stack([TIME_WEIGHT * np.linspace(0.0, 1.0, steps), LANDMARK_WEIGHT * passed], axis=1)
    weight = turn_weight(None if turns is None else even.quaternion)
    matched = [
        matched_samples(
            np.hstack([path[k] / extent, clock]),
            np.hstack([even.position[k] / extent, clock]),
            None if turns is None else turns[k],
            None if even.quaternion is None else even.quaternion[k],
            weight,
        )
        for k in range(len(path))
    ]
    warped: Array = np.stack(matched) / (steps - 1.0)
    warped[:, 0], warped[:, -1] = 0.0, 1.0
    return warped


def calmed(warped: Array, passed: Array) -> Array:
    """Shares (K, N), as of `warped_phases`, averaged over neighbouring steps; ends and landmarks stay where they are.

    A path that is matched step by step stands and jumps; who moves does neither.
    """
    steps = np.linspace(0.0, 1.0, warped.shape[1])
    strays = warped - steps
    changes = np.flatnonzero(np.diff(passed) > 0.0) + 1
    for begin, stop in pairwise([0, *changes, len(steps)]):
        leg = strays[:, begin:stop]
        calm = smoothed(leg.T, CALM_STEPS).T
        share = np.linspace(0.0, 1.0, stop - begin)
        first, last = (leg - calm)[:, :1], (leg - calm)[:, -1:]
        strays[:, begin:stop] = calm + (1.0 - share) * first + share * last
    return np.maximum.accumulate(np.clip(steps + strays, 0.0, 1.0), axis=1)
