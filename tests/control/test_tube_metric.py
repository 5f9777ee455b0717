"""The metric of a tube: Mahalanobis distance with a floor, and how it changes with the joints."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control import JointReference, TubeMetric
from pft_exec.control.compliance import FLOOR
from pft_exec.control.tool_target import tool_target
from pft_exec.learning import FlowTube


@pytest.fixture
def tube(arm, start):
    generator = np.random.default_rng(0)
    tool = arm.forward(start)
    roots = np.diag([0.01, 0.03, 0.02, 0.05, 0.1, 0.08]) @ (np.eye(6) + 0.3 * generator.normal(size=(2, 6, 6)))
    places, turns = np.tile(tool.position, (2, 1)), np.tile(tool.quaternion, (2, 1))
    return FlowTube("test", np.array([0.0, 1.0]), places, turns, roots @ roots.swapaxes(1, 2))


def test_the_deviation_is_as_long_as_the_distance_of_the_controllers_error(arm, start, tube):
    metric, zero = TubeMetric(tube), np.zeros(7)
    for phase, seed in ((0.0, 1), (1.0, 2)):
        reference = JointReference(start, zero, zero, phase)
        q = start + np.random.default_rng(seed).normal(0.0, 0.05, 7)
        error = tool_target(arm, reference).error(arm.dynamics(q, zero))[:6]
        covariance = tube.covariance[round(phase)] + np.diag(np.repeat(np.square(FLOOR), 3))
        expected = np.sqrt(error @ np.linalg.solve(covariance, error))
        assert metric.distance(phase, error) == pytest.approx(expected)
        assert np.linalg.norm(metric.deviation(arm, reference, q)[0]) == pytest.approx(expected)


def test_the_derivative_of_the_deviation_is_that_of_small_errors(arm, start, tube):
    metric, zero = TubeMetric(tube), np.zeros(7)
    reference = JointReference(start, zero, zero, 1.0)
    derivative = metric.deviation(arm, reference, start)[1]
    for joint, step in enumerate(1e-6 * np.eye(7)):
        change = metric.deviation(arm, reference, start + step)[0] - metric.deviation(arm, reference, start - step)[0]
        np.testing.assert_allclose(derivative[:, joint], change / 2e-6, rtol=1e-5, atol=1e-5)


def test_a_tube_without_orientation_leaves_the_wrist_as_much_as_is_said(arm, start, tube):
    plain = FlowTube("test", tube.time, tube.position, None, tube.covariance[:, :3, :3])
    error = np.array([0.0, 0.0, 0.0, 0.0, 0.3, 0.0])
    assert TubeMetric(plain, (0.0, 0.0), 0.1).distance(0.5, error) == pytest.approx(3.0)
