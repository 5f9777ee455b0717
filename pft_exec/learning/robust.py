"""The robust generalization: carry the demonstrations into a new scene and take mean and covariance there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.exceptions import MissingObjectError
from pft_exec.geometry import (
    Array,
    Pose,
    conjugate,
    interpolate_quaternion,
    mean_quaternion,
    multiply,
    quaternion_from_rotation_vector,
    relative_rotation_vector,
)
from pft_exec.learning.flow_tube import AlignedDemonstrations, FlowTube
from pft_exec.learning.variables import ABSOLUTE, NONE, START, FrameDecision, MotionVariables

STEPS = 100


@dataclass(frozen=True, eq=False)
class Resampled:
    """K demonstrations at N common phases: position (K, N, 3), quaternion (K, N, 4) or None, time (K, N) from 0."""

    position: Array
    quaternion: Array | None
    time: Array


def resample(demonstrations: Sequence[Demonstration], steps: int = STEPS) -> Resampled:
    """At `steps` phases, evenly spaced in time."""
    phase = np.linspace(0.0, 1.0, steps)
    positions, quaternions, times = [], [], []
    for d in demonstrations:
        time = phase * d.duration
        own = d.time - d.time[0]
        positions.append(np.stack([np.interp(time, own, d.position[:, i]) for i in range(3)], axis=1))
        times.append(time)
        if d.quaternion is not None:
            place = np.clip(np.searchsorted(own, time, side="right") - 1, 0, len(own) - 2)
            ratio = (time - own[place]) / (own[place + 1] - own[place])
            quaternions.append(interpolate_quaternion(d.quaternion[place], d.quaternion[place + 1], ratio))
    return Resampled(np.stack(positions), np.stack(quaternions) if quaternions else None, np.stack(times))


def _target_position(decision: FrameDecision, frames: Mapping[str, Pose]) -> Array | None:
    if decision.frame == NONE:
        return None
    frame = frames[decision.frame]
    if decision.axes == "object":
        return frame.apply(decision.offset)
    offset: Array = frame.position + decision.offset
    return offset


def _target_quaternion(decision: FrameDecision | None, frames: Mapping[str, Pose]) -> Array | None:
    if decision is None or decision.frame == NONE:
        return None
    turn = quaternion_from_rotation_vector(decision.offset)
    frame = frames[decision.frame].quaternion
    if decision.frame == START and decision.axes == "world":
        return multiply(turn, frame)
    return multiply(frame, turn)


def _frames(scene: Scene, variables: MotionVariables, start: Pose) -> dict[str, Pose]:
    missing = [name for name in variables.objects if name not in scene]
    if missing:
        raise MissingObjectError("object of the scene", missing[0], scene, "The motion is relative to it.")
    return {ABSOLUTE: Pose(np.zeros(3)), START: start} | {name: scene[name] for name in variables.objects}


def generalize(
    label: str,
    resampled: Resampled,
    variables: MotionVariables,
    scene: Scene,
    start: Pose | None,
) -> FlowTube:
    """The flow tube of one scene: every demonstration bent to the required ends, then mean and covariance."""
    mean_start = Pose(
        resampled.position[:, 0].mean(axis=0),
        np.array([0.0, 0.0, 0.0, 1.0]) if resampled.quaternion is None else mean_quaternion(resampled.quaternion[:, 0]),
    )
    given = start or mean_start
    frames = _frames(scene, variables, given)
    begin = _target_position(variables.start.position, frames)
    begin = given.position if begin is None else begin
    begin_turn = _target_quaternion(variables.start.orientation, frames)
    frames[START] = Pose(begin, given.quaternion if begin_turn is None else begin_turn)
    end = _target_position(variables.end.position, frames)
    position = resampled.position
    phase = np.linspace(0.0, 1.0, position.shape[1])[None, :, None]
    if end is None:
        end = begin + (position[:, -1] - position[:, 0]).mean(axis=0)
    carried = position + (1 - phase) * (begin - position[:, :1]) + phase * (end - position[:, -1:])
    spread = variables.start.position.spread**2 / 3, variables.end.position.spread**2 / 3
    mean = carried.mean(axis=0)
    residual = carried - mean
    quaternion = carried_turns = None
    ramp = phase[0, :, 0]
    ends = (1 - ramp) ** 2 * spread[0] * (variables.start.position.frame != NONE) + ramp**2 * spread[1]
    if resampled.quaternion is not None:
        carried_turns = _turn(resampled.quaternion, variables, frames)
        quaternion = mean_quaternion(carried_turns)
        residual = np.concatenate([residual, relative_rotation_vector(quaternion, carried_turns)], axis=-1)
    covariance = np.einsum("kni,knj->nij", residual, residual) / max(len(position) - 1, 1)
    covariance[:, :3, :3] += ends[:, None, None] * np.eye(3)
    extent = np.linalg.norm(np.ptp(mean, axis=0))
    floor = np.full(covariance.shape[-1], 0.02**2)
    floor[:3] = max(0.01 * float(extent), 1e-6) ** 2
    covariance += np.diag(floor)
    return FlowTube(
        label,
        resampled.time.mean(axis=0),
        mean,
        quaternion,
        covariance,
        resampled.time.std(axis=0, ddof=1),
        count=len(position),
        aligned=AlignedDemonstrations(carried, carried_turns, resampled.time),
    )


def _turn(quaternions: Array, variables: MotionVariables, frames: Mapping[str, Pose]) -> Array:
    """Orientations (K, N, 4) corrected at both ends, the correction growing evenly between."""
    begin = frames[START].quaternion
    end = _target_quaternion(variables.end.orientation, frames)
    if end is None:
        end = multiply(begin, mean_quaternion(multiply(conjugate(quaternions[:, 0]), quaternions[:, -1])))
    phase = np.linspace(0.0, 1.0, quaternions.shape[1])[None, :, None]
    first = relative_rotation_vector(quaternions[:, 0], np.broadcast_to(begin, quaternions[:, 0].shape))
    last = relative_rotation_vector(quaternions[:, -1], np.broadcast_to(end, quaternions[:, -1].shape))
    step = (1 - phase) * first[:, None] + phase * last[:, None]
    return multiply(quaternions, quaternion_from_rotation_vector(step))
