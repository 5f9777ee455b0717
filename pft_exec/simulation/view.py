"""Views: where a camera stands and looks, by name or so that everything that counts is in the picture."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from pft_exec.description import BoxShape, TaskDescription, TrayShape
from pft_exec.geometry import Array, Pose, mirror_positions

if TYPE_CHECKING:
    from pft_exec.simulation.world import World

_MARGIN = 0.94  # share of the picture's width and height that is filled at most
_LARGEST = 1.5  # of the extent of arm, objects and workspace; larger furniture may be cut off
_NEAREST = 0.3  # m between the camera and whatever is in its picture
_FIELD = 36.0  # degrees
_TOWARDS = (-1.25, 0.85, -0.85)
"""From beyond the workspace, the side of the right arm and above; robot's base frame."""
_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


@dataclass(frozen=True)
class View:
    """Where a camera stands and looks, in the robot's base frame, m, and its vertical field of view, degrees."""

    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    field_of_view: float

    def mirrored(self) -> View:
        """The same from the robot's other side."""
        (x, y, z), (u, v, w) = self.eye, self.target
        return View((x, -y, z), (u, -v, w), self.field_of_view)


_RIGHT = {
    "room": View(eye=(2.5, -1.75, 1.9), target=(0.3, -0.06, 0.83), field_of_view=38.0),
    "table": View(eye=(1.75, -1.0, 1.5), target=(0.48, -0.13, 0.89), field_of_view=38.0),
}
_LEFT = {f"{name}_left": view.mirrored() for name, view in _RIGHT.items()}
VIEWS = MappingProxyType(_RIGHT | _LEFT)


def camera_axes(direction: Array) -> Array:
    """Unit vectors right, up and forward (3, 3), as rows, of a level camera that looks in a direction (3,)."""
    forward = direction / np.linalg.norm(direction)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    axes: Array = np.stack([right, np.cross(right, forward), forward])
    return axes


def nearest_view(points: Array, direction: Array, field_of_view: float, aspect: float) -> tuple[Array, Array]:
    """Where the nearest camera that sees all points, looking in a direction, stands (3,), and a point it looks at (3,).

    Parameters
    ----------
    points : (M, 3), m
    direction : (3,)
        Of the camera, which is held level.
    field_of_view : float, degrees
        Vertical.
    aspect : float
        Width of the picture by its height.

    Notes
    -----
    Each edge of the picture is a plane through the eye. Along either axis of the picture, the planes that touch the
    outermost points cross at the nearest place from which both are seen: one bound on the eye's depth per axis. A third
    keeps the eye off the nearest point.
    """
    axes = camera_axes(direction)
    across, depth = points @ axes[:2].T, points @ axes[2]
    slope = _MARGIN * np.tan(0.5 * np.radians(field_of_view)) * np.array([aspect, 1.0])
    highest = (across - slope * depth[:, None]).max(axis=0)
    lowest = (across + slope * depth[:, None]).min(axis=0)
    back = min(float(np.min((lowest - highest) / (2.0 * slope))), float(depth.min()) - _NEAREST)
    eye = np.array([*(0.5 * (highest + lowest)), back]) @ axes
    return eye, eye + (float(np.median(depth)) - back) * axes[2]


def whole_view(world: World, arm: str, points: Iterable[Array] = (), aspect: float = 4.0 / 3.0) -> View:
    """A view of an arm, of the objects as they stand now, of what they stand on and of the task's workspace, whole.

    Parameters
    ----------
    world : World
    arm : str
        The camera stands on its side.
    points : iterable of (M, 3), m, world frame
        Also to be seen, such as `extent` at other instants.
    aspect : float
        Width of the picture by its height.
    """
    x, y, z = _TOWARDS
    side = 1.0 if world.arm_name() == arm else -1.0
    seen = np.vstack([extent(world, arm), _corners_of_workspace(world.task_for(arm)), *points])
    size = _LARGEST * float(np.linalg.norm(np.ptp(seen, axis=0)))
    seen = np.vstack([seen, *_corners_of_furniture(world.task, size)])
    eye, target = nearest_view(seen, world.base.rotation @ np.array([x, side * y, z]), _FIELD, aspect)
    (a, b, c), (u, v, w) = world.base.inverse().apply([eye, target]).tolist()
    return View((a, b, c), (u, v, w), _FIELD)


def extent(world: World, arm: str) -> Array:
    """Points (M, 3), m, world frame, whose hull holds an arm's links and the placed objects as they are now."""
    model = world.arm(arm)
    rotation, translation, _ = model.joint_frames(world.true_state(arm)[0])
    points = []
    for link in model.geometry.links:
        ends = np.stack([link.start, link.end])
        if link.joint >= 0:
            ends = ends @ rotation[link.joint].T + translation[link.joint]
        points.append(world.base.apply(ends[:, None] + link.radius * _CORNERS).reshape(-1, 3))
    points += [_corners_of_object(world.task, name, pose) for name, pose in world.scene.objects.items()]
    return np.vstack(points)


def _corners_of_object(task: TaskDescription, name: str, pose: Pose) -> Array:
    shape = task.objects[name].shape
    if isinstance(shape, BoxShape | TrayShape):
        return pose.apply(0.5 * np.array(shape.size) * _CORNERS)
    return pose.apply(np.array([shape.outline, shape.outline, 0.5 * shape.height]) * _CORNERS)


def _corners_of_furniture(task: TaskDescription, size: float) -> list[Array]:
    """Of each piece that is no larger than `size`, m: a wall or a floor would leave nothing to be seen of the rest."""
    standing = {name: item.fixed.pose for name, item in task.objects.items() if item.fixed is not None}
    corners = [_corners_of_object(task, name, pose) for name, pose in standing.items()]
    return [piece for piece in corners if np.linalg.norm(np.ptp(piece, axis=0)) <= size]


def _corners_of_workspace(task: TaskDescription) -> Array:
    corners = np.array(list(product(task.workspace.x, task.workspace.y, task.workspace.z)))
    return corners if task.mirror is None else mirror_positions(corners, task.mirror)
