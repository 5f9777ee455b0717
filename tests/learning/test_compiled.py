"""The compiled parts of learning beside the same formulas on whole arrays."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.geometry import (
    Array,
    geodesic_distance,
    mean_quaternion,
    multiply,
    normalize_quaternion,
    quaternion_from_rotation_vector,
    relative_rotation_vector,
    rotate,
    rotation_matrix,
)
from pft_exec.learning.averaging import average
from pft_exec.learning.experts import local_covariance, product
from pft_exec.learning.resampling import nearest_at, places_of, quaternions_at, rows_at
from pft_exec.learning.smoothing import smoothed
from pft_exec.learning.stacking import OFF_DIAGONAL, ExpertErrors, blend_positions, blend_turns
from pft_exec.learning.turning import carry, compose, turn_between, turn_by

RNG = np.random.default_rng(0)


def _quaternions(*shape: int) -> Array:
    return normalize_quaternion(RNG.normal(size=(*shape, 4)))


def test_turns_are_those_of_the_geometry_and_broadcast_alike() -> None:
    one, other, vector = _quaternions(5, 1, 7), _quaternions(3, 7), RNG.normal(size=(5, 3, 7, 3))
    np.testing.assert_allclose(compose(one, other), multiply(one, other), atol=1e-15)
    np.testing.assert_allclose(turn_between(one, other), relative_rotation_vector(one, other), atol=1e-14)
    np.testing.assert_allclose(carry(other, vector), rotate(other, vector), atol=1e-14)
    expected = multiply(other, quaternion_from_rotation_vector(vector))
    np.testing.assert_allclose(turn_by(other, vector), expected, atol=1e-14)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-7, 1e-6, np.pi - 1e-9])
def test_the_smallest_and_the_largest_turns_come_back(angle: float) -> None:
    vector = angle * np.array([0.6, 0.0, -0.8])
    start = _quaternions()
    np.testing.assert_allclose(turn_between(start, turn_by(start, vector)), vector, rtol=1e-6, atol=1e-15)


def test_the_mean_of_rotations_is_the_intrinsic_one_whatever_their_signs_and_order() -> None:
    mean = _quaternions(20)
    turned = turn_by(mean, RNG.normal(scale=0.4, size=(6, 20, 3)))
    expected = mean_quaternion(turned)
    shuffled = (turned * RNG.choice([-1.0, 1.0], size=(6, 20, 1)))[::-1]
    assert geodesic_distance(average(turned), expected).max() < 1e-9
    assert geodesic_distance(average(shuffled), expected).max() < 1e-9


def test_the_weighted_mean_of_two_rotations_lies_on_the_way_between_them() -> None:
    pair, step = np.stack([_quaternions(9)] * 2), RNG.normal(scale=0.7, size=(9, 3))
    pair[1] = turn_by(pair[0], step)
    weights = np.broadcast_to(np.array([[0.7], [0.3]]), (2, 9))
    np.testing.assert_allclose(turn_between(pair[0], average(pair, weights)), 0.3 * step, atol=1e-9)


def test_averages_over_neighbours_are_products_with_gaussian_weights() -> None:
    values, steps = RNG.normal(size=(60, 2, 4)), np.arange(60)
    for width in (0.0, 0.4, 3.0, 30.0):
        weights = np.exp(-0.5 * ((steps[:, None] - steps) / max(width, 1e-9)) ** 2)
        weights /= weights.sum(axis=1, keepdims=True)
        np.testing.assert_allclose(smoothed(values, width), np.einsum("nm,mij->nij", weights, values), atol=1e-14)


def _stacked(errors: Array, floor: float) -> Array:
    """Weights (N, E) by whole matrices."""
    experts, count, steps, _ = errors.shape
    products = np.einsum("ekni,fkni->nef", errors, errors) / count
    believed = OFF_DIAGONAL * smoothed(products, 0.025 * steps)
    diagonal = np.arange(experts)
    believed[:, diagonal, diagonal] = believed[:, diagonal, diagonal] / OFF_DIAGONAL + floor**2
    raw = np.clip(np.linalg.solve(believed, np.ones((steps, experts, 1)))[..., 0], 0.0, None)
    return smoothed(raw / raw.sum(axis=1, keepdims=True), 0.025 * steps)


def test_weights_solve_the_problem_of_least_error_and_the_cross_fitted_leave_their_own_out() -> None:
    shared = RNG.normal(size=(1, 4, 50, 3))
    errors = np.array([0.2, 1.0, 0.5, 0.7])[:, None, None, None] * (RNG.normal(size=(4, 4, 50, 3)) + shared)
    stacked = ExpertErrors(errors, 0.1)
    np.testing.assert_allclose(stacked.weights(), _stacked(errors, 0.1), atol=1e-11)
    for k in range(4):
        without = _stacked(np.delete(errors, k, axis=1), 0.1)
        expected = np.einsum("ne,eni->ni", without, errors[:, k])
        np.testing.assert_allclose(stacked.cross_fitted[k], expected, atol=1e-11)


def test_some_of_the_experts_weigh_as_if_the_others_had_never_been() -> None:
    errors = RNG.normal(size=(5, 3, 40, 3))
    whole, alone = ExpertErrors(errors, 0.1).of([0, 2, 3]), ExpertErrors(errors[[0, 2, 3]], 0.1)
    np.testing.assert_allclose(whole.weights(), alone.weights(), atol=1e-12)
    assert whole.cross_fitted_square() == pytest.approx(alone.cross_fitted_square(), rel=1e-12)


def test_the_blend_is_the_weighted_sum_and_of_turns_their_mean() -> None:
    weights = RNG.dirichlet([1.0, 1.0, 1.0], size=30)
    places = RNG.normal(size=(3, 2, 30, 3))
    np.testing.assert_allclose(blend_positions(weights, places), np.einsum("ne,emni->mni", weights, places))
    turns = turn_by(_quaternions(2, 30), RNG.normal(scale=0.05, size=(3, 2, 30, 3)))
    expected = average(turns, np.broadcast_to(weights.T[:, None], (3, 2, 30)))
    assert geodesic_distance(blend_turns(weights, turns), expected).max() < 1e-5


def test_the_product_of_gaussians_weighs_each_frame_by_its_precision_in_its_own_axes() -> None:
    local = RNG.normal(size=(2, 6, 10, 3)) * np.array([0.1, 1.0, 3.0])
    keys, pose = (("cup", "object"), ("absolute", "world")), np.concatenate([np.zeros((6, 3)), _quaternions(6)], axis=1)
    world = RNG.normal(size=(2, 6, 10, 3))
    turn = np.stack([rotation_matrix(pose[:, 3:]), np.broadcast_to(np.eye(3), (6, 3, 3))])[:, :, None]
    for leave_out in (True, False):
        covariance = local_covariance(local, 0.01, leave_out)
        precision = np.linalg.inv(turn @ covariance @ turn.swapaxes(-1, -2))
        weighted = np.einsum("fmnij,fmnj->mni", precision, world)
        expected = np.linalg.solve(precision.sum(axis=0), weighted[..., None])[..., 0]
        np.testing.assert_allclose(product(world, covariance, keys, {"cup": pose}), expected, atol=1e-10)


def test_leaving_out_gives_the_covariance_of_the_others() -> None:
    local = RNG.normal(size=(2, 5, 12, 3))
    found = local_covariance(local, 0.01, leave_out=True)
    for k in range(5):
        np.testing.assert_allclose(
            found[:, k], local_covariance(np.delete(local, k, axis=1), 0.01, leave_out=False)[:, 0], atol=1e-12
        )


def test_a_recording_is_read_between_its_samples_at_them_and_beyond_its_ends() -> None:
    time = np.cumsum(RNG.uniform(0.01, 0.2, 30))
    wanted = np.sort(np.concatenate([RNG.uniform(time[0], time[-1], 50), time[[0, 7, -1]], [time[-1] + 1.0]]))
    values, turns = RNG.normal(size=(30, 3)), _quaternions(30)
    places = places_of(time, wanted)
    expected = np.stack([np.interp(wanted, time, column) for column in values.T], axis=1)
    np.testing.assert_allclose(rows_at(values, places), expected, atol=1e-12)
    np.testing.assert_allclose(rows_at(values[:, 0], places), expected[:, 0], atol=1e-12)
    np.testing.assert_allclose(rows_at(values, places_of(time, wanted[::-1])), expected[::-1], atol=1e-12)
    at = np.searchsorted(wanted, time[7])
    assert geodesic_distance(quaternions_at(turns, places)[at], turns[7]) < 1e-9
    nearest = np.abs(time[:, None] - wanted).argmin(axis=0)
    np.testing.assert_array_equal(nearest_at(np.arange(30), places), nearest)
