"""Placement: scenes and starts drawn from the ranges of a task, one by one or spread evenly over several.

All is drawn for the task as written and mirrored at the end where the task is mirrored. Every draw keeps the task's
clearances; `accept` lets a caller who knows the robot refuse what the arm does not reach.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pft_exec.description.clearance import hand_clearance, object_clearance, workspace_excess
from pft_exec.description.motion import START, StartDescription
from pft_exec.description.path import resolve_waypoints
from pft_exec.description.quantities import Range, quaternion_from_rpy
from pft_exec.description.task import TaskDescription
from pft_exec.exceptions import UnreachableError
from pft_exec.geometry import (
    Array,
    Pose,
    interpolate_quaternion,
    multiply,
    quaternion_from_rotation_vector,
)

_ATTEMPTS = 200
_SPREAD_ATTEMPTS = 20  # at spreading several draws evenly
_CELL_ATTEMPTS = 12
_PATH_SAMPLES = 12  # along each straight piece between waypoints


@dataclass(frozen=True)
class Setting:
    """Objects, world frame, and the tool's pose before a motion begins."""

    objects: dict[str, Pose]
    start: Pose


Accept = Callable[[Setting], bool]


def draw_scene(task: TaskDescription, rng: np.random.Generator) -> dict[str, Pose]:
    """Poses of all placed objects, world frame, drawn uniformly from their ranges, clear of one another.

    Raises
    ------
    UnreachableError
        If the ranges leave no room.
    """
    for _ in range(_ATTEMPTS):
        objects = _objects_at(task, rng.random(3 * len(task.placed)))
        if object_clearance(task, objects) >= task.clearance.objects:
            return _mirrored(task, objects)
    raise UnreachableError(f"task {task.name!r}: no placement found with {task.clearance.objects} m between objects.")


def draw_start(task: TaskDescription, label: str, rng: np.random.Generator) -> Pose:
    """The tool's pose before a motion, world frame, drawn uniformly from its ranges; looks at no object."""
    start = _start_at(task.start_of(label), rng.random(6))
    return start if task.mirror is None else start.mirrored(task.mirror)


def draw_setting(
    task: TaskDescription,
    label: str,
    rng: np.random.Generator,
    accept: Accept | None = None,
    *,
    objects: Mapping[str, Pose] | None = None,
) -> Setting:
    """A scene and a start from which the motion's path is free, and that `accept` does not refuse.

    Where `objects`, world frame, are given, only the start is drawn.

    Raises
    ------
    UnreachableError
        If none is found.
    """
    draws = (rng.random(_dimensions(task)) for _ in range(_ATTEMPTS))
    setting = _first_accepted(task, label, draws, accept, objects)
    if setting is None:
        raise _none_found(task, label)
    return setting


def draw_settings(
    task: TaskDescription,
    label: str,
    count: int,
    rng: np.random.Generator,
    accept: Accept | None = None,
    *,
    objects: Mapping[str, Pose] | None = None,
) -> list[Setting]:
    """Scenes and starts for several demonstrations of one motion, spread evenly: each range is used whole.

    Parameters
    ----------
    task : TaskDescription
    label : str
    count : int
        Each range is cut into so many cells, and every cell is used once (Latin hypercube); each draw lies in the
        inner half of its cell, so that the draws span at least (1 - 1.5 / count) of each range.
    rng : Generator
    accept : callable, optional
        Says whether a setting can be taught; a refused one is drawn again.
    objects : mapping of name to Pose, optional
        World frame; where given, only starts are drawn.

    Raises
    ------
    UnreachableError
        If no such settings are found.
    """
    for _ in range(_SPREAD_ATTEMPTS):
        cells = np.stack([rng.permutation(count) for _ in range(_dimensions(task))], axis=1)
        settings: list[Setting] = []
        for cell in cells:
            setting = _first_accepted(task, label, _draws_in_cell(cell, count, rng), accept, objects)
            if setting is None:
                break
            settings.append(setting)
        if len(settings) == count:
            return settings
    raise _none_found(task, label)


