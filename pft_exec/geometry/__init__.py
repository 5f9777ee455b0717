"""Poses, rotations and mirroring as whole-array functions; everything else stands on it."""

from pft_exec.geometry.mirror import (
    mirror_covariance,
    mirror_poses,
    mirror_positions,
    mirror_quaternions,
)
from pft_exec.geometry.pose import Pose, read_only
from pft_exec.geometry.rotation import (
    Array,
    conjugate,
    geodesic_distance,
    interpolate_quaternion,
    mean_quaternion,
    multiply,
    normalize_quaternion,
    quaternion_from_matrix,
    quaternion_from_rotation_vector,
    relative_rotation_vector,
    rotate,
    rotation_matrix,
    rotation_vector_from_quaternion,
    shortest_rotation,
    sign_continuous,
)

__all__ = [
    "Array",
    "Pose",
    "conjugate",
    "geodesic_distance",
    "interpolate_quaternion",
    "mean_quaternion",
    "mirror_covariance",
    "mirror_poses",
    "mirror_positions",
    "mirror_quaternions",
    "multiply",
    "normalize_quaternion",
    "quaternion_from_matrix",
    "quaternion_from_rotation_vector",
    "read_only",
    "relative_rotation_vector",
    "rotate",
    "rotation_matrix",
    "rotation_vector_from_quaternion",
    "shortest_rotation",
    "sign_continuous",
]
