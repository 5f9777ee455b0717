"""Rotations: closed forms against scipy, round trips, invariances."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from pft_exec.geometry import (
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


def quaternions(count: int, seed: int = 0) -> np.ndarray:
    return normalize_quaternion(np.random.default_rng(seed).normal(size=(count, 4)))


def test_product_rotation_and_matrix_are_those_of_scipy() -> None:
    a, b = quaternions(50, 1), quaternions(50, 2)
    vectors = np.random.default_rng(3).normal(size=(50, 3))
    first, second = Rotation.from_quat(a), Rotation.from_quat(b)
    assert geodesic_distance(multiply(a, b), (first * second).as_quat()).max() < 1e-7
    np.testing.assert_allclose(rotate(a, vectors), first.apply(vectors), atol=1e-14)
    np.testing.assert_allclose(rotation_matrix(a), first.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(rotation_vector_from_quaternion(a), first.as_rotvec(), atol=1e-13)
    np.testing.assert_allclose(quaternion_from_matrix(first.as_matrix()), first.as_quat(canonical=True), atol=1e-14)


@settings(max_examples=200, deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3), st.floats(0.0, 1.0))
def test_logarithm_inverts_the_exponential_below_half_a_turn(direction: list[float], share: float) -> None:
    norm = np.linalg.norm(direction)
    vector = np.zeros(3) if norm < 1e-9 else np.array(direction) / norm * share * (np.pi - 1e-6)
    back = rotation_vector_from_quaternion(quaternion_from_rotation_vector(vector))
    np.testing.assert_allclose(back, vector, atol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-12, 1e-7, 9.9e-7, 1.01e-6, 1e-4])
def test_small_angles_lose_nothing(angle: float) -> None:
    vector = angle * np.array([0.6, 0.0, 0.8])
    quaternion = quaternion_from_rotation_vector(vector)
    np.testing.assert_allclose(quaternion[:3], 0.5 * vector, rtol=1e-8)
    np.testing.assert_allclose(rotation_vector_from_quaternion(quaternion), vector, rtol=1e-12)


def test_the_logarithm_does_not_depend_on_the_sign() -> None:
    a = quaternions(20, 4)
    np.testing.assert_allclose(
        rotation_vector_from_quaternion(a), rotation_vector_from_quaternion(-a), rtol=0, atol=1e-15
    )


def test_distance_is_the_angle_of_scipy_and_ignores_signs() -> None:
    a, b = quaternions(50, 5), quaternions(50, 6)
    expected = (Rotation.from_quat(a).inv() * Rotation.from_quat(b)).magnitude()
    np.testing.assert_allclose(geodesic_distance(a, b), expected, atol=1e-12)
    np.testing.assert_allclose(geodesic_distance(-a, b), expected, atol=1e-12)
    assert geodesic_distance(a, a).max() < 1e-7


def test_the_relative_vector_leads_from_one_to_the_other() -> None:
    a, b = quaternions(50, 7), quaternions(50, 8)
    reached = multiply(a, quaternion_from_rotation_vector(relative_rotation_vector(a, b)))
    assert geodesic_distance(reached, b).max() < 1e-7


def test_the_conjugate_is_the_inverse() -> None:
    a = quaternions(10, 9)
    np.testing.assert_allclose(multiply(a, conjugate(a)), np.tile([0.0, 0.0, 0.0, 1.0], (10, 1)), atol=1e-15)


def test_interpolation_is_that_of_scipy() -> None:
    a, b = quaternions(2, 10)
    ratios = np.linspace(0.0, 1.0, 11)
    expected = Slerp([0.0, 1.0], Rotation.from_quat([a, b]))(ratios).as_quat()
    assert geodesic_distance(interpolate_quaternion(a, b, ratios), expected).max() < 1e-7


def test_neighbours_lie_in_one_half_space() -> None:
    angles = np.linspace(0.0, 4.0 * np.pi, 200)
    smooth = quaternion_from_rotation_vector(np.outer(angles, [0.0, 0.6, 0.8]))
    signs = np.random.default_rng(11).choice([-1.0, 1.0], 200)
    signs[0] = 1.0
    mended = sign_continuous(smooth * signs[:, None])
    np.testing.assert_allclose(mended, sign_continuous(smooth), atol=1e-15)
    assert (np.sum(mended[1:] * mended[:-1], axis=1) > 0.0).all()
    np.testing.assert_array_equal(sign_continuous(smooth[:1]), smooth[:1])


def test_the_mean_recovers_the_center_of_a_symmetric_cloud() -> None:
    center = quaternions(1, 12)[0]
    steps = 0.4 * np.random.default_rng(13).normal(size=(10, 3))
    cloud = multiply(center, quaternion_from_rotation_vector(np.concatenate([steps, -steps])))
    assert geodesic_distance(mean_quaternion(cloud), center) < 1e-7


def test_the_mean_is_intrinsic() -> None:
    """At the Karcher mean the tangent vectors to the samples sum to zero."""
    center = quaternions(1, 14)[0]
    cloud = multiply(center, quaternion_from_rotation_vector(0.5 * np.random.default_rng(15).normal(size=(7, 3))))
    mean = mean_quaternion(cloud)
    np.testing.assert_allclose(relative_rotation_vector(mean, cloud).sum(axis=0), 0.0, atol=1e-11)


def test_the_mean_ignores_signs_order_and_turns_with_its_samples() -> None:
    generator = np.random.default_rng(16)
    center, turn = quaternions(2, 17)
    cloud = multiply(center, quaternion_from_rotation_vector(0.3 * generator.normal(size=(6, 3))))
    mean = mean_quaternion(cloud)
    assert geodesic_distance(mean_quaternion(cloud * generator.choice([-1.0, 1.0], (6, 1))), mean) < 1e-7
    assert geodesic_distance(mean_quaternion(cloud[::-1]), mean) < 1e-7
    assert geodesic_distance(mean_quaternion(multiply(turn, cloud)), multiply(turn, mean)) < 1e-7


def test_weights_and_batches_of_the_mean() -> None:
    a, b = np.array([0.0, 0.0, 0.0, 1.0]), quaternion_from_rotation_vector([0.0, 0.0, 1.0])
    weighted = mean_quaternion([a, b], weights=[3.0, 1.0])
    np.testing.assert_allclose(rotation_vector_from_quaternion(weighted), [0.0, 0.0, 0.25], atol=1e-12)
    batch = np.stack([np.stack([a, b]), np.stack([b, b])], axis=1)
    means = mean_quaternion(batch, axis=0)
    np.testing.assert_allclose(rotation_vector_from_quaternion(means)[:, 2], [0.5, 1.0], atol=1e-12)
    np.testing.assert_allclose(mean_quaternion(np.swapaxes(batch, 0, 1), axis=1), means, atol=1e-12)


def test_the_shortest_rotation_takes_one_direction_to_the_other_without_detour() -> None:
    generator = np.random.default_rng(18)
    a, b = generator.normal(size=(2, 50, 3))
    turn = shortest_rotation(a, b)
    unit_a, unit_b = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (a, b))
    np.testing.assert_allclose(rotate(turn, unit_a), unit_b, atol=1e-12)
    angle = np.arccos(np.clip(np.sum(unit_a * unit_b, axis=1), -1.0, 1.0))
    np.testing.assert_allclose(geodesic_distance(turn, [0.0, 0.0, 0.0, 1.0]), angle, atol=1e-7)


@pytest.mark.parametrize("direction", [[1.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 3.0], [0.6, 0.0, 0.8]])
def test_opposite_directions_are_turned_half_way_round(direction: list[float]) -> None:
    turn = shortest_rotation(direction, -np.array(direction))
    np.testing.assert_allclose(rotate(turn, direction), -np.array(direction), atol=1e-12)
    if direction[2] == 0.0:
        np.testing.assert_allclose(np.abs(turn), [0.0, 0.0, 1.0, 0.0], atol=1e-12)
