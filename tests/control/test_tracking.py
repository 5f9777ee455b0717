"""The tracking controller in closed loop: exact with an exact model, within limits always, calm with nonsense."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control import (
    TrackingController,
    compute_compliance,
    constant_compliance,
    holding,
    joined,
    plan_joint_trajectory,
)
from pft_exec.control.gravity_compensation import guiding_torque
from pft_exec.control.quadratic_program import Solution
from pft_exec.control.tracking import BLENDING_TIME
from pft_exec.exceptions import ConfigurationError, ControlError, UnknownMethodError
from pft_exec.handoff import plan_transition
from pft_exec.model import load_robot
from tests.control.plant import Plant, arch


def run(arm, plant, controller, duration, period=0.001, force=lambda _: np.zeros(3)):
    """Commands of a closed loop, and the tool's position error at each, m."""
    commands, errors = [], []
    for step in range(round(duration / period)):
        command = controller.update(step * period, plant.q, plant.v)
        errors.append(command.error)
        for _ in range(round(period / plant.step_time)):
            plant.step(command.torque, force(step * period))
        commands.append(command)
    return commands, np.array(errors)


@pytest.fixture(scope="module")
def trajectory(arm, tube, start):
    return plan_joint_trajectory(arm, tube, start)


@pytest.fixture(scope="module")
def compliance(tube):
    return compute_compliance(tube)


@pytest.mark.parametrize(("period", "solver"), [(0.001, "daqp"), (0.002, "daqp"), (0.002, "osqp")])
def test_perfect_model_is_tracked_to_three_tenths_of_a_millimetre(arm, start, trajectory, compliance, period, solver):
    frictionless = arm.with_payload(0.0)
    frictionless.friction = type(arm.friction)(np.zeros(7), np.zeros(7))
    controller = TrackingController(frictionless, period, solver)
    controller.follow(trajectory.at, compliance, 0.0, blend=False)
    commands, errors = run(arm, Plant(arm, start, friction=0.0), controller, trajectory.duration + 0.2, period)
    assert not any(command.fallback for command in commands)
    assert np.sqrt(np.mean(np.sum(errors[:, :3] ** 2, axis=1))) <= 3e-4
    assert np.sqrt(np.mean(np.sum(errors[:, 3:] ** 2, axis=1))) <= 5e-4


def test_friction_a_fifth_wrong_ends_within_three_millimetres(arm, start, trajectory, compliance):
    controller = TrackingController(arm)
    controller.follow(trajectory.at, compliance, 0.0, blend=False)
    _, errors = run(arm, Plant(arm, start, friction=1.25), controller, trajectory.duration + 0.3)
    assert np.linalg.norm(errors[-1, :3]) <= 3e-3
    assert np.sqrt(np.mean(np.sum(errors[:, :3] ** 2, axis=1))) <= 5e-3


@pytest.mark.parametrize("robot", ["pr2", "wam"])
def test_everything_wrong_at_once_is_a_centimetre_and_never_a_fault(robot):
    """Friction a fifth wrong, 0.5 kg unknown payload, encoder noise, one period of delay, 500 Hz; either robot."""
    model = load_robot(robot)
    other = model.arm(model.arms[0])
    begin, generator, period = np.array(other.configuration("work")), np.random.default_rng(0), 0.002
    tube = arch(other, begin, 2.0, 60)
    trajectory = plan_joint_trajectory(other, tube, begin)
    controller, plant = TrackingController(other, period), Plant(other, begin, friction=1.25, payload=0.5)
    controller.follow(trajectory.at, compute_compliance(tube), 0.0, blend=False)
    late = other.gravity(begin) - other.counterbalance(begin)
    for step in range(round((trajectory.duration + 0.3) / period)):
        q, v = plant.q + generator.normal(0.0, 1e-4, 7), plant.v + generator.normal(0.0, 3e-3, 7)
        command = controller.update(step * period, q, v)
        assert not command.fallback
        assert (np.abs(command.torque) <= other.limits.torque + 1e-9).all()
        assert np.linalg.norm(command.error[:3]) <= 0.015
        for _ in range(2):
            plant.step(late)
        late = command.torque


