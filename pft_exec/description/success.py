"""Success: whether a motion did what its task asks for, judged by where tool, objects and liquid are and have been.

A verdict looks at physics alone, never at what the demonstrator or the controller meant to do. `contact` judges what
was held, set down or poured, `course` the course of the tool.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TypeVar

import numpy as np

from pft_exec.description.contact import judge_held, judge_placed, judge_poured, judge_rests_in
from pft_exec.description.course import judge_anchored, judge_shaken, judge_stirred, judge_wound
from pft_exec.description.measured import Measured, Verdict
from pft_exec.description.motion import START, WORLD
from pft_exec.description.path import nominal_goal
from pft_exec.description.predicates import Still, SuccessDescription, ToolAtEnd
from pft_exec.description.task import TaskDescription
from pft_exec.geometry import Pose, geodesic_distance, mirror_positions, relative_rotation_vector

__all__ = ["Measured", "Verdict", "judge_motion"]

Told = TypeVar("Told")


def judge_motion(
    task: TaskDescription,
    label: str,
    before: Mapping[str, Pose],
    after: Mapping[str, Pose],
    start: Pose,
    end: Pose,
    measured: Measured | None = None,
    substitute: Mapping[str, str] | None = None,
) -> Verdict:
    """Judge a motion that was made.

    Parameters
    ----------
    task : TaskDescription
    label : str
    before, after : mapping of name to Pose, world frame
        Objects when the motion began and now; fixed ones need not be among them.
    start, end : Pose, world frame
        Of the tool, when the motion began and now.
    measured : Measured, optional
        The tool's course, what it holds, and where the liquid is.
    substitute : {name: name}, optional
        Objects of the scene that take the place of those that the task names.

    Raises
    ------
    UnknownMotionError
        If the task has no such motion.
    """
    plane, measured = task.mirror, measured or Measured()
    if substitute:
        held = _names(substitute).get(measured.held or "", measured.held)
        measured = replace(measured, held=held, speed=_swapped(measured.speed, substitute))
        before, after = (_swapped(poses, substitute) for poses in (before, after))
        task = _exchanged(_standing(task, label, substitute), substitute)
    if plane is not None:
        upright, positions = task.mirrored(), [measured.path, measured.liquid]
        path, liquid = (mirror_positions(each, plane) if len(each) else each for each in positions)
        return judge_motion(
            upright,
            label,
            {name: pose.mirrored(plane) for name, pose in before.items()},
            {name: pose.mirrored(plane) for name, pose in after.items()},
            start.mirrored(plane),
            end.mirrored(plane),
            replace(measured, path=path, liquid=liquid),
        )
    verdicts = list(_verdicts(task, label, before, after, (start, end), measured))
    return Verdict(all(item.success for item in verdicts), "; ".join(item.reason for item in verdicts))


def _names(substitute: Mapping[str, str]) -> dict[str, str]:
    """Name of every substitute to that of what it stands for, and the other way round."""
    return {now: taught for taught, now in substitute.items()} | dict(substitute)


def _swapped(told: Mapping[str, Told], substitute: Mapping[str, str]) -> dict[str, Told]:
    """What is told of every substitute under the name of what it stands for, and the other way round."""
    names = _names(substitute)
    present = (*told, *(name for name in substitute if name not in told))
    return {name: told[names.get(name, name)] for name in present if names.get(name, name) in told}


def _exchanged(task: TaskDescription, substitute: Mapping[str, str]) -> TaskDescription:
    """The task whose objects have the shapes of their substitutes; one that the task does not know has its own."""
    return replace(task, objects={**task.objects, **_swapped(task.objects, substitute)})


def _standing(task: TaskDescription, label: str, substitute: Mapping[str, str]) -> TaskDescription:
    """The task with the height at which a substitute's middle is when it stands in its place, or on what does.

    A substitute that the task does not know is taken to be as high as what it stands for.
    """
    motion = task.motion(label)
    placed = motion.success.placed
    if placed is None or placed.frame == START:
        return task
    height = {name: item.shape.height for name, item in task.objects.items()}
    x, y, z = placed.offset
    standing = {placed.object, placed.frame} - {WORLD}
    z += sum(0.5 * (height.get(substitute.get(name, name), height[name]) - height[name]) for name in standing)
    success = replace(motion.success, placed=replace(placed, offset=(x, y, z)))
    return replace(task, motions={**task.motions, label: replace(motion, success=success)})


def _verdicts(
    task: TaskDescription,
    label: str,
    before: Mapping[str, Pose],
    after: Mapping[str, Pose],
    ends: tuple[Pose, Pose],
    measured: Measured,
) -> Iterator[Verdict]:
    success: SuccessDescription = task.motion(label).success
    if success.tool_at_end is not None:
        yield _tool_at_end(success.tool_at_end, nominal_goal(task, label, before, ends[0]), ends[1])
    if success.still is not None:
        yield _still(task, label, success.still, before, after)
    if success.held is not None:
        yield judge_held(success.held, measured)
    if success.placed is not None:
        yield judge_placed(success.placed, before, after)
    if success.poured is not None:
        yield judge_poured(task, success.poured, before, after, measured)
    if success.rests_in is not None:
        yield judge_rests_in(task, success.rests_in, after, measured)
    if success.shaken is not None:
        yield judge_shaken(success.shaken, measured.path)
    if success.stirred is not None:
        yield judge_stirred(success.stirred, before, measured.path)
    if success.wound is not None:
        yield judge_wound(success.wound, before, measured.path)
    if success.anchored is not None:
        yield judge_anchored(success.anchored, before, measured.path)


def _tool_at_end(limits: ToolAtEnd, goal: Pose, end: Pose) -> Verdict:
    distance = float(np.linalg.norm(end.position - goal.position))
    angle = float(geodesic_distance(goal.quaternion, end.quaternion))
    reason = (
        f"tool {1e3 * distance:.1f} mm (at most {1e3 * limits.position:.0f}) and {angle:.3f} rad "
        f"(at most {limits.rotation:.2f}) from where the motion should end"
    )
    return Verdict(distance <= limits.position and angle <= limits.rotation, reason)


def _still(
    task: TaskDescription, label: str, limits: Still, before: Mapping[str, Pose], after: Mapping[str, Pose]
) -> Verdict:
    holds = task.motion(label).holds
    exempt = {*limits.but, *(() if holds is None else (holds.object,))}
    for name in task.placed:
        if name in exempt or name not in before or name not in after:
            continue
        moved = float(np.linalg.norm(after[name].position - before[name].position))
        turned = _turn(before[name], after[name], task.objects[name].symmetry == "z")
        if moved > limits.position or turned > limits.rotation:
            return Verdict(False, f"{name} was moved by {1e3 * moved:.1f} mm and turned by {turned:.3f} rad")
    return Verdict(True, "objects still")


def _turn(before: Pose, after: Pose, symmetric: bool) -> float:
    """Angle, rad, between two poses; of a symmetric object, how far its z axis leans away from where it was."""
    if symmetric:
        cosine = float(before.rotation[:, 2] @ after.rotation[:, 2])
        return float(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return float(np.linalg.norm(relative_rotation_vector(before.quaternion, after.quaternion)))
