"""The robust method: what is learned once from the demonstrations of a motion, and the flow tube of a scene from it.

In the flow: align, decide the motion variables, find the experts' weights by leaving each demonstration out
(`learn_robust`); then for each scene blend the experts' predictions and give them the covariance of what the blend
left (`generalize`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.exceptions import MissingObjectError
from pft_exec.geometry import Array, Pose
from pft_exec.learning.alignment import (
    AlignedSet,
    moving_parts,
    sample_at,
    shared_names,
)
from pft_exec.learning.averaging import average
from pft_exec.learning.blending import TURN_FLOOR, Prediction, Weights, blend_experts, left_over, predict, with_ends
from pft_exec.learning.covariance import Spread, find_spread
from pft_exec.learning.draft import draft_in_step, predicted_begin, tool_poses
from pft_exec.learning.endpoint import (
    Endpoint,
    Poses,
    doubt,
    warn_of_conflict,
)
from pft_exec.learning.experts import (
    Experts,
)
from pft_exec.learning.flow_tube import AlignedDemonstrations, FlowTube
from pft_exec.learning.landmarks import (
    find_landmarks,
)
from pft_exec.learning.leave_one_out import LeftOut
from pft_exec.learning.leverage import Leverage
from pft_exec.learning.pacing import Pacing, learn_pacing
from pft_exec.learning.signals import SignalTubes, signal_tubes
from pft_exec.learning.turning import turn_by
from pft_exec.learning.variables import ABSOLUTE, START, MotionVariables, Passage

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


def learn_robust(
    demonstrations: Sequence[Demonstration], variables: MotionVariables, way: Sequence[str] | None = None
) -> RobustMotion:
    """Learn one motion, its motion variables being decided; `way` are the objects on it, None where none are named."""
    moving = moving_parts(demonstrations)
    landmarks = find_landmarks(moving, shared_names([d.discrete for d in moving]))
    draft = draft_in_step(demonstrations, moving, variables, landmarks, way)
    aligned, left_out = draft.aligned, draft.left_out
    share = _mean_clock(aligned)
    return RobustMotion(
        aligned=aligned,
        start=draft.start,
        experts=left_out.experts,
        weights=left_out.weights,
        leverage=left_out.leverage,
        residual=_shown_here(draft.residual),
        spread=_timed_spread(demonstrations, moving, share, left_out, draft.start.floor),
        time_deviation=_time_deviation(demonstrations, moving, aligned, share),
        pacing=learn_pacing(left_out.blend.position, aligned.position, aligned.time),
        signals=signal_tubes(aligned),
        passages=draft.passages,
    )


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
    first = tool_poses(motion.aligned, 0)
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
    poses[START] = predicted_begin(motion.start, poses, given, leave_out=False)
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