def test_torque_is_within_its_limit_when_thrown_far_off(arm, start, trajectory, compliance):
    """From 200 states far from the reference; the solution is the torque's, and what is active is said so."""
    generator = np.random.default_rng(0)
    controller = TrackingController(arm)
    controller.follow(trajectory.at, compliance, 0.0)
    saturated = 0
    for _ in range(200):
        q = np.clip(start + generator.normal(0.0, 0.3, 7), arm.limits.lower, arm.limits.upper)
        command = controller.update(1.0, q, generator.normal(0.0, 1.0, 7))
        assert (np.abs(command.torque) <= arm.limits.torque + 1e-9).all()
        assert not command.fallback
        active = np.abs(command.torque) >= arm.limits.torque - 1e-6
        assert (command.torque_active <= active).all()
        saturated += int(command.torque_active.any())
    assert saturated > 0


def test_joint_limits_hold_when_the_reference_lies_beyond_them(arm, start):
    """A reference beyond a limit is approached, never followed across it."""
    beyond = np.array(start)
    beyond[3] = arm.limits.upper[3] + 0.3
    near = np.array(start)
    near[3] = arm.limits.upper[3] - 0.3
    plant, controller = Plant(arm, near, friction=0.0), TrackingController(arm)
    controller.follow(holding(beyond), constant_compliance(100.0), 0.0, blend=False)
    reached = []
    for step in range(1500):
        command = controller.update(0.001 * step, plant.q, plant.v)
        plant.step(command.torque)
        reached.append(plant.q.copy())
    assert (np.array(reached) <= arm.limits.upper + 2e-3).all()
    assert (np.array(reached) >= arm.limits.lower - 2e-3).all()
    assert max(np.array(reached)[:, 3]) > near[3] + 0.1
    assert command.bound_active.any()


def test_a_push_moves_the_tool_farther_where_the_tube_is_wide(arm, tube, start, trajectory, compliance):
    """10 N for 0.3 s across: constant gains answer alike everywhere, the tube's gains do not."""

    def deviation(gains, at):
        errors = []
        for force in (0.0, 10.0):
            controller, plant = TrackingController(arm), Plant(arm, start)
            controller.follow(trajectory.at, gains, 0.0, blend=False)
            push = lambda t, f=force: np.array([0.0, f, 0.0]) * (at <= t < at + 0.3)  # noqa: E731
            errors.append(run(arm, plant, controller, at + 0.5, force=push)[1][:, 1])
        return np.abs(errors[1] - errors[0]).max()

    narrow, wide = trajectory.duration - 0.1, 0.45 * trajectory.duration
    assert deviation(compliance, wide) > 2.0 * deviation(compliance, narrow)


def test_commanded_reference_is_continuous_at_both_seams(arm, tube, start, trajectory, compliance):
    """From a state 3 cm off the tube, moving: position, velocity and acceleration of the command do not jump."""
    generator = np.random.default_rng(4)
    middle = plan_joint_trajectory(arm, tube, trajectory.at(0.8).configuration, phase=0.4)
    begin = middle.at(0.0)
    q, v = begin.configuration + generator.uniform(-0.05, 0.05, 7), begin.velocity + generator.normal(0.0, 0.05, 7)
    transition = plan_transition((q, v, np.zeros(7)), middle.state_at, arm.limits)
    assert transition.found
    controller, plant = TrackingController(arm), Plant(arm, q, v)
    controller.follow(joined(transition.at, transition.duration, middle.at), compliance, 0.0)
    commands, errors = run(arm, plant, controller, transition.duration + 0.5)
    np.testing.assert_allclose(commands[0].configuration, q, atol=1e-6)
    np.testing.assert_allclose(commands[0].velocity, v, atol=1e-6)
    steps = np.abs(np.diff([command.reference_acceleration for command in commands], axis=0))
    assert (steps <= arm.limits.jerk * 0.001 + 1e-6).all()
    assert np.abs(commands[0].reference_acceleration).max() <= 1e-9
    torque = np.abs(np.diff([command.torque for command in commands[:300]], axis=0))
    assert torque.max() <= 0.5
    assert np.linalg.norm(errors[-1, :3]) <= 1e-3


def test_friction_comes_in_and_what_helped_the_hand_goes_out_over_the_blending_time(arm, start):
    controller = TrackingController(arm)
    controller.follow(holding(start), constant_compliance(100.0), 2.0)
    v = np.full(7, 0.2)
    dynamics = arm.dynamics(start, v)
    at_first = controller._blended(2.0, v, v, dynamics)
    np.testing.assert_allclose(at_first, guiding_torque(arm.friction, v, dynamics, controller.control_period))
    half = controller._blended(2.0 + 0.5 * BLENDING_TIME, v, v, dynamics)
    whole = controller._blended(2.0 + BLENDING_TIME, v, v, dynamics)
    np.testing.assert_allclose(half, 0.5 * (at_first + whole))
    np.testing.assert_allclose(whole, arm.friction.coulomb + arm.friction.viscous * 0.2, rtol=1e-6)


