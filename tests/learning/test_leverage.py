"""What is not known of the weights: against the closed form, and a tube that says where it was never taught."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.geometry import Array
from pft_exec.learning import learn_motion
from pft_exec.learning.covariance import GROWTH
from pft_exec.learning.leverage import find_leverage
from tests.learning.taught import lesson, scaled

STEPS = 20


def _constant(values: Array) -> Array:
    """The same (..., 3) at each of the steps: (..., N, 3)."""
    return np.repeat(values[..., None, :], STEPS, axis=-2)


def test_two_experts_apart_along_one_axis_have_the_variance_of_a_regression_on_their_distance() -> None:
    shown, new, sigma = np.array([0.05, -0.08, 0.06, 0.02]), 0.3, 0.01
    said = np.zeros((2, 4, 3))
    said[1, :, 0] = shown
    residual = np.array([1.0, -1.0, 1.0, -1.0])[:, None] * [sigma, 0.0, 0.0]
    leverage = find_leverage(_constant(said), _constant(residual), 1e-9)
    apart = np.zeros((2, 3))
    apart[1, 0] = new
    beyond = leverage.beyond(_constant(apart))
    square = (
        0.5 * shown**2 / sigma**2
    )  # the basis of two weights that add up to 0 is (1, -1) / sqrt 2; the prior has 2 * 3
    left_out = [0.5 * own**2 / (6.0 + square.sum() - mine) for own, mine in zip(shown, square, strict=True)]
    expected = 0.5 * new**2 / (6.0 + square.sum()) - np.mean(left_out)
    np.testing.assert_allclose(beyond[:, 0, 0], expected, rtol=1e-6)
    np.testing.assert_allclose(beyond[:, 1:], 0.0, atol=1e-15)


def test_where_the_experts_are_no_farther_apart_than_shown_nothing_is_added() -> None:
    rng = np.random.default_rng(0)
    said = _constant(rng.normal(0.0, 0.1, (4, 5, 3)))
    leverage = find_leverage(said, _constant(rng.normal(0.0, 0.01, (5, 3))), 1e-4)
    assert np.all(leverage.beyond(0.2 * said[:, 0]) == 0.0)
    assert np.all(np.linalg.eigvalsh(leverage.beyond(20.0 * said[:, 0])) > -1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_a_tube_is_wide_where_an_object_stands_far_from_where_it_stood_in_the_demonstrations(seed: int) -> None:
    demonstrations = lesson("put_on_table", seed)
    motion = learn_motion(demonstrations)
    near = demonstrations[0]
    away = np.array([0.0, 0.6, *np.zeros(5)])
    far = replace(near, objects=dict(near.objects) | {"mat": near.objects["mat"] + away})
    widths = [np.trace(motion.flow_tube(d.scene, d.start).covariance[:, :3, :3], axis1=1, axis2=2) for d in (near, far)]
    assert widths[1][40:60].mean() > 1.5 * GROWTH[1] * widths[0][40:60].mean()
    assert widths[1][-1] < 1.2 * widths[0][-1]


def test_a_change_of_units_scales_what_is_added() -> None:
    demonstrations = lesson("put_on_table")
    new = replace(demonstrations[0], objects={"mat": demonstrations[0].objects["mat"] + np.array([0.4, *np.zeros(6)])})
    one = learn_motion(demonstrations).flow_tube(new.scene, new.start)
    larger = scaled(new, 1000.0)
    other = learn_motion([scaled(d, 1000.0) for d in demonstrations]).flow_tube(larger.scene, larger.start)
    np.testing.assert_allclose(other.covariance[:, :3, :3], 1e6 * one.covariance[:, :3, :3], rtol=1e-6, atol=1e-3)
