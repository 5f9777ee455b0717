"""Frames that one end of a motion may be tied to: the world, the start of the motion, and each object.

In the flow: `pft_exec.learning.relevance` compares them. Objects count with their pose at the first sample, because
that is all that is known of a new scene; so an object that is carried away does not explain where it is put.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array, conjugate, rotation_vector_from_quaternion
from pft_exec.learning.averaging import average
from pft_exec.learning.turning import carry, compose, turn_between
from pft_exec.learning.variables import ABSOLUTE, START


@dataclass(frozen=True, eq=False)
class Candidate:
    """One end of K demonstrations seen in one frame.

    Parameters
    ----------
    name : str
        "absolute", "start", or an object.
    axes : str
        "world" or "object".
    offset : (3,)
        Mean, m, or rotation vector of the mean orientation, rad.
    residual : (K, 3)
        Deviations from the mean, m or rad.
    """

    name: str
    axes: str
    offset: Array
    residual: Array

    @property
    def spread(self) -> float:
        """Root mean square distance from the mean with K - 1 degrees of freedom, m or rad."""
        return float(np.sqrt(np.sum(self.residual**2) / max(len(self.residual) - 1, 1)))


def object_names(demonstrations: Sequence[Demonstration]) -> tuple[str, ...]:
    """Objects that every demonstration has, sorted."""
    shared = set(demonstrations[0].objects).intersection(*(set(d.objects) for d in demonstrations[1:]))
    return tuple(sorted(shared))


def partly_recorded(demonstrations: Sequence[Demonstration]) -> dict[str, int]:
    """Objects that most demonstrations have but not all, sorted, and in how many they are: they cannot count."""
    names = [name for d in demonstrations for name in d.objects]
    counts = {name: names.count(name) for name in sorted(set(names))}
    return {name: count for name, count in counts.items() if len(demonstrations) < 2 * count < 2 * len(demonstrations)}


def object_poses(demonstrations: Sequence[Demonstration], name: str) -> Array:
    """Poses (K, 7) of an object at the first samples, world frame, m and (x, y, z, w)."""
    return np.stack([np.atleast_2d(d.objects[name])[0] for d in demonstrations])


def tool_poses(demonstrations: Sequence[Demonstration], index: int) -> Array:
    """Tool poses (K, 7) at sample `index`, world frame; identity orientation where none was recorded."""
    identity = np.array([0.0, 0.0, 0.0, 1.0])
    return np.stack(
        [
            np.concatenate([d.position[index], identity if d.quaternion is None else d.quaternion[index]])
            for d in demonstrations
        ]
    )


def _candidate(name: str, axes: str, values: Array) -> Candidate:
    mean = values.mean(axis=0)
    return Candidate(name, axes, mean, values - mean)


def position_candidates(
    tool: Array, start: Array | None, objects: Mapping[str, Array], has_turn: bool
) -> list[Candidate]:
    """Places of the tool in every frame.

    Parameters
    ----------
    tool : (K, 7)
        Tool poses at this end, world frame.
    start : (K, 7) or None
        Tool poses at the start; None where this is the start.
    objects : {name: (K, 7)}
    has_turn : bool
        Whether orientations were recorded.
    """
    place = tool[:, :3]
    found = [_candidate(ABSOLUTE, "world", place)]
    frames = ([] if start is None else [(START, start, has_turn)]) + [(n, o, True) for n, o in objects.items()]
    for name, frame, is_turned in frames:
        found.append(_candidate(name, "world", place - frame[:, :3]))
        if is_turned:
            found.append(_candidate(name, "object", carry(conjugate(frame[:, 3:]), place - frame[:, :3])))
    return found


def orientation_candidates(tool: Array, start: Array | None, objects: Mapping[str, Array]) -> list[Candidate]:
    """Orientations of the tool in every frame; parameters as in `position_candidates`."""
    turn = tool[:, 3:]
    seen: list[tuple[str, str, Array]] = [(ABSOLUTE, "world", turn)]
    if start is not None:
        seen.append((START, "object", compose(conjugate(start[:, 3:]), turn)))
        seen.append((START, "world", compose(turn, conjugate(start[:, 3:]))))
    seen += [(name, "object", compose(conjugate(pose[:, 3:]), turn)) for name, pose in objects.items()]
    local = np.stack([values for _, _, values in seen], axis=1)
    mean = average(local)
    offset, residual = rotation_vector_from_quaternion(mean), turn_between(mean, local)
    return [Candidate(name, axes, offset[i], residual[:, i]) for i, (name, axes, _) in enumerate(seen)]
