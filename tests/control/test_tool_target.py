"""The tool target: error and its rate in mixed axes, and turning gains and weights into base axes."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control import JointReference
from pft_exec.control.tool_target import tool_target
from pft_exec.geometry import relative_rotation_vector


@pytest.fixture
def target(arm, start):
    generator = np.random.default_rng(0)
    return tool_target(arm, JointReference(start, 0.3 * generator.normal(size=7), generator.normal(size=7)))


def test_no_error_on_the_reference_itself(arm, start):
    v = np.random.default_rng(1).normal(size=7)
    target = tool_target(arm, JointReference(start, v, np.zeros(7)))
    np.testing.assert_allclose(target.error(arm.dynamics(start, v)), 0.0, atol=1e-12)


def test_error_is_position_in_base_and_rotation_vector_in_tool_axes(arm, start, target):
    measured = arm.dynamics(start + 0.05, np.zeros(7))
    error = target.error(measured)
    np.testing.assert_allclose(error[:3], measured.position - target.position)
    turned = relative_rotation_vector(target.quaternion, measured.quaternion)
    np.testing.assert_allclose(error[3:6], turned, atol=1e-12)


def test_error_rate_is_the_derivative_of_the_error_near_zero(arm, start):
    still = tool_target(arm, JointReference(start, np.zeros(7), np.zeros(7)))
    v, step = np.random.default_rng(2).normal(size=7), 1e-6
    later, sooner = (still.error(arm.dynamics(start + sign * step * v, v)) for sign in (1.0, -1.0))
    np.testing.assert_allclose((later[:6] - sooner[:6]) / (2 * step), later[6:], atol=1e-4)


def test_acceleration_is_the_derivative_of_velocity_along_the_reference(arm, start):
    v, a, step = *np.random.default_rng(3).normal(size=(2, 7)), 1e-6
    state = lambda t: JointReference(start + t * v + 0.5 * t**2 * a, v + t * a, a)  # noqa: E731
    later, sooner = tool_target(arm, state(step)), tool_target(arm, state(-step))
    expected = tool_target(arm, state(0.0)).acceleration
    np.testing.assert_allclose((later.velocity - sooner.velocity) / (2 * step), expected, atol=1e-5)


def test_gain_and_weight_in_base_axes_agree_with_full_frame_changes(target):
    generator = np.random.default_rng(4)
    gain, error, root = generator.normal(size=(6, 12)), generator.normal(size=12), generator.normal(size=(6, 6))
    weight, turn = root @ root.T, np.eye(6)
    turn[3:, 3:] = target.rotation
    np.testing.assert_allclose(target.corrected(gain, error), target.acceleration - turn @ (gain @ error))
    np.testing.assert_allclose(target.weight_in_base(weight), turn @ weight @ turn.T, atol=1e-12)
