"""The compiled steps of error, target and tracking cost say what the formulas in plain numpy say."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control import JointReference, constant_compliance, tool_objective
from pft_exec.control.compliance import Compliance
from pft_exec.control.tool_kernel import between, matrix_of, rotation_vector
from pft_exec.control.tool_target import tool_target
from pft_exec.geometry import (
    normalize_quaternion,
    quaternion_from_rotation_vector,
    relative_rotation_vector,
    rotation_matrix,
)


@pytest.fixture
def generator():
    return np.random.default_rng(11)


def test_a_quaternion_gives_its_rotation_matrix(generator):
    for quaternion in normalize_quaternion(generator.normal(size=(50, 4))):
        np.testing.assert_allclose(matrix_of(quaternion), rotation_matrix(quaternion), atol=1e-14)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-6, 1e-3, 1.0, 3.1, 4.0])
def test_the_rotation_vector_is_the_shortest_at_any_angle_and_sign(generator, angle):
    for reference in normalize_quaternion(generator.normal(size=(20, 4))):
        axis = normalize_quaternion(generator.normal(size=3))
        turned = relative_rotation_vector(quaternion_from_rotation_vector(-angle * axis), reference)
        other = quaternion_from_rotation_vector(turned)
        for sign in (1.0, -1.0):
            found = rotation_vector(reference, sign * other)
            np.testing.assert_allclose(found, relative_rotation_vector(reference, other), rtol=1e-9, atol=1e-14)


def test_the_cost_is_that_of_missing_what_gain_and_weight_at_the_phase_ask_for(arm, start, generator):
    reference = JointReference(start, *generator.normal(size=(2, 7)))
    target, measured = tool_target(arm, reference), arm.dynamics(start + 0.1, generator.normal(size=7))
    flat = constant_compliance(200.0)
    root = generator.normal(size=(2, 6, 6))
    compliance = Compliance(
        flat.time, flat.gain + generator.normal(size=(2, 6, 12)), root @ root.transpose(0, 2, 1), flat.deviation
    )
    error, turn = target.error(measured), np.eye(6)
    turn[3:, 3:] = target.rotation
    for phase in (-1.0, 0.3, 2.0):
        gain, weight = compliance.at(phase)
        wanted = target.acceleration - turn @ (gain @ error)
        expected = tool_objective(measured.jacobian, measured.jacobian_drift, wanted, turn @ weight @ turn.T)
        found = target.objective(compliance, phase, error, measured)
        np.testing.assert_allclose(found.H, expected.H, rtol=1e-10, atol=1e-11)
        np.testing.assert_allclose(found.c, expected.c, rtol=1e-10, atol=1e-9)
        assert found.constant == pytest.approx(expected.constant, rel=1e-10)
        np.testing.assert_allclose(between(compliance.gain, phase), gain, rtol=1e-14)


def test_a_tool_target_moves_with_the_jacobian_and_drift_of_its_reference(arm, start, generator):
    v, acceleration = generator.normal(size=(2, 7))
    dynamics, target = arm.dynamics(start, v), tool_target(arm, JointReference(start, v, acceleration))
    np.testing.assert_allclose(target.velocity, dynamics.velocity, atol=1e-13)
    expected = dynamics.jacobian @ acceleration + dynamics.jacobian_drift
    np.testing.assert_allclose(target.acceleration, expected, atol=1e-13)
