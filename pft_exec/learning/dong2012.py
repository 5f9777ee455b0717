r"""The published method: relevant motion variables and flow tubes as in [Dong2012]_, Algorithms 1 to 3.

Kept as the reference that everything is compared with. Where the paper leaves a choice open, the choice is a parameter
of `Dong2012Options`; what cannot be meant as printed is noted there. The differences to `robust` are the point: an
absolute threshold decides relevance, one similarity transform carries a demonstration to a new scene, the mean
runs over the demonstrations in their order, and the covariance is what is left after warping.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.exceptions import LearningError, MissingObjectError
from pft_exec.geometry import (
    Array,
    Pose,
    interpolate_quaternion,
    multiply,
    normalize_quaternion,
    quaternion_from_rotation_vector,
    relative_rotation_vector,
    rotate,
    shortest_rotation,
)
from pft_exec.learning.alignment import shared_names
from pft_exec.learning.averaging import average
from pft_exec.learning.fast_dtw import RADIUS, align_fast
from pft_exec.learning.flow_tube import AlignedDemonstrations, FlowTube
from pft_exec.learning.published_variables import PublishedVariable, chosen
from pft_exec.learning.resampling import extent_of, nearest_at, own_time, places_of, quaternions_at, rows_at


@dataclass(frozen=True)
class Dong2012Options:
    """What the paper leaves open.

    Parameters
    ----------
    epsilon : float
        The "small ratio" of Algorithm 2 line 4: largest spread of a relevant variable, in ranges of the motion.
    spread : str
        "std": the square root of the largest eigenvalue is compared with the range; "variance": the eigenvalue itself,
        as printed, so that the answer changes with the unit.
    object_pose : str
        Line 2: "end", an object counts at the end of the motion where it is then, as printed; so one that is carried
        is always relevant and pulls the end to where it stands before the motion. "start": where it was before the
        motion, which agrees with the paper's example (the bin is found, the carried box is not).
    similar : "all" or int
        Algorithm 3 line 2: all demonstrations, or that many with the most similar relevant initial positions.
    minimum_displacement : float
        In extents: a demonstrated displacement below it is only shifted, neither turned nor scaled.
    radius : int
        Of FastDTW.
    interpolation : str
        Algorithm 3 line 6, "mean": step n is the mean of the samples warped to it; "linear": the warped sequence is
        interpolated to the length of the mean, as printed.
    regularization : float or None
        Standard deviation, m, whose square is added to the covariance; None: 1 % of the extent of the motion, or of
        the median motion of a library.
    turn_regularization : float
        The same for orientations, rad.
    samples : int or None
        Longer recordings are read at so many even times (the paper's have about 100); None keeps all.
    """

    epsilon: float = 0.1
    spread: str = "std"
    object_pose: str = "end"
    similar: str | int = "all"
    minimum_displacement: float = 0.05
    radius: int = RADIUS
    interpolation: str = "mean"
    regularization: float | None = None
    turn_regularization: float = 0.02
    samples: int | None = 200

    def __post_init__(self) -> None:
        choices = {
            "spread": ("std", "variance"),
            "object_pose": ("end", "start"),
            "interpolation": ("mean", "linear"),
        }
        for name, allowed in choices.items():
            if getattr(self, name) not in allowed:
                raise LearningError(f"{name} must be one of {', '.join(allowed)}; got {getattr(self, name)!r}.")
        if self.similar != "all" and not (isinstance(self.similar, int) and self.similar >= 2):
            raise LearningError(f"similar must be 'all' or a number of at least 2; got {self.similar!r}.")
        if not self.epsilon > 0.0 or self.radius < 0 or (self.samples is not None and self.samples < 2):
            raise LearningError("epsilon must be positive, radius not negative, samples at least 2.")


@dataclass(frozen=True, eq=False)
class _Track:
    """One demonstration (or mean) as the algorithm sees it: T samples of every channel."""

    position: Array
    quaternion: Array | None
    time: Array
    signals: Array  # (T, S): continuous signals, then one column of 0 and 1 for each value of each discrete one

    def features(self) -> Array:
        """[P, Q] (T, 3 or 7), raw components: what FastDTW compares."""
        return self.position if self.quaternion is None else np.hstack([self.position, self.quaternion])

    def rows(self, index: NDArray[np.int64]) -> _Track:
        turn = None if self.quaternion is None else self.quaternion[index]
        return _Track(self.position[index], turn, self.time[index], self.signals[index])


@dataclass(frozen=True, eq=False)
class Dong2012Motion:
    """What Algorithm 2 found, and the demonstrations that Algorithm 3 needs anew for every scene."""

    options: Dong2012Options
    found: tuple[PublishedVariable, ...]
    forced: Mapping[str, Sequence[str]]
    tracks: tuple[_Track, ...]
    objects: tuple[Mapping[str, Array], ...]
    continuous: tuple[str, ...]
    discrete: Mapping[str, NDArray[np.int64]]
    extent: float

    @property
    def regularization(self) -> float:
        """Standard deviation, m, added to every covariance."""
        given = self.options.regularization
        return 0.01 * self.extent if given is None else given


def _track(
    demonstration: Demonstration,
    options: Dong2012Options,
    names: Sequence[str],
    values: Mapping[str, NDArray[np.int64]],
) -> _Track:
    clock = own_time(demonstration)
    wanted = clock
    if options.samples is not None and len(clock) > options.samples:
        wanted = np.linspace(0.0, clock[-1], options.samples)
    places = places_of(clock, wanted)
    columns = [np.interp(wanted, clock, demonstration.continuous[name]) for name in names]
    for name, choices in values.items():
        shown = nearest_at(demonstration.discrete[name], places)
        columns += [(shown == choice).astype(float) for choice in choices]
    turn = demonstration.quaternion
    return _Track(
        rows_at(demonstration.position, places),
        None if turn is None else quaternions_at(turn, places),
        wanted,
        np.stack(columns, axis=1) if columns else np.empty((len(wanted), 0)),
    )


def learn_dong2012(
    demonstrations: Sequence[Demonstration],
    found: Sequence[PublishedVariable],
    forced: Mapping[str, Sequence[str]],
    options: Dong2012Options,
) -> Dong2012Motion:
    """Keep what Algorithm 3 needs: the demonstrations, and the variables that Algorithm 2 found."""
    continuous = shared_names([d.continuous for d in demonstrations])
    discrete = {
        name: np.unique(np.concatenate([d.discrete[name] for d in demonstrations]))
        for name in shared_names([d.discrete for d in demonstrations])
    }
    return Dong2012Motion(
        options,
        tuple(found),
        forced,
        tuple(_track(d, options, continuous, discrete) for d in demonstrations),
        tuple({name: np.atleast_2d(poses)[0] for name, poses in d.objects.items()} for d in demonstrations),
        continuous,
        discrete,
        extent_of([d.position for d in demonstrations]),
    )


def _similar(motion: Dong2012Motion, needed: Sequence[str], scene: Scene, start: Array) -> list[int]:
    """Algorithm 3 line 2: the demonstrations to use, in their order."""
    count = len(motion.tracks)
    if motion.options.similar == "all" or int(motion.options.similar) >= count:
        return list(range(count))
    now = np.concatenate([start, *(scene[name].position for name in needed)])
    then = [
        np.concatenate([track.position[0], *(objects[name][:3] for name in needed)])
        for track, objects in zip(motion.tracks, motion.objects, strict=True)
    ]
    distance = np.linalg.norm(np.array(then) - now, axis=1)
    return sorted(int(k) for k in np.argsort(distance, kind="stable")[: int(motion.options.similar)])


def _required(variable: PublishedVariable | None, scene: Scene, begin: Array | None) -> Array | None:
    """Where a relevant position variable asks the effector to be, world frame; None where there is none."""
    if variable is None:
        return None
    if variable.mode in ("relEffStart", "relEffEnd"):
        place: Array = scene[variable.frame].position - variable.mean
        return place
    return variable.mean if begin is None or variable.mode != "relInit" else begin + variable.mean


def _normalized(track: _Track, begin: Array, end: Array | None, least: float) -> _Track:
    """Algorithm 3 line 3: scaled, turned and moved so that the ends fall on `begin` and `end`, (3,)."""
    shown = track.position[-1] - track.position[0]
    wanted = shown if end is None else end - begin
    scale, turn = 1.0, np.array([0.0, 0.0, 0.0, 1.0])
    length, target = float(np.linalg.norm(shown)), float(np.linalg.norm(wanted))
    if length > least and target > 0.0:
        scale, turn = target / length, shortest_rotation(shown, wanted)
    position = begin + scale * rotate(turn, track.position - track.position[0])
    return _Track(
        position, None if track.quaternion is None else multiply(turn, track.quaternion), track.time, track.signals
    )


def _turned(track: _Track, begin: Array | None, end: Array | None) -> _Track:
    """Orientations corrected at the ends where an orientation variable is relevant; the correction fades evenly."""
    if track.quaternion is None:
        return track
    turn, share = track.quaternion, np.linspace(0.0, 1.0, len(track.time))
    for target, index, fade in ((begin, 0, 1.0 - share), (end, -1, share)):
        if target is not None:
            step = relative_rotation_vector(turn[index], target)
            turn = multiply(turn, quaternion_from_rotation_vector(fade[:, None] * step))
    return _Track(track.position, turn, track.time, track.signals)


def _mean(first: _Track, second: _Track, ratio: float) -> _Track:
    """(1 - ratio) first + ratio second, component by component; quaternions sign-aligned, averaged and renormalized."""

    def between(a: Array, b: Array) -> Array:
        mixed: Array = (1.0 - ratio) * a + ratio * b
        return mixed

    turn = None
    if first.quaternion is not None and second.quaternion is not None:
        sign = np.where(np.sum(first.quaternion * second.quaternion, axis=1, keepdims=True) < 0.0, -1.0, 1.0)
        turn = normalize_quaternion(between(first.quaternion, sign * second.quaternion))
    return _Track(
        between(first.position, second.position),
        turn,
        between(first.time, second.time),
        between(first.signals, second.signals),
    )


def _signed_features(track: _Track, reference: _Track) -> Array:
    """[P, Q] with the quaternions in the half space of the reference's first."""
    if track.quaternion is None or reference.quaternion is None:
        return track.features()
    sign = -1.0 if float(track.quaternion[0] @ reference.quaternion[0]) < 0.0 else 1.0
    return np.hstack([track.position, sign * track.quaternion])


def _running_mean(tracks: Sequence[_Track], radius: int) -> _Track:
    """Algorithm 3 lines 4 and 5; the mean takes the length of each warping path in turn."""
    mean = tracks[0]
    for k, track in enumerate(tracks[1:], start=2):
        path = align_fast(mean.features(), _signed_features(track, mean), radius)
        mean = _mean(mean.rows(path[:, 0]), track.rows(path[:, 1]), 1.0 / k)
    return mean


def _group_means(values: Array, groups: NDArray[np.int64]) -> Array:
    """Means (N, D) of the rows of `values` (L, D) that share a group; groups run 0, 0, 1, 2, 2, ... to N - 1."""
    starts = np.flatnonzero(np.concatenate([[True], np.diff(groups) > 0]))
    sizes = np.diff(np.concatenate([starts, [len(groups)]]))
    means: Array = np.add.reduceat(values, starts, axis=0) / sizes[:, None]
    return means


def _interpolated(track: _Track, mean: _Track, options: Dong2012Options) -> _Track:
    """Algorithm 3 line 6: a demonstration at the steps of the mean."""
    path = align_fast(mean.features(), _signed_features(track, mean), options.radius)
    warped, count = track.rows(path[:, 1]), len(mean.time)
    if options.interpolation == "linear":
        place = np.linspace(0.0, len(path) - 1.0, count)
        low = np.minimum(place.astype(np.int64), len(path) - 2)
        first, second = warped.rows(low), warped.rows(low + 1)
        ratio = (place - low)[:, None]
        turn = None
        if first.quaternion is not None and second.quaternion is not None:
            turn = interpolate_quaternion(first.quaternion, second.quaternion, ratio[:, 0])
        rows = [
            (1.0 - ratio) * a + ratio * b
            for a, b in ((first.position, second.position), (first.signals, second.signals))
        ]
        return _Track(rows[0], turn, np.interp(place, np.arange(len(path)), warped.time), rows[1])
    turn = None if warped.quaternion is None else normalize_quaternion(_group_means(warped.quaternion, path[:, 0]))
    time = _group_means(warped.time[:, None], path[:, 0])[:, 0]
    return _Track(_group_means(warped.position, path[:, 0]), turn, time, _group_means(warped.signals, path[:, 0]))


def _required_turns(
    motion: Dong2012Motion, tracks: Sequence[_Track], start: Pose | None
) -> tuple[Array | None, Array | None]:
    """Orientations that relevant orientation variables ask for at the two ends."""
    turns = [track.quaternion for track in tracks if track.quaternion is not None]
    if not turns:
        return None, None
    forced = motion.forced
    begins = chosen(motion.found, "start", "orientation", forced)
    ends = chosen(motion.found, "end", "orientation", forced)
    first, last = np.stack([t[0] for t in turns]), np.stack([t[-1] for t in turns])
    begin = average(first) if begins is not None else None
    if ends is None:
        return begin, None
    if ends.mode == "absEnd":
        return begin, average(last)
    given = begin if begin is not None else (average(first) if start is None else start.quaternion)
    return begin, multiply(given, average(multiply(first * np.array([-1.0, -1.0, -1.0, 1.0]), last)))


def generalize_dong2012(label: str, motion: Dong2012Motion, scene: Scene, start: Pose | None) -> FlowTube:
    """Algorithm 3, and lines 3 to 5 of Algorithm 1 (precision and log normalizer are the tube's own).

    Raises
    ------
    MissingObjectError
        If the scene lacks an object that a relevant variable refers to.
    """
    begins = chosen(motion.found, "start", "position", motion.forced)
    ends = chosen(motion.found, "end", "position", motion.forced)
    needed = list(dict.fromkeys(v.frame for v in (begins, ends) if v is not None and v.mode.startswith("relEff")))
    for name in needed:
        if name not in scene:
            raise MissingObjectError("object of the scene", name, scene, "The motion is relative to it.")
    given = np.mean([t.position[0] for t in motion.tracks], axis=0) if start is None else start.position
    begin = _required(begins, scene, None)
    begin = given if begin is None else begin
    end = _required(ends, scene, begin)
    tracks = [motion.tracks[k] for k in _similar(motion, needed, scene, given)]
    turns = _required_turns(motion, tracks, start)
    least = motion.options.minimum_displacement * motion.extent
    normalized = [_turned(_normalized(track, begin, end, least), *turns) for track in tracks]
    mean = _running_mean(normalized, motion.options.radius)
    return _tube(label, motion, mean, [_interpolated(track, mean, motion.options) for track in normalized])


def _tube(label: str, motion: Dong2012Motion, mean: _Track, tracks: Sequence[_Track]) -> FlowTube:
    """Algorithm 3 line 7: covariance over the demonstrations at each step."""
    count, size = len(tracks), 3 if mean.quaternion is None else 6
    position = np.stack([t.position for t in tracks])
    rows = position - position.mean(axis=0)
    turns = None
    if mean.quaternion is not None:
        turns = np.stack([t.quaternion for t in tracks if t.quaternion is not None])
        tangent = relative_rotation_vector(mean.quaternion, turns)
        rows = np.concatenate([rows, tangent - tangent.mean(axis=0)], axis=-1)
    covariance = np.einsum("kni,knj->nij", rows, rows) / (count - 1)
    floor = np.repeat([motion.regularization, motion.options.turn_regularization], 3)[:size]
    time = np.maximum.accumulate(np.stack([t.time for t in tracks]), axis=1)
    signals, names = np.stack([t.signals for t in tracks]), motion.continuous
    columns = np.cumsum([len(names), *(len(values) for values in motion.discrete.values())])
    return FlowTube(
        label,
        np.maximum.accumulate(mean.time) - mean.time[0],
        mean.position,
        mean.quaternion,
        covariance + np.diag(floor**2),
        time.std(axis=0, ddof=1),
        {name: mean.signals[:, i] for i, name in enumerate(names)},
        {name: signals[:, :, i].std(axis=0, ddof=1) for i, name in enumerate(names)},
        {name: mean.signals[:, a:b] for name, a, b in zip(motion.discrete, columns, columns[1:], strict=False)},
        motion.discrete,
        count,
        AlignedDemonstrations(position, turns, time),
    )