def path_is_free(task: TaskDescription, label: str, setting: Setting) -> bool:
    """Whether the hand, on straight lines through the waypoints, stays in the workspace and clear of every object."""
    waypoints = resolve_waypoints(task, label, setting.objects, setting.start)
    ratio = np.linspace(0.0, 1.0, _PATH_SAMPLES)
    pairs = list(pairwise(range(len(waypoints.positions))))
    positions = np.concatenate([_between(waypoints.positions[a], waypoints.positions[b], ratio) for a, b in pairs])
    turned = [interpolate_quaternion(waypoints.quaternions[a], waypoints.quaternions[b], ratio) for a, b in pairs]
    if workspace_excess(task, positions) > 0.0:
        return False
    return hand_clearance(task, setting.objects, positions, np.concatenate(turned)) >= task.clearance.hand.gap


def _between(first: Array, last: Array, ratio: Array) -> Array:
    return first + ratio[:, None] * (last - first)


def _draws_in_cell(cell: Array, count: int, rng: np.random.Generator) -> Iterator[Array]:
    """Coordinates (D,) in the inner half of a cell, one after another."""
    for _ in range(_CELL_ATTEMPTS):
        yield (cell + rng.uniform(0.25, 0.75, len(cell))) / count


def _first_accepted(
    task: TaskDescription,
    label: str,
    draws: Iterator[Array],
    accept: Accept | None,
    objects: Mapping[str, Pose] | None,
) -> Setting | None:
    for unit in draws:
        setting = _setting_at(task, label, unit, objects)
        if setting is not None and (accept is None or accept(setting)):
            return setting
    return None


def _dimensions(task: TaskDescription) -> int:
    return 6 + 3 * len(task.placed)


def _setting_at(
    task: TaskDescription, label: str, unit: Array, given: Mapping[str, Pose] | None = None
) -> Setting | None:
    """The setting at coordinates (D,) in [0, 1] of the ranges; None where it is not clear."""
    objects = _objects_at(task, unit[6:])
    if given is None and object_clearance(task, objects) < task.clearance.objects:
        return None
    start = _start_at(task.start_of(label), unit[:6])
    setting = Setting(
        _mirrored(task, objects) if given is None else dict(given),
        start if task.mirror is None else start.mirrored(task.mirror),
    )
    return setting if path_is_free(task, label, setting) else None


def _mirrored(task: TaskDescription, objects: dict[str, Pose]) -> dict[str, Pose]:
    if task.mirror is None:
        return objects
    return {name: pose.mirrored(task.mirror) for name, pose in objects.items()}


def _objects_at(task: TaskDescription, unit: Array) -> dict[str, Pose]:
    return {name: _object_at(task, name, unit[3 * index : 3 * index + 3]) for index, name in enumerate(task.placed)}


def _object_at(task: TaskDescription, name: str, unit: Array) -> Pose:
    item = task.objects[name]
    if item.placement is None:
        raise ValueError(f"object {name!r} is fixed.")
    below = task.objects[item.placement.on]
    if below.fixed is None:
        raise ValueError(f"object {item.placement.on!r} is not fixed.")
    height = below.fixed.position[2] + 0.5 * below.shape.height + 0.5 * item.shape.height
    ranges = (item.placement.x, item.placement.y, item.placement.yaw)
    x, y, yaw = (_within(values, ratio) for values, ratio in zip(ranges, unit, strict=True))
    return Pose(np.array([x, y, height]), quaternion_from_rpy((0.0, 0.0, yaw)))


def _start_at(start: StartDescription, unit: Array) -> Pose:
    position = [_within(values, ratio) for values, ratio in zip((start.x, start.y, start.z), unit[:3], strict=True)]
    turn = (2.0 * unit[3:6] - 1.0) * np.array(start.turned)
    return Pose(np.array(position), multiply(start.quaternion, quaternion_from_rotation_vector(turn)))


def _within(values: Range, ratio: float) -> float:
    return values[0] + float(ratio) * (values[1] - values[0])


def _none_found(task: TaskDescription, label: str) -> UnreachableError:
    return UnreachableError(
        f"task {task.name!r}: no scene and {START} found from which {label!r} can be made; widen the ranges of its "
        f"objects or starts, or lower the clearances."
    )
