"""The compiled step of the observer and its running means say what the formulas in plain numpy say."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.handoff.felt import SMOOTHING_SPEED, feel, follow_means, follow_within

PERIOD, SHARE = 0.001, 0.2


@pytest.fixture
def generator():
    return np.random.default_rng(7)


def test_one_step_of_the_observer_is_its_formula(arm, start, generator):
    speed, v, residual, torque, passive, springs = generator.normal(size=(6, 7))
    begin, end = arm.dynamics(start, speed), arm.dynamics(start + 0.1, v)
    coulomb, viscous = np.abs(generator.normal(size=(2, 7)))
    felt = feel(
        residual,
        SHARE,
        (begin.mass_matrix, speed, passive),
        (end.mass_matrix, end.bias, end.jacobian, springs, v),
        (coulomb, viscous),
        torque,
        PERIOD,
    )
    outside = begin.mass_matrix @ (v - speed) / PERIOD - passive - torque
    after = residual + SHARE * (outside - residual)
    np.testing.assert_allclose(felt[0], after, rtol=1e-10)
    friction = coulomb * np.tanh(v / SMOOTHING_SPEED) + viscous * v
    np.testing.assert_allclose(felt[1], springs - end.bias - friction, rtol=1e-10, atol=1e-12)
    mobility = end.jacobian @ np.linalg.inv(end.mass_matrix)
    wrench = np.linalg.solve(mobility @ end.jacobian.T + 1e-9 * np.eye(6), mobility @ after)
    np.testing.assert_allclose(felt[2][0], wrench, rtol=1e-6)
    alone = np.linalg.solve(mobility @ end.jacobian.T + 1e-9 * np.eye(6), mobility @ outside)
    np.testing.assert_allclose(felt[2][1], alone, rtol=1e-6)


def test_means_follow_in_place_and_the_variance_is_about_the_new_mean(generator):
    mean, torque = generator.normal(size=(2, 7))
    mean_force, force = generator.normal(size=(2, 3))
    expected, expected_force = mean + SHARE * (torque - mean), mean_force + SHARE * (force - mean_force)
    variance = follow_means(mean, mean_force, 2.0, torque, force, SHARE)
    np.testing.assert_allclose(mean, expected)
    np.testing.assert_allclose(mean_force, expected_force)
    assert variance == pytest.approx(2.0 + SHARE * (np.sum((force - expected_force) ** 2) - 2.0))


def test_what_becomes_usual_is_the_mean_as_far_as_the_limit(generator):
    mean, force = generator.normal(size=(2, 3))
    np.testing.assert_allclose(follow_within(mean, force, SHARE, 100.0), mean + SHARE * (force - mean))
    np.testing.assert_allclose(follow_within(30.0 * mean, 30.0 * mean, 0.0, 1.0), mean / np.linalg.norm(mean))
