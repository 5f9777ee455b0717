"""Mirroring: an involution, the published signs, and the same answer from reflection matrices."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.geometry import (
    Pose,
    geodesic_distance,
    mirror_covariance,
    mirror_poses,
    mirror_positions,
    mirror_quaternions,
    multiply,
    normalize_quaternion,
    quaternion_from_rotation_vector,
    relative_rotation_vector,
    rotation_matrix,
)

PLANES = [None, Pose([0.3, -0.5, 0.2], normalize_quaternion([0.2, -0.4, 0.1, 0.8]))]


def poses(count: int = 20) -> np.ndarray:
    generator = np.random.default_rng(1)
    return np.hstack([generator.normal(size=(count, 3)), normalize_quaternion(generator.normal(size=(count, 4)))])


def test_the_signs_are_the_published_ones() -> None:
    """[Dong2012]_, section 4.3: y, q_w and q_y change sign."""
    x, y, z, w = 0.1, 0.2, 0.3, np.sqrt(1.0 - 0.14)
    mirrored = mirror_poses([1.0, 2.0, 3.0, x, y, z, w])
    np.testing.assert_allclose(mirrored[:3], [1.0, -2.0, 3.0])
    assert geodesic_distance(mirrored[3:], [x, -y, z, -w]) < 1e-7


@pytest.mark.parametrize("plane", PLANES)
def test_twice_is_the_original(plane: Pose | None) -> None:
    original = poses()
    back = mirror_poses(mirror_poses(original, plane), plane)
    np.testing.assert_allclose(back[:, :3], original[:, :3], atol=1e-12)
    assert geodesic_distance(back[:, 3:], original[:, 3:]).max() < 1e-7


@pytest.mark.parametrize("plane", PLANES)
def test_equals_the_reflection_by_matrices(plane: Pose | None) -> None:
    original = poses()
    axes = np.eye(3) if plane is None else plane.rotation
    origin = np.zeros(3) if plane is None else plane.position
    reflection = axes @ np.diag([1.0, -1.0, 1.0]) @ axes.T
    np.testing.assert_allclose(
        mirror_positions(original[:, :3], plane), (original[:, :3] - origin) @ reflection.T + origin, atol=1e-12
    )
    turned = rotation_matrix(mirror_quaternions(original[:, 3:], plane))
    expected = reflection @ rotation_matrix(original[:, 3:]) @ np.diag([1.0, -1.0, 1.0])
    np.testing.assert_allclose(turned, expected, atol=1e-12)


@pytest.mark.parametrize("plane", PLANES)
def test_a_mirrored_cloud_has_the_mirrored_covariance(plane: Pose | None) -> None:
    generator = np.random.default_rng(2)
    mean = poses(1)[0]
    factor = 0.1 * generator.normal(size=(6, 6))
    errors = generator.normal(size=(4000, 6)) @ factor.T
    position = mean[:3] + errors[:, :3]
    quaternion = multiply(mean[3:], quaternion_from_rotation_vector(errors[:, 3:]))
    mirrored_mean = mirror_poses(mean, plane)
    mirrored_errors = np.hstack(
        [
            mirror_positions(position, plane) - mirrored_mean[:3],
            relative_rotation_vector(mirrored_mean[3:], mirror_quaternions(quaternion, plane)),
        ]
    )
    before = errors.T @ errors / len(errors)
    np.testing.assert_allclose(
        mirrored_errors.T @ mirrored_errors / len(errors), mirror_covariance(before, plane), atol=1e-12
    )


@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("size", [3, 6])
def test_a_covariance_mirrored_twice_is_the_original(plane: Pose | None, size: int) -> None:
    factor = np.random.default_rng(3).normal(size=(5, size, size))
    covariance = factor @ np.swapaxes(factor, 1, 2)
    mirrored = mirror_covariance(covariance, plane)
    np.testing.assert_allclose(mirrored, np.swapaxes(mirrored, 1, 2), atol=1e-12)
    np.testing.assert_allclose(mirror_covariance(mirrored, plane), covariance, atol=1e-12)


def test_a_pose_mirrors_like_its_array() -> None:
    item = Pose.from_array(poses(1)[0])
    np.testing.assert_allclose(item.mirrored(PLANES[1]).array, mirror_poses(item.array, PLANES[1]), atol=1e-15)
