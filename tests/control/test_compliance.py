"""Gains from a tube: against algebraic solutions, a batch solution, and what a user expects of stiffness."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from pft_exec.control import compute_compliance, constant_compliance, operational_stiffness
from pft_exec.control.compliance import FLOOR, LEVER, STIFFNESS_RANGE, double_integrator, riccati_step
from pft_exec.exceptions import ControlError
from pft_exec.learning.flow_tube import FlowTube

ANGLE = LEVER  # m of arc per rad


def make_tube(deviation, duration=2.0):
    """A straight tube of which each step has the deviations (N, 6), m and rad, or (N, 3)."""
    deviation = np.asarray(deviation, dtype=float)
    steps, size = deviation.shape
    position = np.linspace([0.0, 0.0, 0.0], [0.2, 0.0, 0.0], steps)
    quaternion = None if size == 3 else np.tile([0.0, 0.0, 0.0, 1.0], (steps, 1))
    covariance = deviation[:, :, None] ** 2 * np.eye(size)
    return FlowTube("line", np.linspace(0.0, duration, steps), position, quaternion, covariance)


def test_constant_tube_has_the_infinite_horizon_gain_everywhere():
    softness, sigma = 0.1, 0.01
    compliance = compute_compliance(make_tube(np.full((20, 6), [sigma] * 3 + [sigma / LEVER] * 3)), softness)
    transition, control = double_integrator(0.005)
    weight = np.diag([1.0 / sigma**2] * 6 + [0.0] * 6)
    value = solve_discrete_are(transition, control, weight, softness * np.eye(6))
    effort = softness * np.eye(6) + control.T @ value @ control
    expected = np.linalg.solve(effort, control.T @ value @ transition)
    np.testing.assert_allclose(compliance.gain, np.broadcast_to(expected, (20, 6, 12)), rtol=2e-2, atol=1e-6)


def test_steady_stiffness_is_inverse_deviation_over_root_softness():
    compliance = compute_compliance(make_tube(np.full((10, 6), [0.02] * 3 + [0.1] * 3)), 0.1)
    assert compliance.stiffness[5, 0, 0] == pytest.approx(1.0 / (0.02 * np.sqrt(0.1)), rel=0.05)
    assert compliance.damping[5, 0, 0] == pytest.approx(np.sqrt(2.0 * compliance.stiffness[5, 0, 0]), rel=0.05)


def test_recursion_minimizes_the_cost_that_a_batch_solution_minimizes():
    """Gains of the backward recursion give the optimal first input of the stacked least-squares problem."""
    generator = np.random.default_rng(0)
    transition, control = double_integrator(0.1)
    effort, steps = 0.3 * np.eye(6), 8
    weights = [np.diag(np.r_[generator.uniform(1.0, 50.0, 6), np.zeros(6)]) for _ in range(steps + 1)]
    value = weights[-1].copy()
    for weight in weights[-2::-1]:
        gain, value = riccati_step(transition, control, effort, value)
        value[:6, :6] += weight[:6, :6]
    state = generator.normal(size=12)
    free, forced = [state], [np.zeros((12, 6 * steps))]
    for k in range(steps):
        column = transition @ forced[-1]
        column[:, 6 * k : 6 * k + 6] += control
        forced.append(column)
        free.append(transition @ free[-1])
    H = 0.3 * np.eye(6 * steps) + sum(F.T @ W @ F for F, W in zip(forced, weights, strict=True))
    c = sum(F.T @ W @ x for F, W, x in zip(forced, weights, free, strict=True))
    np.testing.assert_allclose(-gain @ state, np.linalg.solve(H, -c)[:6], rtol=1e-9)


def test_narrow_is_stiff_and_wide_is_soft_by_at_least_six():
    deviation = np.full((50, 6), [0.005] * 3 + [0.03] * 3)
    deviation[:, 1] = 0.0025 + 0.0475 * np.exp(-((np.linspace(-1.0, 1.0, 50) / 0.3) ** 2))
    compliance = compute_compliance(make_tube(deviation, 5.0))
    across = compliance.stiffness[:, 1, 1]
    assert across.max() / across.min() >= 6.0
    assert np.argmin(across) == pytest.approx(25, abs=4)


@pytest.mark.parametrize("softness", [0.03, 0.1, 0.3, 1.0])
def test_stiffness_stays_in_its_range(softness):
    deviation = np.tile(np.array([1e-5, 1.0, 0.01, 1e-5, 3.0, 0.03]), (30, 1))
    compliance = compute_compliance(make_tube(deviation), softness)
    stiffness = np.linalg.eigvals(compliance.stiffness).real
    assert stiffness.max() <= STIFFNESS_RANGE[1] * 1.5 * (FLOOR[0] / (FLOOR[1] * LEVER))
    assert stiffness[:, :3].min() >= STIFFNESS_RANGE[0] * 0.9


def test_softer_setting_is_softer_and_closed_loop_is_stable():
    tube = make_tube(np.full((20, 6), 0.02))
    firm, soft = compute_compliance(tube, 0.1), compute_compliance(tube, 0.3)
    assert (np.diagonal(soft.stiffness, axis1=1, axis2=2) < np.diagonal(firm.stiffness, axis1=1, axis2=2)).all()
    transition, control = double_integrator(0.001)
    assert np.abs(np.linalg.eigvals(transition - control @ firm.gain[3])).max() < 1.0


def test_correlated_covariance_turns_the_stiffness_with_it():
    """The soft direction of a tube that is wide along (1, 1, 0) is (1, 1, 0)."""
    across = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    covariance = np.diag([0.005**2] * 3 + [0.03**2] * 3)
    covariance[:3, :3] += 0.03**2 * np.outer(across, across)
    tube = make_tube(np.full((20, 6), 0.01))
    tube = FlowTube("turned", tube.time, tube.position, tube.quaternion, np.tile(covariance, (20, 1, 1)))
    values, vectors = np.linalg.eigh(compute_compliance(tube).stiffness[10, :3, :3])
    assert abs(vectors[:, 0] @ across) == pytest.approx(1.0, abs=1e-6)
    assert values[1] / values[0] > 4.0


def test_weight_has_largest_eigenvalue_one_on_the_lever_and_a_floor():
    compliance = compute_compliance(make_tube(np.tile([0.003, 0.5, 0.01, 0.02, 0.02, 0.3], (5, 1))))
    levers = np.array([1.0] * 3 + [ANGLE] * 3)
    values = np.linalg.eigvalsh(compliance.weight / np.outer(levers, levers))
    np.testing.assert_allclose(values[:, -1], 1.0)
    assert values.min() >= 1.0 / 400.0 - 1e-12


def test_tube_without_orientation_holds_it_loosely():
    compliance = compute_compliance(make_tube(np.full((10, 3), 0.004)))
    assert 30.0 <= compliance.stiffness[5, 3, 3] < compliance.stiffness[5, 0, 0]


def test_repeated_times_in_a_tube_are_ordinary():
    tube = make_tube(np.full((10, 6), 0.01))
    time = np.array(tube.time)
    time[4:7] = time[4]
    again = FlowTube("pause", time, tube.position, tube.quaternion, tube.covariance)
    assert np.isfinite(compute_compliance(again).gain).all()


def test_gains_are_interpolated_and_held_beyond_the_ends():
    compliance = compute_compliance(make_tube(np.linspace([0.01] * 6, [0.03] * 6, 3)))
    np.testing.assert_array_equal(compliance.at(-1.0)[0], compliance.gain[0])
    np.testing.assert_array_equal(compliance.at(2.0)[0], compliance.gain[-1])
    np.testing.assert_allclose(compliance.at(0.25)[0], compliance.gain[:2].mean(axis=0))
    np.testing.assert_allclose(compliance.at(0.75)[1], compliance.weight[1:].mean(axis=0))


def test_constant_compliance_is_critically_damped():
    gain, _ = constant_compliance(400.0).at(0.3)
    np.testing.assert_allclose(gain, np.hstack([400.0 * np.eye(6), 40.0 * np.eye(6)]))


def test_operational_stiffness_is_inertia_times_stiffness():
    stiffness = operational_stiffness(2.0 * np.eye(6), np.stack([100.0 * np.eye(6)] * 3))
    np.testing.assert_allclose(stiffness[2], 200.0 * np.eye(6))


@pytest.mark.parametrize("setting", [{"softness": 0.0}, {"ceiling": -1.0}, {"stiffness_range": (100.0, 50.0)}])
def test_impossible_settings_are_refused_with_their_values(setting):
    with pytest.raises(ControlError, match="must be positive; got"):
        compute_compliance(make_tube(np.full((5, 6), 0.01)), **setting)


def test_stiffness_that_is_not_positive_is_refused():
    with pytest.raises(ControlError, match="1/s\\^2"):
        constant_compliance(0.0)
