"""Shapes of objects in the physics engine: what collides, and what is seen.

A hollow shape is a shell of boxes, which is exact for a tray and a many-sided one for a vessel. Every shape is a list
of convex pieces about the object's middle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pybullet

from pft_exec.description import (
    BoxShape,
    CompoundShape,
    CylinderShape,
    SphereShape,
    TrayShape,
    VesselShape,
)
from pft_exec.geometry import Array, Pose, quaternion_from_rotation_vector, rotate

Shape = BoxShape | CylinderShape | SphereShape | VesselShape | TrayShape | CompoundShape


@dataclass(frozen=True, eq=False)
class Piece:
    """A convex piece: its kind in the engine, its measures, m, and its pose in the object's frame.

    `half` is used by boxes, `radius` by cylinders and spheres, `length` by cylinders.
    """

    kind: int
    pose: Pose
    half: tuple[float, float, float] = (1.0, 1.0, 1.0)
    radius: float = 1.0
    length: float = 1.0


def pieces_of(shape: Shape, hollow: bool) -> list[Piece]:
    """The convex pieces that a shape is made of; a vessel that need not be `hollow` is a cylinder."""
    if isinstance(shape, CompoundShape):
        return [_moved(piece, part.position) for part in shape.parts for piece in pieces_of(part.shape, hollow)]
    if isinstance(shape, TrayShape):
        return _tray(shape)
    if isinstance(shape, VesselShape) and hollow:
        return _vessel(shape)
    if isinstance(shape, BoxShape):
        x, y, z = shape.size
        return [_box(x, y, z, (0.0, 0.0, 0.0))]
    middle = Pose(np.zeros(3))
    if isinstance(shape, SphereShape):
        return [Piece(pybullet.GEOM_SPHERE, middle, radius=shape.radius)]
    return [Piece(pybullet.GEOM_CYLINDER, middle, radius=shape.radius, length=shape.height)]


def half_width(shape: Shape, direction: Array) -> float:
    """Half of an object's extent, m, between two flat pads that close along a direction (3,), object frame."""
    if isinstance(shape, BoxShape | TrayShape):
        return float(0.5 * np.abs(direction) @ np.array(shape.size))
    return shape.outline


def create_collision_shape(pieces: list[Piece], client: int) -> int:
    """Hand pieces to the engine as one collision shape."""
    if len(pieces) == 1 and not pieces[0].pose.position.any():
        only = pieces[0]
        return int(
            pybullet.createCollisionShape(
                only.kind, halfExtents=only.half, radius=only.radius, height=only.length, physicsClientId=client
            )
        )
    return int(
        pybullet.createCollisionShapeArray(
            shapeTypes=[piece.kind for piece in pieces],
            radii=[piece.radius for piece in pieces],
            halfExtents=[piece.half for piece in pieces],
            lengths=[piece.length for piece in pieces],
            collisionFramePositions=[piece.pose.position.tolist() for piece in pieces],
            collisionFrameOrientations=[piece.pose.quaternion.tolist() for piece in pieces],
            physicsClientId=client,
        )
    )


def create_visual_shape(pieces: list[Piece], color: list[float], client: int) -> int:
    """Hand pieces to the engine as one visual shape of a color (red, green, blue, opacity)."""
    if len(pieces) == 1 and not pieces[0].pose.position.any():
        only = pieces[0]
        return int(
            pybullet.createVisualShape(
                only.kind,
                halfExtents=only.half,
                radius=only.radius,
                length=only.length,
                rgbaColor=color,
                physicsClientId=client,
            )
        )
    return int(
        pybullet.createVisualShapeArray(
            shapeTypes=[piece.kind for piece in pieces],
            radii=[piece.radius for piece in pieces],
            halfExtents=[piece.half for piece in pieces],
            lengths=[piece.length for piece in pieces],
            rgbaColors=[color for _ in pieces],
            visualFramePositions=[piece.pose.position.tolist() for piece in pieces],
            visualFrameOrientations=[piece.pose.quaternion.tolist() for piece in pieces],
            physicsClientId=client,
        )
    )


def _box(x: float, y: float, z: float, position: tuple[float, float, float], yaw: float = 0.0) -> Piece:
    turn = quaternion_from_rotation_vector(np.array([0.0, 0.0, yaw]))
    return Piece(pybullet.GEOM_BOX, Pose(np.array(position), turn), half=(0.5 * x, 0.5 * y, 0.5 * z))


def _vessel(shape: VesselShape) -> list[Piece]:
    """Walls whose outer faces touch the cylinder of the outer radius, and a floor; flat sides face x and y."""
    angle = 2.0 * math.pi / shape.sides
    middle = shape.radius - 0.5 * shape.wall
    length = 2.0 * shape.radius * math.tan(0.5 * angle)
    rotated = [np.array([math.cos(k * angle), math.sin(k * angle)]) * middle for k in range(shape.sides)]
    walls = [
        _box(shape.wall, length, shape.height, (float(x), float(y), 0.0), k * angle) for k, (x, y) in enumerate(rotated)
    ]
    below = Pose(np.array([0.0, 0.0, 0.5 * (shape.wall - shape.height)]))
    floor = Piece(pybullet.GEOM_CYLINDER, below, radius=shape.radius - 0.5 * shape.wall, length=shape.wall)
    return [*walls, floor]


def _tray(shape: TrayShape) -> list[Piece]:
    (x, y, z), wall = shape.size, shape.wall
    across, along = 0.5 * (x - wall), 0.5 * (y - wall)
    return [
        _box(x, y, wall, (0.0, 0.0, 0.5 * (wall - z))),
        _box(wall, y, z, (across, 0.0, 0.0)),
        _box(wall, y, z, (-across, 0.0, 0.0)),
        _box(x, wall, z, (0.0, along, 0.0)),
        _box(x, wall, z, (0.0, -along, 0.0)),
    ]


def _moved(piece: Piece, position: tuple[float, float, float]) -> Piece:
    pose = Pose(piece.pose.position + np.array(position), piece.pose.quaternion)
    return Piece(piece.kind, pose, piece.half, piece.radius, piece.length)


def turned_axis(pose: Pose, axis: Array) -> Array:
    """An axis (3,) of the world in the frame of a pose."""
    return rotate(pose.inverse().quaternion, axis)
