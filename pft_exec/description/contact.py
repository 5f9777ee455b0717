"""Verdicts on what was held, set down, dropped or poured: by where objects and liquid are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pft_exec.description.measured import Measured, Verdict
from pft_exec.description.motion import START, WORLD
from pft_exec.description.predicates import Held, Placed, Poured, RestsIn
from pft_exec.description.shape import TrayShape
from pft_exec.description.task import TaskDescription
from pft_exec.geometry import Array, Pose

_SLACK = 1e-3  # m; by how much a ball that touches a wall may seem to be inside it


def judge_held(limits: Held, measured: Measured) -> Verdict:
    """Whether the object is in the gripper and has not slipped."""
    if measured.held != limits.object:
        return Verdict(False, f"{limits.object} is not in the gripper ({measured.held or 'nothing'} is)")
    reason = f"{limits.object} slipped by {1e3 * measured.slip:.2f} mm (at most {1e3 * limits.slip:.1f})"
    return Verdict(measured.slip <= limits.slip, reason)


def judge_placed(limits: Placed, before: Mapping[str, Pose], after: Mapping[str, Pose]) -> Verdict:
    """Whether the object stands upright where it should."""
    frame = limits.object if limits.frame == START else limits.frame
    origin = np.zeros(3) if frame == WORLD else before[frame].position
    distance = float(np.linalg.norm(after[limits.object].position - origin - np.array(limits.offset)))
    tilt = lean_of(after[limits.object])
    reason = (
        f"{limits.object} stands {1e3 * distance:.1f} mm (at most {1e3 * limits.position:.0f}) from its place and "
        f"leans by {np.degrees(tilt):.1f} degrees (at most {np.degrees(limits.tilt):.1f})"
    )
    return Verdict(distance <= limits.position and tilt <= limits.tilt, reason)


def judge_poured(
    task: TaskDescription,
    limits: Poured,
    before: Mapping[str, Pose],
    after: Mapping[str, Pose],
    measured: Measured,
) -> Verdict:
    """Whether the liquid is where it should be, and its vessel where it was."""
    count = len(measured.liquid)
    if count == 0:
        return Verdict(False, "there was no liquid")
    arrived = int(inside(task, limits.into, after[limits.into], measured.liquid).sum())
    left = int(inside(task, limits.vessel, after[limits.vessel], measured.liquid).sum())
    moved = float(np.linalg.norm(after[limits.into].position - before[limits.into].position))
    lean = lean_of(after[limits.into])
    reason = (
        f"{arrived} of {count} balls in the {limits.into}, {left} left in the {limits.vessel}; the {limits.into} "
        f"moved by {1e3 * moved:.1f} mm and leans by {np.degrees(lean):.1f} degrees"
    )
    done = arrived >= limits.share * count - 1e-9 and left <= limits.left * count + 1e-9
    return Verdict(done and bool(np.cos(lean) > limits.upright) and moved < limits.moved, reason)


def judge_rests_in(task: TaskDescription, limits: RestsIn, after: Mapping[str, Pose], measured: Measured) -> Verdict:
    """Whether an object lies at rest in a container."""
    is_in = bool(inside(task, limits.container, after[limits.container], after[limits.object].position[None])[0])
    speed = measured.speed.get(limits.object, 0.0)
    where = "in" if is_in else "not in"
    reason = f"{limits.object} is {where} the {limits.container}, at {speed:.3f} m/s (at most {limits.speed:g})"
    return Verdict(is_in and speed <= limits.speed, reason)


def inside(task: TaskDescription, name: str, pose: Pose, points: Array) -> NDArray[np.bool_]:
    """Which points (N, 3), world frame, lie within the outer walls and below the rim of a container at a pose, (N,)."""
    shape = task.objects[name].shape
    local = pose.inverse().apply(points)
    level = np.abs(local[:, 2]) <= 0.5 * shape.height + _SLACK
    if isinstance(shape, TrayShape):
        within = (np.abs(local[:, :2]) <= 0.5 * np.array(shape.size[:2]) + _SLACK).all(axis=1)
    else:
        within = np.hypot(local[:, 0], local[:, 1]) <= shape.outline + _SLACK
    both: NDArray[np.bool_] = level & within
    return both


def lean_of(pose: Pose) -> float:
    """Angle, rad, between an object's own z axis and the vertical."""
    return float(np.arccos(np.clip(pose.rotation[2, 2], -1.0, 1.0)))
