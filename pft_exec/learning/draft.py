"""Drafts: what demonstrations say from the frames of a scene, at the same share of the time or brought in step.

In the flow: between the motion variables, which are decided, and what `robust` keeps of a motion. A draft reads the
demonstrations at some shares of their durations, finds the experts that help and the objects that are passed, and says
where each demonstration is where it is predicted to be.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array
from pft_exec.learning.alignment import (
    STEPS,
    AlignedSet,
    calmed,
    sample_at,
    turn_weight,
    warped_phases,
)
from pft_exec.learning.blending import left_over
from pft_exec.learning.carrying import carried_objects
from pft_exec.learning.endpoint import (
    Endpoint,
    Poses,
    frame_pose,
    local_positions,
    local_turns,
    make_endpoint,
    target_positions,
    target_turns,
)
from pft_exec.learning.experts import Experts, expert_keys
from pft_exec.learning.frames import object_names, object_poses
from pft_exec.learning.handling import handled_objects
from pft_exec.learning.landmarks import passed_landmarks, phases_at, phases_through
from pft_exec.learning.leave_one_out import LeftOut, leave_one_out
from pft_exec.learning.passing import find_passage
from pft_exec.learning.resampling import arc_length, extent_of
from pft_exec.learning.tempo import find_tempo
from pft_exec.learning.variables import START, MotionVariables, Passage

FLOOR = 0.002  # of the extent: standard deviation below which places count as equal
OUT_OF_STEP = 0.04  # of the motion, root mean square, by which demonstrations that keep time are apart


@dataclass(frozen=True, eq=False)
class Draft:
    """What is learned from demonstrations at some shares of their durations.

    Parameters
    ----------
    even : AlignedSet
        The demonstrations at those shares.
    start : Endpoint
    left_out : LeftOut
    passages : sequence of Passage
    warped : (K, N)
        Shares of the steps at which each demonstration is where it is predicted to be.
    aligned : AlignedSet
        The demonstrations there.
    """

    even: AlignedSet
    start: Endpoint
    left_out: LeftOut
    passages: tuple[Passage, ...]
    warped: Array
    aligned: AlignedSet

    @property
    def residual(self) -> Array:
        """(K, N, 3) or (K, N, 6), m and rad: what the blend leaves of the demonstrations where they are aligned."""
        return left_over(self.aligned, self.left_out.blend)

    def squares(self) -> Array:
        """Mean square (K,), m^2, of the residual; a turn by the weight that it has in the alignment."""
        weight = extent_of(list(self.even.position)) * turn_weight(self.even.quaternion)
        scale = np.array([1.0] * 3 + [weight] * 3)[: self.residual.shape[-1]]
        mean: Array = np.mean(np.sum((scale * self.residual) ** 2, axis=-1), axis=1)
        return mean


def draft_in_step(
    demonstrations: Sequence[Demonstration],
    moving: Sequence[Demonstration],
    variables: MotionVariables,
    landmarks: Array,
    way: Sequence[str] | None,
) -> Draft:
    """What is learned at even shares of the time; in step where the demonstrations keep time badly and that is better.

    Whoever rests where others go on is elsewhere than they are at the same share of the time, and the mean of all cuts
    the corners. Brought in step with what is predicted of them, the demonstrations have a mean that does not; which of
    the two says better where a left-out one goes, whenever it does, decides.
    """
    phases = phases_through(landmarks, STEPS)
    draft = _draft(demonstrations, moving, variables, landmarks, phases, way)
    if np.sqrt(np.mean((draft.warped - np.linspace(0.0, 1.0, STEPS)) ** 2)) <= OUT_OF_STEP:
        return draft
    steps = calmed(draft.warped, passed_landmarks(landmarks, STEPS))
    in_step = _draft(demonstrations, moving, variables, landmarks, phases_at(steps, phases), way)
    gain = draft.squares() - in_step.squares()
    return in_step if gain.mean() > gain.std(ddof=1) / np.sqrt(len(gain)) else draft


def _draft(
    demonstrations: Sequence[Demonstration],
    moving: Sequence[Demonstration],
    variables: MotionVariables,
    landmarks: Array,
    phases: Array,
    way: Sequence[str] | None,
) -> Draft:
    """What is learned from demonstrations at shares (K, N) of their durations."""
    even = sample_at(moving, phases)
    extent = extent_of(list(even.position))
    first = tool_poses(even, 0)
    poses = {name: object_poses(demonstrations, name) for name in object_names(demonstrations)}
    start = make_endpoint(variables.start, first, poses, FLOOR * extent)
    handled = _handled(demonstrations, landmarks, even, poses, extent)
    begin = predicted_begin(start, poses, first, leave_out=True)
    passed = passed_landmarks(landmarks, STEPS)
    tempo = find_tempo(even.position, even.quaternion, passed, extent * turn_weight(even.quaternion))

    def left_out_with(names: Sequence[str]) -> LeftOut:
        experts = _make_experts(even, variables, names, poses | {START: first}, extent)
        return leave_one_out(experts, poses | {START: begin}, even, tempo, variables.end.position.overruled)

    names = tuple(dict.fromkeys([*variables.objects, *handled]))
    free = _not_held(demonstrations, poses) if way is None else {name: poses[name] for name in way}
    left_out, passages = _with_passages(left_out_with, names, even.position, free, start.floor, way is not None)
    warped = warped_phases(left_out.blend.position, left_out.blend.turn, even, passed)
    return Draft(even, start, left_out, passages, warped, sample_at(moving, phases_at(warped, phases)))


def _with_passages(
    left_out_with: Callable[[Sequence[str]], LeftOut],
    names: tuple[str, ...],
    position: Array,
    free: Poses,
    floor: float,
    named: bool,
) -> tuple[LeftOut, tuple[Passage, ...]]:
    """What the frames of `names` say, and of the objects among `free` that are passed, which are all if `named`."""
    left_out = left_out_with(names)
    passages: list[Passage] = []
    while True:
        passage = find_passage(position, left_out.blend.position, _without(free, names), floor, named)
        if passage is None:
            return left_out, tuple(passages)
        passages.append(passage)
        names = (*names, passage.name)
        left_out = left_out_with(names)


def _handled(
    demonstrations: Sequence[Demonstration], landmarks: Array, even: AlignedSet, poses: Poses, extent: float
) -> tuple[str, ...]:
    """Objects that a discrete signal changed beside; not what the tool held from the start."""
    if landmarks.shape[1] == 0:
        return ()
    free = _not_held(demonstrations, poses)
    tool = np.stack([tool_poses(even, step) for step in range(even.position.shape[1])], axis=1)
    return handled_objects(landmarks, tool, free, extent, even.quaternion is not None)


def _not_held(demonstrations: Sequence[Demonstration], poses: Poses) -> dict[str, Array]:
    """The objects that the tool did not hold from the start."""
    return _without(poses, carried_objects(demonstrations, from_start=True))


def _without(poses: Poses, names: Sequence[str]) -> dict[str, Array]:
    return {name: pose for name, pose in poses.items() if name not in names}


def _make_experts(
    aligned: AlignedSet, variables: MotionVariables, names: Sequence[str], poses: Poses, extent: float
) -> Experts:
    """The experts of a motion, before it is known which of them help; `poses` are the demonstrated ones."""
    count, floor = len(aligned.position), FLOOR * extent
    keys, turn_keys = expert_keys(names, poses, aligned.quaternion is not None, extent)
    local_turn = None
    if aligned.quaternion is not None:
        turns = [local_turns(aligned.quaternion, frame_pose(n, poses, count), axes) for n, axes in turn_keys]
        local_turn = np.stack(turns)
    return Experts(
        aligned.position,
        arc_length(aligned.position).mean(axis=0),
        make_endpoint(variables.end, tool_poses(aligned, -1), poses, floor),
        keys,
        turn_keys,
        np.stack([local_positions(aligned.position, frame_pose(n, poses, count), axes) for n, axes in keys]),
        local_turn,
        floor,
    )


def predicted_begin(start: Endpoint, poses: Poses, given: Array, leave_out: bool) -> Array:
    """Poses (M, 7) in which M scenes begin: the relevant start, else the given one."""
    place = target_positions(start, poses, len(given), leave_out)
    turn = target_turns(start, poses, len(given), leave_out)
    return np.hstack([given[:, :3] if place is None else place, given[:, 3:] if turn is None else turn])


def tool_poses(aligned: AlignedSet, index: int) -> Array:
    """Tool poses (K, 7) at a step; identity orientation where there is none."""
    place = aligned.position[:, index]
    identity = np.broadcast_to(np.array([0.0, 0.0, 0.0, 1.0]), (len(place), 4))
    return np.hstack([place, identity if aligned.quaternion is None else aligned.quaternion[:, index]])
