"""The covariance of a tube: positive definite, and as wide in a new scene as the way there is long."""

from __future__ import annotations

import numpy as np

from pft_exec.demonstration import Scene
from pft_exec.geometry import Array, Pose
from pft_exec.learning import FlowTube, learn_motion
from pft_exec.learning.covariance import GROWTH, carried_covariance, directions_of, find_spread, residual_covariance
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


def _hurried(way: np.ndarray, count: int, timing: float, across: float) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (K, 60, 3) along a straight way and across it, and its paths (K, 60, 3)."""
    path = np.broadcast_to(np.linspace(0.0, 0.5, 60)[:, None] * way, (count, 60, 3))
    noise = RNG.normal(scale=across, size=(count, 60, 3))
    return noise + RNG.normal(scale=timing, size=(count, 60, 1)) * way, path


def test_errors_of_timing_turn_with_the_way_of_the_scene() -> None:
    here, there = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.6, 0.8])
    residual, path = _hurried(here, 5, 0.03, 0.003)
    spread = find_spread(residual, path, 0.0005, 0.005)
    world = np.linalg.norm(spread.in_scene(path[0], residual, residual, 0.0005), axis=(1, 2))
    new = spread.in_scene(np.linspace(0.0, 0.5, 60)[:, None] * there, residual, residual, 0.0005)
    along, sideways = np.einsum("i,nij,j->n", there, new, there), new[:, 0, 0]
    assert np.median(along) > 0.4 * np.median(world)
    only_world = np.einsum("i,nij,j->n", there, spread.world, there)
    assert np.median(along) > 2.0 * np.median(only_world)
    assert np.median(sideways) < np.median(spread.world[:, 0, 0])
    assert np.linalg.eigvalsh(new).min() > 0.0


def test_many_errors_along_a_way_have_their_own_variances_along_and_across() -> None:
    way = np.array([0.0, 0.6, 0.8])
    residual, path = _hurried(way, 300, 0.03, 0.003)
    covariance = find_spread(residual, path, 1e-5, 0.005).in_scene(path[0], residual, residual, 1e-5)
    along = np.einsum("i,nij,j->n", way, covariance, way)
    np.testing.assert_allclose(along, 0.03**2 + 0.003**2, rtol=0.3)
    np.testing.assert_allclose(covariance[:, 0, 0], 0.003**2, rtol=0.9)


def test_a_path_that_stands_has_no_direction() -> None:
    assert np.all(directions_of(np.ones((2, 10, 3))) == 0.0)
