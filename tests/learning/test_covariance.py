"""The covariance of a tube: positive definite, and as wide in a new scene as the way there is long."""

from __future__ import annotations

import numpy as np

from pft_exec.demonstration import Scene
from pft_exec.geometry import Array, Pose
from pft_exec.learning import FlowTube, learn_motion
from pft_exec.learning.covariance import GROWTH, carried_covariance, residual_covariance
from tests.learning.taught import lesson

RNG = np.random.default_rng(0)


def _covariance(residual: Array) -> Array:
    return residual_covariance(residual, 0.001, 0.005)


def test_a_scene_like_the_demonstrated_ones_keeps_the_covariance() -> None:
    residual = RNG.normal(scale=0.01, size=(5, 60, 6))
    covariance = _covariance(residual)
    same = carried_covariance(covariance, residual[..., :3], residual[..., :3], 0.001)
    np.testing.assert_allclose(same, covariance, rtol=1e-12)


def test_the_variance_of_positions_goes_with_that_of_the_residuals_within_bounds_and_that_of_turns_stays() -> None:
    residual = RNG.normal(scale=0.01, size=(5, 60, 6))
    covariance = _covariance(residual)
    for factor, expected in ((1.2, 1.2**2), (0.8, 0.8**2), (10.0, GROWTH[1]), (0.1, GROWTH[0])):
        carried = carried_covariance(covariance, residual[..., :3], factor * residual[..., :3], 0.0)
        np.testing.assert_allclose(carried[:, :3, :3], expected * covariance[:, :3, :3])
        np.testing.assert_allclose(carried[:, 3:, 3:], covariance[:, 3:, 3:])
        assert np.linalg.eigvalsh(carried).min() > 0.0


def test_identical_demonstrations_leave_a_covariance_that_can_be_carried() -> None:
    nothing = np.zeros((2, 30, 3))
    carried = carried_covariance(_covariance(nothing), nothing, nothing, 0.001)
    assert np.linalg.eigvalsh(carried).min() > 0.0


def _tube_of_a_way(length: float) -> FlowTube:
    """ "put_on_table" with its mat that far from the tool."""
    demonstrations = lesson("put_on_table")
    first = demonstrations[0]
    mat = first.scene["mat"]
    begin = first.start.position
    place = np.array([begin[0] + length, begin[1], mat.position[2]])
    scene = Scene(dict(first.scene.objects) | {"mat": Pose(place, mat.quaternion)})
    return learn_motion(demonstrations).flow_tube(scene, first.start)


def test_a_tube_is_wider_between_its_ends_on_a_longer_way_and_as_wide_at_its_end() -> None:
    near, far = (np.trace(_tube_of_a_way(d).covariance[:, :3, :3], axis1=1, axis2=2) for d in (0.1, 0.6))
    assert far[50] > 1.2 * near[50]
    assert far[-1] < 1.2 * near[-1]
