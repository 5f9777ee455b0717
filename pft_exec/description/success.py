"""Success: whether a motion did what its task asks for, judged by where the tool and the objects are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pft_exec.description.motion import Still, ToolAtEnd
from pft_exec.description.path import nominal_goal
from pft_exec.description.task import TaskDescription
from pft_exec.geometry import Pose, geodesic_distance, relative_rotation_vector


@dataclass(frozen=True)
class Verdict:
    """Whether a motion succeeded, and the figures that say so."""

    success: bool
    reason: str


def judge_motion(
    task: TaskDescription, label: str, before: Mapping[str, Pose], after: Mapping[str, Pose], start: Pose, end: Pose
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

    Raises
    ------
    UnknownMotionError
        If the task has no such motion.
    """
    success = task.motion(label).success
    verdicts = []
    if success.tool_at_end is not None:
        verdicts.append(_tool_at_end(success.tool_at_end, nominal_goal(task, label, before, start), end))
    if success.still is not None:
        verdicts.append(_still(task, success.still, before, after))
    return Verdict(all(item.success for item in verdicts), "; ".join(item.reason for item in verdicts))


def _tool_at_end(limits: ToolAtEnd, goal: Pose, end: Pose) -> Verdict:
    distance = float(np.linalg.norm(end.position - goal.position))
    angle = float(geodesic_distance(goal.quaternion, end.quaternion))
    reason = (
        f"tool {1e3 * distance:.1f} mm (at most {1e3 * limits.position:.0f}) and {angle:.3f} rad "
        f"(at most {limits.rotation:.2f}) from where the motion should end"
    )
    return Verdict(distance <= limits.position and angle <= limits.rotation, reason)


def _still(task: TaskDescription, limits: Still, before: Mapping[str, Pose], after: Mapping[str, Pose]) -> Verdict:
    for name in task.placed:
        if name not in before or name not in after:
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
