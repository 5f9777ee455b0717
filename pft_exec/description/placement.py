"""Placement: scenes and starts drawn from the ranges of a task, one by one or spread evenly over several.

All is drawn for the task as written and mirrored at the end where the task is mirrored. Every draw keeps the task's
clearances; `accept` lets a caller who knows the robot refuse what the arm does not reach.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pft_exec.description.clearance import hand_clearance, object_clearance, workspace_excess
from pft_exec.description.motion import START, StartDescription
from pft_exec.description.object import Placement
from pft_exec.description.path import Waypoints, resolve_waypoints
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
_CURVE_STRIDE = 5  # every so many samples of a curve are looked at


@dataclass(frozen=True)
class Setting:
    """Objects, world frame, and the tool's pose before a motion begins."""

    objects: dict[str, Pose]
    start: Pose


Accept = Callable[[Setting], bool]


def draw_scene(task: TaskDescription, rng: np.random.Generator, label: str | None = None) -> dict[str, Pose]:
    """Poses of all placed objects, world frame, drawn uniformly from their ranges, clear of one another.

    With a label, from the ranges that hold for that motion; what it holds stands where its own range says.

    Raises
    ------
    UnreachableError
        If the ranges leave no room.
    """
    for _ in range(_ATTEMPTS):
        objects = _objects_at(task, rng.random(3 * len(task.placed)), label)
        if object_clearance(task, objects) >= task.clearance.objects:
            return _mirrored(task, objects)
    raise UnreachableError(f"task {task.name!r}: no placement found with {task.clearance.objects} m between objects.")


def nominal_setting(task: TaskDescription, label: str, objects: Mapping[str, Pose]) -> Setting:
    """Objects as given, world frame, and the tool in the middle of where it may stand before that motion begins.

    Of a motion that follows others it is the setting of the first of them.
    """
    first = task.chain(label)[0]
    start = _start_at(task.start_of(first), np.full(6, 0.5), _mirrored(task, dict(objects)))
    return setting_from(task, label, objects, start if task.mirror is None else start.mirrored(task.mirror))


def setting_from(task: TaskDescription, label: str, objects: Mapping[str, Pose], start: Pose) -> Setting:
    """Objects, world frame, and the tool's pose before a motion; what it holds is where that gripper is."""
    upright = start if task.mirror is None else start.mirrored(task.mirror)
    return Setting(dict(objects) | _mirrored(task, _held_by(task, task.chain(label)[0], upright)), start)


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
    """Whether the hand, on straight lines through the waypoints, stays in the workspace and clear of every object.

    What the motion holds or touches may be near; a motion that follows others is looked at with them.
    """
    start, held = setting.start, frozenset[str]()
    for part in task.chain(label):
        held |= task.motion(part).held
        waypoints = resolve_waypoints(task, part, setting.objects, start)
        positions, quaternions = _straight_path(waypoints)
        if workspace_excess(task, positions) > 0.0:
            return False
        touched, near = held | task.motion(part).exempt, _samples_before_contact(waypoints)
        parts = [(set(setting.objects) - touched, len(positions)), (touched - held, near)]
        if any(_is_near(task, setting, names, positions[:end], quaternions[:end]) for names, end in parts):
            return False
        start = waypoints.end
    return True


def _is_near(task: TaskDescription, setting: Setting, names: Iterable[str], positions: Array, turned: Array) -> bool:
    """Whether the hand, on a path, comes too near to some objects."""
    if not len(positions):
        return False
    objects = {name: setting.objects[name] for name in names}
    return hand_clearance(task, objects, positions, turned) < task.clearance.hand.gap


