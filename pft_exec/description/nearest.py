"""The nearest placement that can be worked in: what to tell a user whose scene cannot.

All that a motion refers to is moved, together and step by step, towards the middle of where the task places it; the
first place that will do is found by bisection.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from pft_exec.description.placement import Setting, nominal_setting, setting_from
from pft_exec.description.quantities import quaternion_from_rpy
from pft_exec.description.task import TaskDescription
from pft_exec.geometry import Pose, interpolate_quaternion

_HALVINGS = 6  # of the way from a scene to the middle of its placements: 1/64 of it, some millimetres
_MOVED = 1e-3  # m; less is not worth telling


def nearest_setting(
    task: TaskDescription, label: str, setting: Setting, feasible: Callable[[Setting], bool]
) -> Setting | None:
    """The feasible setting nearest to a given one, on the way to the middle of the task's placements.

    Parameters
    ----------
    task : TaskDescription
        Mirrored where the arm needs it.
    label : str
    setting : Setting
        That cannot be worked in, world frame.
    feasible : callable
        Says whether a setting can.

    Returns
    -------
    Setting or None
        None where not even the middle will do.
    """
    middle = _middle(task, label, setting)
    if not feasible(middle):
        return None
    bad, good, best = 0.0, 1.0, middle
    for _ in range(_HALVINGS):
        share = 0.5 * (bad + good)
        between = _between(task, label, setting, middle, share)
        if feasible(between):
            good, best = share, between
        else:
            bad = share
    return best


def told_placement(
    task: TaskDescription,
    label: str,
    asked: Setting,
    nearest: Setting | None,
    substitute: Mapping[str, str] | None = None,
) -> str:
    """What would do instead, in words: one sentence; objects that take another's place go by their own names."""
    if nearest is None:
        return "Not even the middle of the task's placements will do."
    names = substitute or {}
    moved = [
        f"{names.get(name, name)} at ({', '.join(f'{x:.3f}' for x in nearest.objects[name].position[:2])}) m"
        for name in _concerned(task, label)
        if name in asked.objects and _distance(asked.objects[name], nearest.objects[name]) > _MOVED
    ]
    if _distance(asked.start, nearest.start) > _MOVED:
        moved.append(f"the tool begins at ({', '.join(f'{x:.3f}' for x in nearest.start.position)}) m")
    return f"The nearest placement found that will do: {', '.join(moved)}." if moved else ""


def _concerned(task: TaskDescription, label: str) -> tuple[str, ...]:
    """Objects whose place decides where a motion, or one that it follows, goes."""
    names: list[str] = []
    for part in task.chain(label):
        frame = task.start_of(part).frame
        names += [*task.motion(part).objects, *([frame] if frame in task.placed else [])]
    return tuple(dict.fromkeys(names))


def _middle(task: TaskDescription, label: str, setting: Setting) -> Setting:
    """Concerned objects in the middle of their placements, the tool in the middle of its starts."""
    objects: dict[str, Pose] = dict(setting.objects)
    own = task.motion(task.chain(label)[0]).placements
    for name in _concerned(task, label):
        placement = own.get(name, task.objects[name].placement)
        if placement is None:
            continue
        x, y = (0.5 * (low + high) for low, high in (placement.x, placement.y))
        below = task.objects[placement.on]
        top = 0.0 if below.fixed is None else below.fixed.position[2] + 0.5 * below.shape.height
        height = top + 0.5 * task.objects[name].shape.height
        pose = Pose(np.array([x, y, height]), quaternion_from_rpy((0.0, 0.0, 0.5 * sum(placement.yaw))))
        objects[name] = pose if task.mirror is None else pose.mirrored(task.mirror)
    return nominal_setting(task, label, objects)


def _between(task: TaskDescription, label: str, first: Setting, last: Setting, share: float) -> Setting:
    objects: Mapping[str, Pose] = {
        name: _mixed(pose, last.objects[name], share) for name, pose in first.objects.items()
    }
    return setting_from(task, label, objects, _mixed(first.start, last.start, share))


def _mixed(first: Pose, last: Pose, share: float) -> Pose:
    position = (1.0 - share) * first.position + share * last.position
    return Pose(position, interpolate_quaternion(first.quaternion, last.quaternion, share))


def _distance(first: Pose, last: Pose) -> float:
    return float(np.linalg.norm(first.position - last.position))
