"""Compound motions: demonstrations cut at the keyframes that a user gave, each piece learned as a motion.

In the flow: [Dong2012]_, section 4.1; `motion` learns the pieces, this module cuts and joins. An object counts, in
every piece, with its pose before the whole motion, because that is all that is known of a new scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pft_exec.demonstration import Demonstration
from pft_exec.demonstration.segmentation import split_at_keyframes
from pft_exec.exceptions import LearningError
from pft_exec.geometry import Array
from pft_exec.learning.flow_tube import AlignedDemonstrations, FlowTube
from pft_exec.learning.variables import EndDecision, MotionVariables


def pieces_of(demonstrations: Sequence[Demonstration]) -> list[list[Demonstration]]:
    """Pieces of K demonstrations, sorted by segment: S lists of K.

    Raises
    ------
    LearningError
        If the demonstrations do not have the same number of keyframes.
    """
    counts = sorted({len(d.keyframes) for d in demonstrations})
    if len(counts) > 1:
        raise LearningError(
            f"the demonstrations of {demonstrations[0].label!r} must have the same number of keyframes; "
            f"got {', '.join(map(str, counts))}."
        )
    cut = []
    for demonstration in demonstrations:
        before = {name: np.atleast_2d(poses)[0] for name, poses in demonstration.objects.items()}
        cut.append([replace(piece, objects=before, keyframes=()) for piece in split_at_keyframes(demonstration)])
    return [list(pieces) for pieces in zip(*cut, strict=True)]


def joined_variables(segments: Sequence[MotionVariables], carried: tuple[str, ...]) -> MotionVariables:
    """The start of the first segment, the end of the last one, and what all of them pass."""
    first, last = segments[0], segments[-1]
    return MotionVariables(
        EndDecision(first.start.position, first.start.orientation),
        EndDecision(last.end.position, last.end.orientation),
        carried,
        last.continuous,
        last.discrete,
        tuple(
            replace(passage, phase=(index + passage.phase) / len(segments))
            for index, segment in enumerate(segments)
            for passage in segment.passed
        ),
    )


def _joined(parts: Sequence[Array], axis: int = 0) -> Array:
    """Parts one after the other; each but the first without its first step, which is the last one's end."""
    rest = [part.take(range(1, part.shape[axis]), axis=axis) for part in parts[1:]]
    return np.concatenate([parts[0], *rest], axis=axis)


def _shifted(times: Sequence[Array]) -> list[Array]:
    """Times (..., N) of successive parts, each going on where the last one ended."""
    shifted = [times[0]]
    for time in times[1:]:
        shifted.append(time + shifted[-1][..., -1:] - time[..., :1])
    return shifted


def _discrete(tubes: Sequence[FlowTube], name: str, values: NDArray[np.int64]) -> Array:
    """Probabilities (N, V) of the values that any segment showed; one imagined demonstration where one did not."""
    parts = []
    for tube in tubes:
        shown = np.full((len(tube), len(values)), 1.0 / (tube.count + len(values)))
        shown[:, np.searchsorted(values, tube.discrete_values[name])] = tube.discrete[name]
        parts.append(shown / shown.sum(axis=1, keepdims=True))
    return _joined(parts)


def join_tubes(label: str, tubes: Sequence[FlowTube]) -> FlowTube:
    """One flow tube that runs through several."""

    def signals(name: str) -> dict[str, Array]:
        return {key: _joined([getattr(tube, name)[key] for tube in tubes]) for key in getattr(tubes[0], name)}

    values = {
        name: np.unique(np.concatenate([tube.discrete_values[name] for tube in tubes])) for name in tubes[0].discrete
    }
    turns = [tube.quaternion for tube in tubes if tube.quaternion is not None]
    aligned = [tube.aligned for tube in tubes if tube.aligned is not None]
    aligned_turns = [a.quaternion for a in aligned if a.quaternion is not None]
    deviations = [tube.time_deviation for tube in tubes if tube.time_deviation is not None]
    return FlowTube(
        label,
        _joined(_shifted([tube.time for tube in tubes])),
        _joined([tube.position for tube in tubes]),
        _joined(turns) if turns else None,
        _joined([tube.covariance for tube in tubes]),
        _joined(deviations),
        signals("continuous"),
        signals("continuous_deviation"),
        {name: _discrete(tubes, name, values[name]) for name in values},
        values,
        tubes[0].count,
        AlignedDemonstrations(
            _joined([a.position for a in aligned], axis=1),
            _joined(aligned_turns, axis=1) if aligned_turns else None,
            _joined(_shifted([a.time for a in aligned]), axis=1),
        ),
    )
