"""The compiled steps of a control period say what objectives, limits and `assemble` say one by one."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control import acceleration_bounds, assemble, posture_objective, tool_objective
from pft_exec.control.limits import torque_constraint
from pft_exec.control.period_kernel import compose, conclude, draw_to

WEIGHT, PERIOD = 1e-5, 0.001


@pytest.fixture
def generator():
    return np.random.default_rng(11)


@pytest.fixture
def period(arm, start, generator):
    """State, dynamics, load, tracking objective and posture of one control period."""
    q, v = start + 0.2 * generator.normal(size=7), generator.normal(size=7)
    dynamics, root = arm.dynamics(q, v), generator.normal(size=(6, 6))
    wanted = generator.normal(size=6)
    tracking = tool_objective(dynamics.jacobian, dynamics.jacobian_drift, wanted, root @ root.T)
    return q, v, dynamics, dynamics.bias + generator.normal(size=7), tracking, generator.normal(size=7)


def test_the_program_is_that_of_its_objectives_and_limits(arm, period):
    q, v, dynamics, load, tracking, posture = period
    limits = arm.limits
    expected = assemble(
        tracking + posture_objective(posture, WEIGHT),
        acceleration_bounds(limits, PERIOD, q, v),
        [torque_constraint(dynamics.mass_matrix, load, limits.torque)],
    )
    box = np.stack([limits.torque, limits.lower, limits.upper, limits.velocity, limits.acceleration])
    H, c, lower, upper = compose((tracking.H, tracking.c), posture, WEIGHT, load, box, PERIOD, q, v)
    np.testing.assert_allclose(H, expected.H, rtol=1e-13)
    np.testing.assert_allclose(c, expected.c, rtol=1e-13)
    np.testing.assert_array_equal(lower, expected.lower)
    np.testing.assert_array_equal(upper, expected.upper)


def test_a_solution_costs_what_its_objectives_say_and_its_torque_is_inverse_dynamics_within_the_limits(arm, period):
    _, _, dynamics, load, tracking, posture = period
    x, multipliers = np.linspace(-1.0, 1.0, 7), np.linspace(-1.0, 1.0, 14)
    multipliers[3], multipliers[9] = 0.0, 1e-12
    aims = tracking.H, tracking.c
    wanted = dynamics.mass_matrix @ x + load
    limit = np.full(7, np.median(np.abs(wanted)))
    told = conclude(x, multipliers, aims, posture, WEIGHT, dynamics.mass_matrix, load, limit, 1e-9)
    torque, active, following, keeping = told
    np.testing.assert_allclose(torque, np.clip(wanted, -limit, limit), rtol=1e-12)
    np.testing.assert_array_equal(np.flatnonzero(~active), [3, 9])
    assert following + tracking.constant == pytest.approx(tracking.cost(x), rel=1e-10)
    assert keeping == pytest.approx(posture_objective(posture, WEIGHT).cost(x), rel=1e-9)


def test_a_posture_is_drawn_to_its_reference_critically_damped(generator):
    configuration, velocity, acceleration, q, v, aside = generator.normal(size=(6, 7))
    expected = acceleration + 25.0 * (configuration - q) + 10.0 * (velocity - v) + aside
    np.testing.assert_allclose(draw_to(configuration, velocity, acceleration, q, v, aside, 25.0), expected, rtol=1e-12)
