"""Obstacles: solids in the way of an arm, with a pose and a velocity.

Parts of the robot itself (its body, its other arm) and objects of a scene are the same to an arm that avoids them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pft_exec.description import TaskDescription
from pft_exec.description.shape import BoxShape, CompoundShape, Shape, SphereShape, TrayShape
from pft_exec.exceptions import ConfigurationError
from pft_exec.geometry import Array, Pose, multiply, quaternion_from_rotation_vector, read_only, rotate


@dataclass(frozen=True)
class Sphere:
    """A ball: radius, m."""

    radius: float

    def __post_init__(self) -> None:
        _check_positive(self, self.radius)


@dataclass(frozen=True)
class Capsule:
    """All that is within a radius, m, of a segment of a length, m, on the z axis about the origin."""

    radius: float
    length: float

    def __post_init__(self) -> None:
        _check_positive(self, self.radius, self.length)


@dataclass(frozen=True)
class Box:
    """A box: full lengths along x, y, z, m."""

    size: tuple[float, float, float]

    def __post_init__(self) -> None:
        _check_positive(self, *self.size)


@dataclass(frozen=True)
class Cylinder:
    """A cylinder on the z axis about the origin: radius and height, m."""

    radius: float
    height: float

    def __post_init__(self) -> None:
        _check_positive(self, self.radius, self.height)


Solid = Sphere | Capsule | Box | Cylinder


def _check_positive(solid: object, *lengths: float) -> None:
    if not all(np.isfinite(length) and length > 0.0 for length in lengths):
        raise ConfigurationError(f"lengths of a solid, m, must be positive; got {solid}.")


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A solid in the way.

    Parameters
    ----------
    name : str
    solid : Sphere, Capsule, Box or Cylinder
    pose : Pose
        Of the solid's frame, in the base frame of the robot; `seen_from` converts.
    velocity : (6,), m/s and rad/s
        Of that frame: linear, then angular, along the axes of the base frame.

    Raises
    ------
    ConfigurationError
        If the velocity is not (6,) or not finite.
    """

    name: str
    solid: Solid
    pose: Pose
    velocity: Array = field(default_factory=lambda: np.zeros(6))

    def __post_init__(self) -> None:
        velocity = read_only(self.velocity)
        if velocity.shape != (6,) or not np.isfinite(velocity).all():
            raise ConfigurationError(f"velocity of obstacle {self.name!r} must be (6,), m/s and rad/s; got {velocity}.")
        object.__setattr__(self, "velocity", velocity)

    def after(self, elapsed: float) -> Pose:
        """Pose when it has moved on at its velocity for a time, s."""
        if elapsed == 0.0 or not self.velocity.any():
            return self.pose
        turn = quaternion_from_rotation_vector(elapsed * self.velocity[3:])
        return Pose(self.pose.position + elapsed * self.velocity[:3], multiply(turn, self.pose.quaternion))

    def seen_from(self, frame: Pose) -> Obstacle:
        """The same obstacle in a frame whose pose is given in the frame that the obstacle is in now."""
        back = frame.inverse()
        velocity = rotate(back.quaternion, self.velocity.reshape(2, 3)).ravel()
        return replace(self, pose=back @ self.pose, velocity=velocity)


def solids_of_shape(shape: Shape) -> tuple[tuple[Solid, Pose], ...]:
    """The solids that a task's description of a shape means, and where they are in its frame; hollows are filled."""
    match shape:
        case CompoundShape():
            return tuple(
                (solid, Pose(np.array(part.position)) @ place)
                for part in shape.parts
                for solid, place in solids_of_shape(part.shape)
            )
        case BoxShape() | TrayShape():
            return ((Box(shape.size), Pose(np.zeros(3))),)
        case SphereShape():
            return ((Sphere(shape.radius), Pose(np.zeros(3))),)
        case _:
            return ((Cylinder(shape.radius, shape.height), Pose(np.zeros(3))),)


def task_obstacles(
    task: TaskDescription, poses: Mapping[str, Pose], leave_out: tuple[str, ...] = ()
) -> tuple[Obstacle, ...]:
    """Furniture and objects of a task as obstacles at rest.

    Parameters
    ----------
    task : TaskDescription
    poses : mapping of str to Pose
        Of placed objects, such as a scene; the poses of obstacles are in the same frame. Furniture is where the task
        puts it, which is in the world frame.
    leave_out : tuple of str
        Objects that the arm must come close to: what it grasps, carries or pours into.

    Returns
    -------
    tuple of Obstacle
    """
    fixed = {name: item.fixed.pose for name, item in task.objects.items() if item.fixed is not None}
    places = {**fixed, **{name: pose for name, pose in poses.items() if name in task.objects}}
    return tuple(
        Obstacle(name, solid, pose @ place)
        for name, pose in places.items()
        if name not in leave_out
        for solid, place in solids_of_shape(task.objects[name].shape)
    )
