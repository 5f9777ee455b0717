"""Poses: what they refuse, and that they form a group."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.exceptions import InvalidSceneError
from pft_exec.geometry import Pose, normalize_quaternion, read_only


def pose(seed: int) -> Pose:
    generator = np.random.default_rng(seed)
    return Pose(generator.normal(size=3), normalize_quaternion(generator.normal(size=4)))


def matrix(item: Pose) -> np.ndarray:
    full = np.eye(4)
    full[:3, :3], full[:3, 3] = item.rotation, item.position
    return full


def test_composition_and_inverse_are_those_of_matrices() -> None:
    a, b = pose(1), pose(2)
    np.testing.assert_allclose(matrix(a @ b), matrix(a) @ matrix(b), atol=1e-14)
    np.testing.assert_allclose(matrix(a.inverse()), np.linalg.inv(matrix(a)), atol=1e-14)
    points = np.random.default_rng(3).normal(size=(5, 3))
    np.testing.assert_allclose((a @ b).apply(points), a.apply(b.apply(points)), atol=1e-13)


def test_arrays_and_matrices_give_the_pose_back() -> None:
    a = pose(4)
    assert Pose.from_array(a.array) == a
    np.testing.assert_allclose(matrix(Pose.from_matrix(matrix(a))), matrix(a), atol=1e-14)


def test_equal_poses_have_equal_hashes() -> None:
    assert len({pose(5), pose(5), pose(6)}) == 2
    assert pose(5) != pose(6)
    assert pose(5) != "pose"


def test_the_default_orientation_is_the_identity() -> None:
    np.testing.assert_array_equal(Pose([1.0, 2.0, 3.0]).rotation, np.eye(3))


@pytest.mark.parametrize(
    ("position", "quaternion", "message"),
    [
        ([0.0, 0.0], [0.0, 0.0, 0.0, 1.0], r"position \(3,\).*got shapes \(2,\) and \(4,\)"),
        ([0.0, 0.0, np.nan], [0.0, 0.0, 0.0, 1.0], "must be finite"),
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.1], "length 1 within 1e-3.*has 1.1. Normalize it first"),
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], "length 1"),
    ],
)
def test_refuses_what_is_no_pose(position: list[float], quaternion: list[float], message: str) -> None:
    with pytest.raises(InvalidSceneError, match=message):
        Pose(position, quaternion)


def test_nearly_unit_quaternions_are_normalized() -> None:
    assert np.linalg.norm(Pose(np.zeros(3), [0.0, 0.0, 0.0, 1.0009]).quaternion) == 1.0


def test_cannot_be_written_to() -> None:
    with pytest.raises(ValueError, match="read-only"):
        pose(7).position[0] = 1.0
    values = np.zeros(3)
    kept = read_only(values)
    values[0] = 1.0
    assert kept[0] == 0.0


@pytest.mark.parametrize("position", ["here", [1.0, "two", 3.0]])
def test_refuses_what_is_no_number(position: object) -> None:
    with pytest.raises(InvalidSceneError, match="numbers"):
        Pose(position)
