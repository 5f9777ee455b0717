"""Capsules around the links of an arm, made from the primitive shapes of its URDF.

A capsule is the cheapest solid whose distance to others changes smoothly as it moves. Each link gets the one of least
volume that holds all of its shapes, with its axis along one of the principal or coordinate axes; two links that move
as one share a capsule where that is no larger than their two.
"""

from __future__ import annotations

from dataclasses import dataclass

import coal
import numpy as np
import pinocchio

from pft_exec.geometry import Array, read_only

_AROUND = 16  # points on a circle
_CENTERING = 60  # steps towards the farthest point


@dataclass(frozen=True, eq=False)
class LinkCapsule:
    """All that is within `radius` of a segment that moves with a joint of an arm.

    Parameters
    ----------
    name : str
        Of the link, or links, that it holds.
    joint : int
        Index of the arm's joint that moves it; -1 for the body that no joint of the arm moves.
    start, end : (3,), m
        Ends of the segment in the frame of that joint.
    radius : float, m
    """

    name: str
    joint: int
    start: Array
    end: Array
    radius: float

    @property
    def length(self) -> float:
        """Length of the segment, m."""
        return float(np.linalg.norm(self.end - self.start))

    @property
    def volume(self) -> float:
        """Volume, m^3."""
        return float(np.pi * self.radius**2 * (self.length + 4.0 / 3.0 * self.radius))


def link_capsules(links: dict[str, tuple[int, Array]]) -> tuple[LinkCapsule, ...]:
    """Capsules around links, those that move as one joined where that pays.

    Parameters
    ----------
    links : mapping of name to (joint, (N, 3))
        The joint that moves a link, and points whose hull holds the link, m, in the joint's frame.

    Returns
    -------
    tuple of LinkCapsule
        From the base to the tool.
    """
    capsules: list[LinkCapsule] = []
    for joint in sorted({joint for joint, _ in links.values()}):
        parts = {name: points for name, (moved_by, points) in links.items() if moved_by == joint}
        capsules += _joined(joint, parts)
    return tuple(capsules)


def _joined(joint: int, parts: dict[str, Array]) -> list[LinkCapsule]:
    """Capsules of links that move as one; each joins the one before it where theirs together is no larger."""
    done: list[tuple[Array, LinkCapsule]] = []
    for name, points in parts.items():
        capsule = enclosing_capsule(name, joint, points)
        if done:
            before, last = done[-1]
            both = np.concatenate([before, points])
            union = enclosing_capsule(f"{last.name} + {name}", joint, both)
            if union.volume <= last.volume + capsule.volume:
                done[-1] = (both, union)
                continue
        done.append((points, capsule))
    return [capsule for _, capsule in done]


def enclosing_capsule(name: str, joint: int, points: Array) -> LinkCapsule:
    """The smallest capsule, among those along the coordinate and principal axes, that holds points (N, 3), m."""
    spread = points - points.mean(axis=0)
    principal = np.linalg.svd(spread, full_matrices=False)[2]
    axes = np.concatenate([np.eye(3), principal])
    found = [_capsule_along(axis, points) for axis in axes]
    start, end, radius = min(
        found, key=lambda item: item[2] ** 2 * (np.linalg.norm(item[1] - item[0]) + 4 / 3 * item[2])
    )
    return LinkCapsule(name, joint, read_only(start), read_only(end), radius)


def _capsule_along(axis: Array, points: Array) -> tuple[Array, Array, float]:
    """Ends (3,), (3,) and radius of a capsule along a unit vector (3,) that holds points (N, 3), m."""
    axis = axis / np.linalg.norm(axis)
    along = points @ axis
    across = points - np.outer(along, axis)
    center = across.mean(axis=0)
    for step in range(1, _CENTERING + 1):  # Badoiu and Clarkson: converges on the centre of the smallest circle
        farthest = across[np.argmax(np.linalg.norm(across - center, axis=1))]
        center = center + (farthest - center) / (step + 1)
    distance = np.linalg.norm(across - center, axis=1)
    radius = float(distance.max())
    cap = np.sqrt(np.maximum(radius**2 - distance**2, 0.0))
    low, high = float(np.min(along + cap)), float(np.max(along - cap))
    if low > high:
        low = high = 0.5 * (low + high)
    return center + low * axis, center + high * axis, radius


def hull_points(shape: coal.CollisionGeometry, placement: pinocchio.SE3) -> Array:
    """Points (N, 3), m, whose hull holds a primitive of a URDF, in the frame that its placement is given in.

    A box has its corners, a cylinder two polygons around its rims, anything else the box along its own axes.
    """
    if isinstance(shape, coal.Box):
        points = _corners(-shape.halfSide, shape.halfSide)
    elif isinstance(shape, coal.Cylinder):
        angle = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
        rim = shape.radius / np.cos(np.pi / _AROUND) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        heights = np.repeat([-shape.halfLength, shape.halfLength], _AROUND)
        points = np.column_stack([np.tile(rim, (2, 1)), heights])
    else:
        shape.computeLocalAABB()
        points = _corners(shape.aabb_local.min_, shape.aabb_local.max_)
    turned: Array = points @ placement.rotation.T + placement.translation
    return turned


def _corners(low: Array, high: Array) -> Array:
    grid = np.stack(np.meshgrid(*zip(np.ravel(low), np.ravel(high), strict=True), indexing="ij"), axis=-1)
    corners: Array = grid.reshape(-1, 3)
    return corners