@pytest.mark.parametrize("spoiled", ["q", "v"])
def test_a_measurement_that_is_not_finite_falls_back_and_recovers(arm, start, compliance, trajectory, spoiled):
    controller = TrackingController(arm)
    controller.follow(trajectory.at, compliance, 0.0)
    state = {"q": start.copy(), "v": np.zeros(7)}
    good = controller.update(0.1, **state)
    state[spoiled][2] = np.nan
    command = controller.update(0.101, **state)
    assert command.fallback
    assert "not finite" in command.status
    assert np.isfinite(command.torque).all()
    assert (np.abs(command.torque) <= arm.limits.torque).all()
    state[spoiled][2] = 0.0 if spoiled == "v" else start[2]
    np.testing.assert_allclose(controller.update(0.1, **state).torque, good.torque)


def test_a_reference_that_is_not_finite_falls_back(arm, start):
    controller = TrackingController(arm)
    controller.follow(holding(np.full(7, np.nan)), constant_compliance(100.0), 0.0)
    command = controller.update(0.0, start, np.zeros(7))
    assert command.fallback
    assert np.isfinite(command.torque).all()


def test_no_solution_falls_back_to_damped_gravity_compensation(arm, start, monkeypatch):
    controller = TrackingController(arm)
    controller.follow(holding(start), constant_compliance(100.0), 0.0)
    nothing = Solution(False, np.full(7, np.nan), status="asked to fail")
    monkeypatch.setattr(controller._solver, "solve", lambda _: nothing)
    command = controller.update(0.0, start, np.zeros(7))
    assert command.fallback
    assert "asked to fail" in command.status
    np.testing.assert_allclose(command.torque, arm.gravity(start) - arm.counterbalance(start), atol=1e-12)


def test_nothing_to_follow_is_a_fallback_too(arm, start):
    command = TrackingController(arm).update(0.0, start, np.zeros(7))
    assert command.fallback
    assert "nothing to follow" in command.status


def test_a_control_period_that_is_not_positive_is_refused(arm):
    with pytest.raises(ControlError, match="control period must be positive"):
        TrackingController(arm, 0.0)


def test_an_unknown_solver_is_refused(arm):
    with pytest.raises(UnknownMethodError, match="solver"):
        TrackingController(arm, solver="simplex")


def test_a_payload_comes_in_as_its_weight_and_nothing_else(arm, start):
    """At rest on its reference: at once, the torque steps by the payload's gravity; blended, it grows to it."""
    heavy = arm.with_payload(0.5)
    controller = TrackingController(arm)
    controller.follow(holding(start), constant_compliance(100.0), 0.0, blend=False)
    still = np.zeros(7)
    before = controller.update(1.0, start, still).torque
    controller.carry(heavy, since=1.0)
    np.testing.assert_allclose(controller.update(1.0, start, still).torque, before, atol=1e-9)
    steps = [controller.update(1.0 + t, start, still).torque for t in np.arange(0.0, 0.1, 0.001)]
    assert np.abs(np.diff(steps, axis=0)).max() <= 0.2
    weight = heavy.gravity(start) - arm.gravity(start)
    np.testing.assert_allclose(steps[-1] - before, weight, atol=1e-6)
    controller.carry(arm)
    np.testing.assert_allclose(controller.update(2.0, start, still).torque, before, atol=1e-9)


def test_a_model_with_other_joints_cannot_be_carried(arm):
    other = load_robot("pr2").arm("right")
    other.limits = type(other.limits)(*(getattr(other.limits, name)[:3] for name in other.limits.__dataclass_fields__))
    with pytest.raises(ConfigurationError):
        TrackingController(other).carry(arm)


def test_a_command_says_what_its_objectives_cost_and_how_long_it_took(arm, start):
    controller = TrackingController(arm)
    controller.follow(holding(start), constant_compliance(100.0), 0.0, blend=False)
    at_rest = controller.update(0.0, start, np.zeros(7))
    assert at_rest.costs["tracking"] == pytest.approx(0.0, abs=1e-9)
    thrown = controller.update(0.0, start + 0.5, np.ones(7))
    assert thrown.costs["tracking"] > 0.1
    assert thrown.solve_time > 0.0
