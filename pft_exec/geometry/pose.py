"""A pose: position and orientation of one frame in another; whoever holds it says in which."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.exceptions import InvalidSceneError
from pft_exec.geometry.mirror import mirror_poses
from pft_exec.geometry.rotation import (
    UNIT_TOLERANCE,
    Array,
    conjugate,
    multiply,
    quaternion_from_matrix,
    rotate,
    rotation_matrix,
)


def read_only(values: ArrayLike) -> Array:
    """A private float copy that cannot be written to."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class Pose:
    """Position and orientation of a frame, such as the tool's, in another, such as the world's.

    Parameters
    ----------
    position : (3,), m
    quaternion : (4,), (x, y, z, w)
        Unit length within 1e-3, then normalized.

    Raises
    ------
    InvalidSceneError
        If a shape is wrong, a number is none or not finite, or the quaternion is not unit.
    """

    position: Array
    quaternion: Array = field(default_factory=lambda: np.array([0.0, 0.0, 0.0, 1.0]))

    def __post_init__(self) -> None:
        try:
            position = np.asarray(self.position, dtype=float)
            quaternion = np.asarray(self.quaternion, dtype=float)
        except (TypeError, ValueError) as error:
            raise InvalidSceneError(
                f"a pose is made of numbers; got {self.position!r}, {self.quaternion!r}."
            ) from error
        if position.shape != (3,) or quaternion.shape != (4,):
            raise InvalidSceneError(
                f"a pose has a position (3,) and a quaternion (4,) (x, y, z, w); got shapes "
                f"{position.shape} and {quaternion.shape}."
            )
        if not all(map(math.isfinite, (*position.tolist(), *quaternion.tolist()))):
            raise InvalidSceneError(f"a pose must be finite; got {position} m and {quaternion}.")
        norm = math.sqrt(quaternion.dot(quaternion))
        if abs(norm - 1.0) > UNIT_TOLERANCE:
            raise InvalidSceneError(
                f"the quaternion (x, y, z, w) of a pose must have length 1 within 1e-3; "
                f"{quaternion} has {norm:.4g}. Normalize it first."
            )
        object.__setattr__(self, "position", read_only(position))
        object.__setattr__(self, "quaternion", read_only(quaternion / norm))

    @classmethod
    def from_array(cls, values: ArrayLike) -> Pose:
        """From (7,): position, m, and quaternion (x, y, z, w)."""
        values = np.asarray(values, dtype=float)
        return cls(values[:3], values[3:])

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> Pose:
        """From a homogeneous transform (4, 4)."""
        matrix = np.asarray(matrix, dtype=float)
        return cls(matrix[:3, 3], quaternion_from_matrix(matrix[:3, :3]))

    def __matmul__(self, other: Pose) -> Pose:
        """Compose: the pose of `other`, given in this frame, seen from where this pose is given."""
        return Pose(
            self.position + rotate(self.quaternion, other.position),
            multiply(self.quaternion, other.quaternion),
        )

    def inverse(self) -> Pose:
        """The pose of the outer frame seen from this one."""
        back = conjugate(self.quaternion)
        return Pose(-rotate(back, self.position), back)

    def apply(self, points: ArrayLike) -> Array:
        """Points (..., 3), m, given in this frame, in the outer one."""
        return rotate(self.quaternion, points) + self.position

    @property
    def rotation(self) -> Array:
        """Rotation matrix (3, 3)."""
        return rotation_matrix(self.quaternion)

    @property
    def array(self) -> Array:
        """(7,): position, m, and quaternion (x, y, z, w)."""
        return np.concatenate([self.position, self.quaternion])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Pose):
            return NotImplemented
        return bool(np.array_equal(self.array, other.array))

    def __hash__(self) -> int:
        return hash(self.array.tobytes())

    def mirrored(self, plane: Pose | None = None) -> Pose:
        """Mirror the pose in the xz plane of `plane` (identity where None)."""
        return Pose.from_array(mirror_poses(self.array, plane))
