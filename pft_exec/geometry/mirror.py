r"""Mirroring in the xz plane of a frame: what the left arm does when the right arm was taught.

In the axes of the plane's frame a position goes to :math:`(x, -y, z)` and a quaternion to :math:`(x, -y, z, -w)`
up to the common sign [Dong2012]_, section 4.3: the mirrored orientation is :math:`M R M`, :math:`M = diag(1, -1, 1)`.
A rotation vector in the tool frame is axial: it goes to :math:`(-x, y, -z)`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.geometry.rotation import Array, conjugate, multiply, rotate, rotation_matrix

if TYPE_CHECKING:
    from pft_exec.geometry.pose import Pose

_POLAR = np.array([1.0, -1.0, 1.0])
_AXIAL = np.array([-1.0, 1.0, -1.0])


def mirror_positions(positions: ArrayLike, plane: Pose | None = None) -> Array:
    """Positions (..., 3), m, mirrored in the xz plane of `plane`."""
    positions = np.asarray(positions, dtype=float)
    if plane is None:
        mirrored: Array = positions * _POLAR
        return mirrored
    local = rotate(conjugate(plane.quaternion), positions - plane.position)
    return plane.apply(local * _POLAR)


def mirror_quaternions(quaternions: ArrayLike, plane: Pose | None = None) -> Array:
    """Unit quaternions (..., 4) (x, y, z, w) mirrored in the xz plane of `plane`."""
    change = np.append(_AXIAL, 1.0)
    if plane is None:
        mirrored: Array = np.asarray(quaternions, dtype=float) * change
        return mirrored
    return multiply(plane.quaternion, multiply(conjugate(plane.quaternion), quaternions) * change)


def mirror_poses(poses: ArrayLike, plane: Pose | None = None) -> Array:
    """Poses (..., 7): position, m, and quaternion (x, y, z, w), mirrored in the xz plane of `plane`."""
    poses = np.asarray(poses, dtype=float)
    position = mirror_positions(poses[..., :3], plane)
    return np.concatenate([position, mirror_quaternions(poses[..., 3:], plane)], axis=-1)


def mirror_covariance(covariance: ArrayLike, plane: Pose | None = None) -> Array:
    """Covariance (..., 3, 3) of position, or (..., 6, 6) of position and rotation vector in the tool frame."""
    covariance = np.asarray(covariance, dtype=float)
    size = covariance.shape[-1]
    axes = np.eye(3) if plane is None else rotation_matrix(plane.quaternion)
    change = np.eye(size)
    change[:3, :3] = axes @ np.diag(_POLAR) @ axes.T
    if size == 6:
        change[3:, 3:] = np.diag(_AXIAL)
    mirrored: Array = change @ covariance @ change.T
    return mirrored
