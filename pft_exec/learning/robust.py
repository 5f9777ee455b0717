"""The robust method: what is learned once from the demonstrations of a motion, and the flow tube of a scene from it.

In the flow: align, decide the motion variables, find the experts' weights by leaving each demonstration out
(`learn_robust`); then for each scene blend the experts' predictions and give them the covariance of what the blend
left (`generalize`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.exceptions import MissingObjectError
from pft_exec.geometry import Array, Pose
from pft_exec.learning.alignment import (
    STEPS,
    AlignedSet,
    moving_parts,
    sample_at,
    shared_names,
    turn_weight,
    warped_phases,
)
from pft_exec.learning.averaging import average
from pft_exec.learning.blending import TURN_FLOOR, Prediction, Weights, blend_experts, left_over, predict, with_ends
from pft_exec.learning.carrying import carried_objects
from pft_exec.learning.covariance import Spread, find_spread
from pft_exec.learning.endpoint import (
    Endpoint,
    Poses,
    doubt,
    frame_pose,
    local_positions,
    local_turns,
    make_endpoint,
    target_positions,
    target_turns,
    warn_of_conflict,
)
from pft_exec.learning.experts import (
    Experts,
    expert_keys,
)
from pft_exec.learning.flow_tube import AlignedDemonstrations, FlowTube
from pft_exec.learning.frames import object_names, object_poses
from pft_exec.learning.handling import handled_objects
from pft_exec.learning.landmarks import (
    find_landmarks,
    passed_landmarks,
    phases_at,
    phases_through,
)
from pft_exec.learning.leave_one_out import LeftOut, leave_one_out
from pft_exec.learning.leverage import Leverage
from pft_exec.learning.pacing import Pacing, learn_pacing
from pft_exec.learning.passing import find_passage
from pft_exec.learning.resampling import arc_length, extent_of
from pft_exec.learning.signals import SignalTubes, signal_tubes
from pft_exec.learning.tempo import find_tempo
from pft_exec.learning.turning import turn_by
from pft_exec.learning.variables import ABSOLUTE, START, MotionVariables, Passage

FLOOR = 0.002  # of the extent: standard deviation below which places count as equal
IDLE_SHARE = 0.125  # of the variance is meant for recordings with their idle ends; set on hand guiding in simulation


@dataclass(frozen=True, eq=False)
class RobustMotion:
    """What the robust method learned of one motion.

    Parameters
    ----------
    aligned : AlignedSet
        K demonstrations on N steps.
    start : Endpoint
    experts : Experts
    weights : Weights
    leverage : Leverage
    residual : (K, N, 3) or (K, N, 6), m and rad
        What the blend left of each demonstration when it was left out, at the same step.
    spread : Spread
        Of the same at the same share of the duration, so that timing counts.
    time_deviation : (N,), s
        Of demonstrations in one scene.
    pacing : Pacing
    signals : SignalTubes
    """

    aligned: AlignedSet
    start: Endpoint
    experts: Experts
    weights: Weights
    leverage: Leverage
    residual: Array
    spread: Spread
    time_deviation: Array
    pacing: Pacing
    signals: SignalTubes
    passages: tuple[Passage, ...] = ()


def _tool(aligned: AlignedSet, index: int) -> Array:
    """Tool poses (K, 7) at a step; identity orientation where there is none."""
    place = aligned.position[:, index]
    identity = np.broadcast_to(np.array([0.0, 0.0, 0.0, 1.0]), (len(place), 4))
    return np.hstack([place, identity if aligned.quaternion is None else aligned.quaternion[:, index]])


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
        make_endpoint(variables.end, _tool(aligned, -1), poses, floor),
        keys,
        turn_keys,
        np.stack([local_positions(aligned.position, frame_pose(n, poses, count), axes) for n, axes in keys]),
        local_turn,
        floor,
    )


def _predicted_begin(start: Endpoint, poses: Poses, given: Array, leave_out: bool) -> Array:
    """Poses (M, 7) in which M scenes begin: the relevant start, else the given one."""
    place = target_positions(start, poses, len(given), leave_out)
    turn = target_turns(start, poses, len(given), leave_out)
    return np.hstack([given[:, :3] if place is None else place, given[:, 3:] if turn is None else turn])


def learn_robust(
    demonstrations: Sequence[Demonstration], variables: MotionVariables, way: Sequence[str] | None = None
) -> RobustMotion:
    """Learn one motion, its motion variables being decided; `way` are the objects on it, None where none are named."""
    moving = moving_parts(demonstrations)
    landmarks = find_landmarks(moving, shared_names([d.discrete for d in moving]))
    phases = phases_through(landmarks, STEPS)
    even = sample_at(moving, phases)
    extent = extent_of(list(even.position))
    first = _tool(even, 0)
    poses = {name: object_poses(demonstrations, name) for name in object_names(demonstrations)}
    start = make_endpoint(variables.start, first, poses, FLOOR * extent)
    handled = _handled(demonstrations, landmarks, even, poses, extent)
    begin = _predicted_begin(start, poses, first, leave_out=True)
    passed = passed_landmarks(landmarks, STEPS)
    tempo = find_tempo(even.position, even.quaternion, passed, extent * turn_weight(even.quaternion))

    def left_out_with(names: Sequence[str]) -> LeftOut:
        experts = _make_experts(even, variables, names, poses | {START: first}, extent)
        return leave_one_out(experts, poses | {START: begin}, even, tempo, variables.end.position.overruled)

    names = tuple(dict.fromkeys([*variables.objects, *handled]))
    free = _not_held(demonstrations, poses) if way is None else {name: poses[name] for name in way}
    left_out, passages = _with_passages(left_out_with, names, even.position, free, start.floor, way is not None)
    blend = left_out.blend
    warped = warped_phases(blend.position, blend.turn, even, passed)
    aligned = sample_at(moving, phases_at(warped, phases))
    share = _mean_clock(aligned)
    return RobustMotion(
        aligned=aligned,
        start=start,
        experts=left_out.experts,
        weights=left_out.weights,
        leverage=left_out.leverage,
        residual=_shown_here(left_over(aligned, blend)),
        spread=_timed_spread(demonstrations, moving, share, left_out, start.floor),
        time_deviation=_time_deviation(demonstrations, moving, aligned, share),
        pacing=learn_pacing(blend.position, aligned.position, aligned.time),
        signals=signal_tubes(aligned),
        passages=passages,
    )


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
    tool = np.stack([_tool(even, step) for step in range(even.position.shape[1])], axis=1)
    return handled_objects(landmarks, tool, free, extent, even.quaternion is not None)


def _not_held(demonstrations: Sequence[Demonstration], poses: Poses) -> dict[str, Array]:
    """The objects that the tool did not hold from the start."""
    return _without(poses, carried_objects(demonstrations, from_start=True))


def _without(poses: Poses, names: Sequence[str]) -> dict[str, Array]:
    return {name: pose for name, pose in poses.items() if name not in names}


def _timed_spread(
    demonstrations: Sequence[Demonstration],
    moving: Sequence[Demonstration],
    share: Array,
    left_out: LeftOut,
    floor: float,
) -> Spread:
    """Spread of what the blend leaves at equal shares (K, N) of the time, without and with the idle ends."""

    def seen(recordings: Sequence[Demonstration]) -> Spread:
        residual = left_over(sample_at(recordings, share), left_out.blend)
        residual[..., :3] -= left_out.own
        return find_spread(residual, left_out.blend.position, floor, TURN_FLOOR)

    spread = seen(moving)
    if all(len(whole) == len(part) for whole, part in zip(demonstrations, moving, strict=True)):
        return spread
    return spread.mixed(seen(demonstrations), IDLE_SHARE)


def _time_deviation(
    demonstrations: Sequence[Demonstration], moving: Sequence[Demonstration], aligned: AlignedSet, share: Array
) -> Array:
    """Standard deviation (N,), s, of when the steps are passed, the idle ends counting as in the covariance."""
    head = np.array([[part.time[0] - whole.time[0]] for whole, part in zip(demonstrations, moving, strict=True)])
    idle = np.array([[whole.duration - part.duration] for whole, part in zip(demonstrations, moving, strict=True)])
    shift = share * idle - head
    deviation: Array = np.sqrt(aligned.time.var(axis=0, ddof=1) + IDLE_SHARE * np.mean(shift**2, axis=0))
    return deviation


def _mean_clock(aligned: AlignedSet) -> Array:
    """Shares (K, N) of the duration at which the steps are passed on average, the same for all demonstrations."""
    clock = aligned.time.mean(axis=0)
    return np.broadcast_to(clock / clock[-1], aligned.time.shape)


def _shown_here(residual: Array) -> Array:
    """Leave-one-out residuals (K, N, 3 or 6) as residuals from a mean that each demonstration is part of."""
    count, mean = len(residual), residual.mean(axis=0)
    shown: Array = mean + (count - 1) / count * (residual - mean)
    return shown


def _scene_poses(experts: Experts, variables: MotionVariables, scene: Scene) -> dict[str, Array]:
    needed = [*variables.objects, *(name for name, _ in experts.keys if name not in (START, ABSOLUTE))]
    missing = [name for name in needed if name not in scene]
    if missing:
        raise MissingObjectError("object of the scene", missing[0], scene, "The motion is relative to it.")
    return {name: pose.array[None] for name, pose in scene.objects.items()}


def _given_start(motion: RobustMotion, start: Pose | None) -> Array:
    """Pose (1, 7) of the tool now; the mean demonstrated start where None."""
    if start is not None:
        return start.array[None]
    first = _tool(motion.aligned, 0)
    return np.concatenate([first[:, :3].mean(axis=0), average(first[:, 3:])])[None]


def generalize(
    label: str, motion: RobustMotion, variables: MotionVariables, scene: Scene, start: Pose | None
) -> FlowTube:
    """The flow tube of a motion in a scene.

    Raises
    ------
    MissingObjectError
        If the scene lacks an object that a motion variable refers to.
    """
    poses = _scene_poses(motion.experts, variables, scene)
    given = _given_start(motion, start)
    poses[START] = given
    warn_of_conflict(label, "start", motion.start, poses)
    poses[START] = _predicted_begin(motion.start, poses, given, leave_out=False)
    warn_of_conflict(label, "end", motion.experts.end, poses)
    prediction = predict(motion.experts, poses, leave_out=False)
    blend = blend_experts(motion.experts, poses, prediction, motion.weights, leave_out=False)
    signals, residual = motion.signals, motion.residual[..., :3]
    time = motion.pacing.carried(motion.aligned.time, blend.position[0])
    carried = motion.pacing.bowed(residual, blend.position[0])
    covariance = motion.spread.in_scene(blend.position[0], residual, carried, motion.start.floor)
    said = with_ends(motion.experts, poses, prediction.position, leave_out=False)
    covariance[:, :3, :3] += motion.leverage.beyond(said[:, 0]) + _doubts(motion, poses)
    return FlowTube(
        label,
        time.mean(axis=0),
        blend.position[0],
        None if blend.turn is None else blend.turn[0],
        covariance,
        motion.time_deviation,
        signals.continuous,
        signals.continuous_deviation,
        signals.discrete,
        signals.discrete_values,
        len(time),
        _carried(motion, blend, carried, time),
    )


def _doubts(motion: RobustMotion, poses: Poses) -> Array:
    """Covariance (N, 3, 3), m^2, along the way of ends that may be tied to frames which contradict one another."""
    share = motion.experts.share[:, None, None]
    start, end = doubt(motion.start, poses), doubt(motion.experts.end, poses)
    doubts: Array = (1.0 - share) ** 4 * start + share**4 * end
    return doubts


def _carried(motion: RobustMotion, blend: Prediction, residual: Array, time: Array) -> AlignedDemonstrations:
    """The demonstrations in this scene: the tube, and what each left beside its own prediction."""
    turn = None
    if blend.turn is not None:
        turn = turn_by(blend.turn, motion.residual[..., 3:])
    return AlignedDemonstrations(blend.position + residual, turn, time)