def _straight_path(waypoints: Waypoints) -> tuple[Array, Array]:
    """Positions (N, 3) and orientations (N, 4) on straight lines through the waypoints, then on the curve."""
    ratio = np.linspace(0.0, 1.0, _PATH_SAMPLES)
    places, turns = waypoints.positions, waypoints.quaternions
    positions = [places[:1], *(_between(a, b, ratio) for a, b in pairwise(places))]
    turned = [turns[:1], *(interpolate_quaternion(a, b, ratio) for a, b in pairwise(turns))]
    if waypoints.curve is not None:
        positions.append(places[-1] + waypoints.curve[::_CURVE_STRIDE])
        turned.append(np.broadcast_to(turns[-1], (len(positions[-1]), 4)))
    return np.concatenate(positions), np.concatenate(turned)


def _samples_before_contact(waypoints: Waypoints) -> int:
    """Samples of the straight path up to the waypoint before the one at which the gripper first moves; 0 for none."""
    first = waypoints.grips[0][0] if waypoints.grips else 0
    return 1 + (first - 1) * _PATH_SAMPLES if first else 0


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
    first = task.chain(label)[0]
    objects = _objects_at(task, unit[6:], first) if given is None else _mirrored(task, dict(given))
    start = _start_at(task.start_of(first), unit[:6], objects)
    held = _held_by(task, first, start)
    standing = {name: pose for name, pose in objects.items() if name not in held}
    if given is None and object_clearance(task, standing) < task.clearance.objects:
        return None
    setting = Setting(
        (_mirrored(task, objects) if given is None else dict(given)) | _mirrored(task, held),
        start if task.mirror is None else start.mirrored(task.mirror),
    )
    return setting if path_is_free(task, label, setting) else None


def _held_by(task: TaskDescription, label: str, start: Pose) -> dict[str, Pose]:
    """What is put into the gripper that stands at a start, and where it is then; both unmirrored."""
    holds = task.motion(label).holds
    if holds is None or task.start_of(label).frame == holds.object:
        return {}
    return {holds.object: start @ holds.grip}


def _mirrored(task: TaskDescription, objects: dict[str, Pose]) -> dict[str, Pose]:
    if task.mirror is None:
        return objects
    return {name: pose.mirrored(task.mirror) for name, pose in objects.items()}


def _objects_at(task: TaskDescription, unit: Array, label: str | None) -> dict[str, Pose]:
    """Placed objects, unmirrored, at coordinates (3 M,) in [0, 1] of the ranges that hold for a motion."""
    own = {} if label is None else task.motion(label).placements
    return {
        name: _object_at(task, name, own.get(name, task.objects[name].placement), unit[3 * index : 3 * index + 3])
        for index, name in enumerate(task.placed)
    }


def _object_at(task: TaskDescription, name: str, placement: Placement | None, unit: Array) -> Pose:
    item = task.objects[name]
    if placement is None:
        raise ValueError(f"object {name!r} is fixed.")
    below = task.objects[placement.on]
    if below.fixed is None:
        raise ValueError(f"object {placement.on!r} is not fixed.")
    height = below.fixed.position[2] + 0.5 * below.shape.height + 0.5 * item.shape.height
    ranges = (placement.x, placement.y, placement.yaw)
    x, y, yaw = (_within(values, ratio) for values, ratio in zip(ranges, unit, strict=True))
    return Pose(np.array([x, y, height]), quaternion_from_rpy((0.0, 0.0, yaw)))


def _start_at(start: StartDescription, unit: Array, objects: Mapping[str, Pose]) -> Pose:
    position = [_within(values, ratio) for values, ratio in zip((start.x, start.y, start.z), unit[:3], strict=True)]
    turn = (2.0 * unit[3:6] - 1.0) * np.array(start.turned)
    origin = objects[start.frame].position if start.frame in objects else np.zeros(3)
    return Pose(origin + np.array(position), multiply(start.quaternion, quaternion_from_rotation_vector(turn)))


def _within(values: Range, ratio: float) -> float:
    return values[0] + float(ratio) * (values[1] - values[0])


def _none_found(task: TaskDescription, label: str) -> UnreachableError:
    return UnreachableError(
        f"task {task.name!r}: no scene and {START} found from which {label!r} can be made; widen the ranges of its "
        f"objects or starts, or lower the clearances."
    )
