"""The shape of an arm for collision avoidance: capsules around its links, the robot's body, and which to keep apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import coal
import numpy as np
import pinocchio

from pft_exec.geometry import Array, Pose, quaternion_from_matrix
from pft_exec.model.distance import coal_shape, nearest_points
from pft_exec.model.link_capsules import LinkCapsule, hull_points, link_capsules
from pft_exec.model.obstacle import Box, Capsule, Obstacle

KEPT_APART = 0.03
"""m; links that come closer than this in a named configuration are left out: their capsules are too fat."""
_JOINTS_BETWEEN = 3  # links fewer joints apart than this touch by construction


@dataclass(frozen=True, eq=False)
class ArmGeometry:
    """Shape of an arm.

    Parameters
    ----------
    links : tuple of LinkCapsule
        Base to tool. Fingers are where the model holds them: closed.
    body : tuple of Obstacle
        Boxes around the shapes that no joint moves, base frame.
    body_pairs : tuple of (int, int)
        Indices of a link and of a part of the body that can meet.
    link_pairs : tuple of (int, int)
        Indices of two links that can meet.
    """

    links: tuple[LinkCapsule, ...]
    body: tuple[Obstacle, ...]
    body_pairs: tuple[tuple[int, int], ...]
    link_pairs: tuple[tuple[int, int], ...]

    def obstacles(self, rotation: Array, translation: Array) -> tuple[Obstacle, ...]:
        """The links as obstacles to another arm, where this arm's joints have rotations (n, 3, 3), places (n, 3), m."""
        found = []
        for link in self.links:
            ends = np.stack([link.start, link.end])
            if link.joint >= 0:
                ends = ends @ rotation[link.joint].T + translation[link.joint]
            turn = axis_rotation(ends[1] - ends[0])
            pose = Pose(ends.mean(axis=0), quaternion_from_matrix(turn))
            found.append(Obstacle(link.name, Capsule(link.radius, max(link.length, 1e-6)), pose))
        return tuple(found)


def axis_rotation(direction: Array) -> Array:
    """A rotation matrix (3, 3) that turns z into a direction (3,); identity for a direction of no length."""
    length = np.linalg.norm(direction)
    if length < 1e-9:
        return np.eye(3)
    rotation: Array = pinocchio.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), direction / length).matrix()
    return rotation


def arm_geometry(
    urdf: Path, whole: pinocchio.Model, arm: pinocchio.Model, held: list[int], postures: Sequence[Array]
) -> ArmGeometry:
    """Shape of an arm from the collision shapes of a URDF.

    Parameters
    ----------
    urdf : Path
    whole, arm : pinocchio.Model
        The robot, and the arm's n joints alone.
    held : list of int
        Joints of `whole` that `arm` has not.
    postures : sequence of (n,), rad
        In which nothing touches.
    """
    shapes = pinocchio.buildGeomFromUrdf(whole, str(urdf), pinocchio.GeometryType.COLLISION)
    _, (reduced,) = pinocchio.buildReducedModel(whole, [shapes], held, pinocchio.neutral(whole))
    moved = set(whole.subtrees[whole.getJointId(arm.names[1])])
    points: dict[str, list[Array]] = {}
    joints: dict[str, int] = {}
    body = []
    for shape, original in zip(reduced.geometryObjects, shapes.geometryObjects, strict=True):
        if original.parentJoint in moved:
            name = whole.frames[original.parentFrame].name
            joints[name] = shape.parentJoint - 1
            points.setdefault(name, []).append(hull_points(shape.geometry, shape.placement))
        elif original.parentJoint == 0:
            body.append(_body_part(shape))
    links = link_capsules({name: (joints[name], np.concatenate(points[name])) for name in points})
    whole_shape = ArmGeometry(links, tuple(body), (), ())
    return _with_pairs(whole_shape, arm, postures)


def _body_part(shape: pinocchio.GeometryObject) -> Obstacle:
    """A shape of the body as the box around it, base frame."""
    shape.geometry.computeLocalAABB()
    low, high = shape.geometry.aabb_local.min_, shape.geometry.aabb_local.max_
    middle = shape.placement.act(0.5 * (low + high))
    pose = Pose(np.array(middle), quaternion_from_matrix(shape.placement.rotation))
    x, y, z = (float(length) for length in high - low)
    return Obstacle(shape.name, Box((x, y, z)), pose)


def _with_pairs(geometry: ArmGeometry, arm: pinocchio.Model, postures: Sequence[Array]) -> ArmGeometry:
    """Leave out what is adjacent, and what touches in postures where nothing should."""
    links, body = geometry.links, geometry.body
    joint = [link.joint for link in links]
    body_pairs = [(i, k) for i in range(len(links)) for k in range(len(body)) if joint[i] + 1 >= _JOINTS_BETWEEN]
    link_pairs = [(i, j) for i, j in combinations(range(len(links)), 2) if joint[j] - joint[i] >= _JOINTS_BETWEEN]
    close = [_close_pairs(geometry, arm, np.asarray(q), body_pairs, link_pairs) for q in postures]
    touches = np.any(close, axis=0) if close else np.zeros(len(body_pairs) + len(link_pairs), dtype=bool)
    kept = [pair for pair, touch in zip(body_pairs + link_pairs, touches, strict=True) if not touch]
    count = int((~touches[: len(body_pairs)]).sum())
    return ArmGeometry(links, body, tuple(kept[:count]), tuple(kept[count:]))


def _close_pairs(
    geometry: ArmGeometry,
    arm: pinocchio.Model,
    q: Array,
    body_pairs: Sequence[tuple[int, int]],
    link_pairs: Sequence[tuple[int, int]],
) -> Array:
    """Whether each of P pairs, body pairs first, is closer than `KEPT_APART` at a posture (n,): (P,), bool."""
    data = arm.createData()
    pinocchio.forwardKinematics(arm, data, q)
    joints = data.oMi.tolist()[1:]
    links = geometry.obstacles(
        np.array([place.rotation for place in joints]), np.array([place.translation for place in joints])
    )
    pairs = [(links[i], geometry.body[k]) for i, k in body_pairs] + [(links[i], links[j]) for i, j in link_pairs]
    return np.array([_distance(first, second) < KEPT_APART for first, second in pairs], dtype=bool)


def _distance(first: Obstacle, second: Obstacle) -> float:
    return nearest_points(coal_shape(first.solid), place(first.pose), coal_shape(second.solid), place(second.pose))[0]


def place(pose: Pose) -> coal.Transform3s:
    """A pose as coal knows it."""
    return coal.Transform3s(pose.rotation, np.array(pose.position))
