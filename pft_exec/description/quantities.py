"""Quantities that descriptions are made of: vectors, ranges, regions and fixed poses, checked when they are read."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.geometry import Array, Pose, multiply, quaternion_from_rotation_vector

Vector = tuple[float, float, float]
Range = tuple[float, float]


def quaternion_from_rpy(rpy: ArrayLike) -> Array:
    """Unit quaternion (4,), (x, y, z, w), of roll, pitch, yaw (3,), rad: Rz(yaw) Ry(pitch) Rx(roll), as in URDF."""
    roll, pitch, yaw = quaternion_from_rotation_vector(np.diag(np.asarray(rpy, dtype=float)))
    return multiply(yaw, multiply(pitch, roll))


def check_range(name: str, values: Range, unit: str) -> None:
    """Refuse a range whose greatest value stands first (``ValueError``, which the reader reports at its key)."""
    if values[0] > values[1]:
        raise ValueError(f"{name} must go from the least to the greatest value, in {unit}; got {list(values)}.")


def check_positive(name: str, *values: float) -> None:
    """Refuse quantities that are not above 0 (``ValueError``, which the reader reports at its key)."""
    if min(values) <= 0.0:
        raise ValueError(f"{name} must be above 0; got {', '.join(f'{value:g}' for value in values)}.")


@dataclass(frozen=True)
class FixedPose:
    """A pose in the world frame: position, m, and roll, pitch, yaw, rad (Rz(yaw) Ry(pitch) Rx(roll))."""

    position: Vector
    rpy: Vector = (0.0, 0.0, 0.0)

    @cached_property
    def pose(self) -> Pose:
        """The same as a `Pose`, world frame."""
        return Pose(np.array(self.position), quaternion_from_rpy(self.rpy))


@dataclass(frozen=True)
class Region:
    """An upright box of positions in the world frame: least and greatest x, y, z, m."""

    x: Range
    y: Range
    z: Range

    def __post_init__(self) -> None:
        for name in ("x", "y", "z"):
            check_range(name, getattr(self, name), "m")
