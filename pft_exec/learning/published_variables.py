"""Relevant motion variables as [Dong2012]_, Algorithm 2, finds them: five modes, a Gaussian each, one threshold.

In the flow: the first half of the published method; `dong2012` makes the tubes from what is found here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.exceptions import UnknownNameError
from pft_exec.geometry import (
    Array,
    conjugate,
    multiply,
    normalize_quaternion,
    rotation_vector_from_quaternion,
    shortest_rotation,
)
from pft_exec.learning.alignment import shared_names
from pft_exec.learning.frames import object_names
from pft_exec.learning.variables import (
    ABSOLUTE,
    CHANNELS,
    ENDS,
    NONE,
    START,
    EndDecision,
    FrameDecision,
    MotionVariables,
)

MODES = ("absStart", "absEnd", "relInit", "relEffStart", "relEffEnd")
_X_AXIS = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class PublishedVariable:
    """One variable X in one mode, with its Gaussian over the demonstrations.

    Parameters
    ----------
    channel : str
        "position", "orientation", "ray" (line 3), or the name of a signal.
    mode : str
        One of `MODES`.
    frame : str
        The object of the relEff modes, "start" for relInit, "absolute" otherwise.
    mean, covariance : (d,) and (d, d)
    spread : float
        Square root of the largest eigenvalue of the covariance, or that eigenvalue ("variance").
    range : float
        What the spread is compared with.
    relevant : bool
    """

    channel: str
    mode: str
    frame: str
    mean: Array
    covariance: Array
    spread: float
    range: float
    relevant: bool

    @property
    def end(self) -> str:
        """Which end of the motion it speaks of, "start" or "end"."""
        return "start" if self.mode.endswith("Start") else "end"


def _mean_range(rows: Sequence[Array]) -> float:
    """Range of a channel over the samples, per axis, mean over demonstrations, then the largest axis."""
    return float(np.mean([np.ptp(row, axis=0) for row in rows], axis=0).max())


def _variable(
    channel: str, mode: str, frame: str, values: Array, reach: float, epsilon: float, spread: str
) -> PublishedVariable:
    values = values.reshape(len(values), -1)
    covariance = np.atleast_2d(np.cov(values.T))
    largest = max(float(np.linalg.eigvalsh(covariance)[-1]), 0.0)
    size = largest if spread == "variance" else float(np.sqrt(largest))
    return PublishedVariable(channel, mode, frame, values.mean(axis=0), covariance, size, reach, size < epsilon * reach)


def _channels(demonstrations: Sequence[Demonstration]) -> dict[str, list[Array]]:
    """Every channel of the effector: position, orientation (signs aligned), time and the other signals, (N_k, d)."""
    channels: dict[str, list[Array]] = {"position": [d.position for d in demonstrations]}
    turns = [d.quaternion for d in demonstrations if d.quaternion is not None]
    if turns:
        channels["orientation"] = [-q if float(q[0] @ turns[0][0]) < 0.0 else q for q in turns]
    channels["time"] = [(d.time - d.time[0])[:, None] for d in demonstrations]
    for name in shared_names([d.continuous for d in demonstrations]):
        channels[name] = [d.continuous[name][:, None] for d in demonstrations]
    for name in shared_names([d.discrete for d in demonstrations]):
        channels[name] = [d.discrete[name][:, None].astype(float) for d in demonstrations]
    return channels


def _rays(demonstration: Demonstration, name: str, object_pose: str) -> Array | None:
    """Line 3: the ray from effector to object, as a quaternion in the object's axes (N, 4); None where it is a point.

    The formula's direction (the words say the opposite); the roll, which a direction leaves free, is that of the
    shortest rotation from +x.
    """
    poses = np.atleast_2d(demonstration.objects[name])
    poses = np.broadcast_to(poses[:1] if object_pose == "start" else poses, (len(demonstration), 7))
    ray = poses[:, :3] - demonstration.position
    if (np.linalg.norm(ray[[0, -1]], axis=1) < 1e-9).any():
        return None
    kept = np.linalg.norm(ray, axis=1) >= 1e-9
    return multiply(conjugate(poses[kept, 3:]), shortest_rotation(np.broadcast_to(_X_AXIS, ray[kept].shape), ray[kept]))


def find_published_variables(
    demonstrations: Sequence[Demonstration], epsilon: float, spread: str, object_pose: str = "end"
) -> list[PublishedVariable]:
    """Algorithm 2: every variable in every mode.

    Parameters
    ----------
    demonstrations : K of one motion
    epsilon : float
        Threshold of line 4, in ranges.
    spread : str
        "std" or "variance" (as printed).
    object_pose : str
        Where an object counts at the end of the motion: "end", where it is then (as printed), or "start", where it was
        before the motion.

    Notes
    -----
    One Gaussian per object; the set notation of line 2 could mean one over all, the text does not. Offsets are
    differences in the world's axes.
    """
    found = []
    for channel, rows in _channels(demonstrations).items():
        reach = _mean_range(rows)
        first, last = np.stack([row[0] for row in rows]), np.stack([row[-1] for row in rows])
        if channel == "orientation":
            last = np.where(np.sum(last * last[:1], axis=1, keepdims=True) < 0.0, -last, last)
        modes = (("absStart", ABSOLUTE, first), ("absEnd", ABSOLUTE, last), ("relInit", START, last - first))
        found += [_variable(channel, mode, frame, v, reach, epsilon, spread) for mode, frame, v in modes]
    reach = _mean_range([d.position for d in demonstrations])
    for name in object_names(demonstrations):
        for mode, index in (("relEffStart", 0), ("relEffEnd", -1)):
            seen = 0 if object_pose == "start" else index
            offset = np.stack([np.atleast_2d(d.objects[name])[seen, :3] - d.position[index] for d in demonstrations])
            found.append(_variable("position", mode, name, offset, reach, epsilon, spread))
        found += _ray_variables(demonstrations, name, epsilon, spread, object_pose)
    return found


def _ray_variables(
    demonstrations: Sequence[Demonstration], name: str, epsilon: float, spread: str, object_pose: str
) -> list[PublishedVariable]:
    rays = [ray for ray in (_rays(d, name, object_pose) for d in demonstrations) if ray is not None]
    if len(rays) < len(demonstrations):
        return []
    signed = [ray * np.where(ray @ rays[0][:1].T < 0.0, -1.0, 1.0) for ray in rays]
    reach = _mean_range(signed)
    ends = (("relEffStart", np.stack([r[0] for r in signed])), ("relEffEnd", np.stack([r[-1] for r in signed])))
    return [_variable("ray", mode, name, values, reach, epsilon, spread) for mode, values in ends]


def _at(found: Sequence[PublishedVariable], end: str, channel: str) -> list[PublishedVariable]:
    return [v for v in found if v.channel == channel and v.end == end]


def chosen(
    found: Sequence[PublishedVariable], end: str, channel: str, forced: Mapping[str, Sequence[str]]
) -> PublishedVariable | None:
    """The variable that one end of a motion obeys: of those that are relevant, the one of the smallest spread."""
    here = _at(found, end, channel)
    key = end if channel == "position" else f"{end}.{channel}"
    if key in forced:
        return _named(here, key, forced[key])
    relevant = [v for v in here if v.relevant]
    return min(relevant, key=lambda v: v.spread) if relevant else None


def _named(here: Sequence[PublishedVariable], key: str, names: Sequence[str]) -> PublishedVariable | None:
    """The first that the user named: the published method ties an end to one frame."""
    if not names:
        return None
    by_name = {v.frame: v for v in reversed(here)}
    known = [name for name in names if name in by_name]
    if not known:
        hint = 'Name one of these, or learn by method="robust".'
        raise UnknownNameError(f"frame of {key!r} that the published method knows", names[0], tuple(by_name), hint)
    return by_name[known[0]]


def _decision(
    found: Sequence[PublishedVariable], end: str, channel: str, forced: Mapping[str, Sequence[str]]
) -> FrameDecision:
    here, best = _at(found, end, channel), chosen(found, end, channel, forced)
    relevant = sorted((v for v in here if v.relevant), key=lambda v: v.spread)
    names = [best.frame] if best is not None else []
    offset = np.zeros(3) if best is None else best.mean
    if best is not None and best.mode.startswith("relEff"):
        offset = -offset
    if channel == "orientation" and best is not None:
        offset = (
            rotation_vector_from_quaternion(normalize_quaternion(best.mean)) if best.mode != "relInit" else np.zeros(3)
        )
    words = ", ".join(f"{v.frame} {v.spread:.3g} {'<' if v.relevant else '>='} threshold" for v in here)
    return FrameDecision(
        frame=best.frame if best is not None else NONE,
        axes="world",
        offset=offset,
        spread=best.spread if best is not None else min(v.spread for v in here),
        candidates={v.frame: v.spread for v in sorted(here, key=lambda v: v.spread)},
        reason=f"spread below the threshold: {words}",
        relevant=tuple(dict.fromkeys(names)),
        rivals=tuple(v.frame for v in relevant if v.frame not in names),
        overruled=(end if channel == "position" else f"{end}.{channel}") in forced,
    )


def published_decisions(
    found: Sequence[PublishedVariable], has_turn: bool, forced: Mapping[str, Sequence[str]]
) -> MotionVariables:
    """What Algorithm 2 found, in the words that every method reports in."""
    channels = CHANNELS if has_turn else CHANNELS[:1]
    decided = {end: [_decision(found, end, channel, forced) for channel in channels] for end in ENDS}
    return MotionVariables(EndDecision(*decided["start"]), EndDecision(*decided["end"]))
