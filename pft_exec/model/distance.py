"""Distances between solids, by coal, the collision library that comes with pinocchio."""

from __future__ import annotations

import coal

from pft_exec.geometry import Array
from pft_exec.model.obstacle import Box, Capsule, Cylinder, Solid, Sphere

_REQUEST = coal.DistanceRequest()
_RESULT = coal.DistanceResult()
"""Used again each time, which halves the cost; its normal is a view."""


def coal_shape(solid: Solid) -> coal.ShapeBase:
    """A solid as coal knows it."""
    match solid:
        case Sphere(radius):
            return coal.Sphere(radius)
        case Capsule(radius, length):
            return coal.Capsule(radius, length)
        case Box(size):
            return coal.Box(*size)
        case Cylinder(radius, height):
            return coal.Cylinder(radius, height)


def nearest_points(
    first: coal.ShapeBase, first_place: coal.Transform3s, second: coal.ShapeBase, second_place: coal.Transform3s
) -> tuple[float, Array, Array]:
    """Distance between two shapes, m, and where it is.

    Returns
    -------
    distance : float, m
        Negative where they penetrate.
    point : (3,), m
        Of the first one's surface, nearest to the second, in the frame of the places.
    normal : (3,)
        Unit vector from the first towards the second; a distance from the point along it is the other nearest point.
    """
    _RESULT.clear()
    distance = coal.distance(first, first_place, second, second_place, _REQUEST, _RESULT)
    return distance, _RESULT.getNearestPoint1(), _RESULT.normal.copy()
