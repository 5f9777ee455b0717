"""Taking back: the force from outside is felt in the joints, quickly, and only when it is meant."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control import TrackingController, compute_compliance, plan_joint_trajectory
from pft_exec.exceptions import ControlError
from pft_exec.handoff import ForceObserver, TakeBack
from pft_exec.handoff.take_back import THRESHOLD, tool_wrench
from tests.control.plant import Plant, arch


def estimates(arm, plant, force, duration=0.1, period=0.001):
    """Forces (T, 3), N, that an observer sees while gravity is compensated and a force acts."""
    observer, seen, torque = ForceObserver(arm, period), [], None
    for _ in range(round(duration / period)):
        seen.append(observer.update(plant.q, plant.v, torque).force)
        torque = arm.gravity(plant.q) - arm.counterbalance(plant.q)
        plant.step(torque, force)
    return np.array(seen)


def frictionless(arm):
    bare = arm.with_payload(0.0)
    bare.friction = type(arm.friction)(np.zeros(7), np.zeros(7))
    return bare


def test_without_a_force_nothing_is_felt(arm, start):
    seen = estimates(frictionless(arm), Plant(arm, start, np.full(7, 0.1), friction=0.0), np.zeros(3))
    assert np.abs(seen).max() <= 0.3


def test_a_force_is_felt_with_its_size_and_direction(arm, start):
    force = np.array([10.0, -15.0, 5.0])
    seen = estimates(frictionless(arm), Plant(arm, start, friction=0.0), force)
    np.testing.assert_allclose(seen[60], force, atol=1.0)


def test_half_of_a_sudden_force_is_seen_after_eight_milliseconds(arm, start):
    seen = estimates(frictionless(arm), Plant(arm, start, friction=0.0), np.array([0.0, 20.0, 0.0]))
    assert seen[8, 1] >= 10.0


def test_joint_torques_of_a_wrench_give_the_wrench_back(arm, start):
    dynamics, wrench = arm.dynamics(start, np.zeros(7)), np.array([3.0, -2.0, 1.0, 0.3, 0.2, -0.1])
    np.testing.assert_allclose(tool_wrench(dynamics, dynamics.jacobian.T @ wrench), wrench, atol=1e-5)


def test_a_measurement_that_is_not_finite_leaves_the_estimate_as_it_was(arm, start):
    observer = ForceObserver(arm, 0.001)
    torque = arm.gravity(start) - arm.counterbalance(start)
    observer.update(start, np.zeros(7), torque)
    before = observer.update(start, np.full(7, 1e-3), torque)
    spoiled = np.array(start)
    spoiled[0] = np.nan
    np.testing.assert_array_equal(observer.update(spoiled, np.zeros(7), torque).force, before.force)
    assert np.isfinite(observer.update(start, np.zeros(7), torque).force).all()


def test_a_lasting_force_above_the_threshold_takes_back_and_an_impact_does_not():
    take_back = TakeBack(threshold=15.0, hold_time=0.005)
    strong, weak = np.array([0.0, 16.0, 0.0]), np.array([14.0, 0.0, 0.0])
    assert [take_back.update(0.001 * k, strong) for k in range(7)] == [False] * 5 + [True] * 2
    assert not take_back.update(0.010, weak)
    assert not take_back.update(0.011, strong)


def test_a_push_of_twenty_newtons_takes_back_in_half_the_time_where_it_is_told_period_by_period(arm, start):
    """The low pass alone needs nine milliseconds."""
    plant, observer, torque = Plant(arm, start), ForceObserver(arm, 0.001), None
    smooth, sudden, felt = TakeBack(), TakeBack(), {}
    for step in range(120):
        external = observer.update(plant.q, plant.v, torque)
        if smooth.update(0.001 * step, external.force):
            felt.setdefault("smooth", step - 100)
        if sudden.update(0.001 * step, external.force, external.sudden):
            felt.setdefault("sudden", step - 100)
        torque = arm.gravity(plant.q) - arm.counterbalance(plant.q)
        plant.step(torque, np.array([0.0, 25.0 if step >= 100 else 0.0, 0.0]))
    assert 0 < felt["sudden"] <= 6
    assert felt["smooth"] >= felt["sudden"] + 3


def test_a_push_of_twenty_newtons_takes_back_within_twenty_milliseconds(arm, start):
    """On the arm as it is, with its dry friction."""
    seen = estimates(arm, Plant(arm, start), np.array([0.0, 25.0, 0.0]))
    take_back = TakeBack()
    first = next(k for k, force in enumerate(seen) if take_back.update(0.001 * k, force))
    assert first <= 20


@pytest.mark.parametrize("mismatch", [{"friction": 1.25}, {"friction": 0.8}, {"payload": 0.5}])
def test_what_the_model_does_not_know_is_not_taken_for_a_person(arm, start, mismatch):
    """Along a motion, friction a fifth wrong and half a kilogram of unknown payload stay below the threshold."""
    tube = arch(arm, start, 2.0, 60)
    controller, plant = TrackingController(arm), Plant(arm, start, **mismatch)
    trajectory = plan_joint_trajectory(arm, tube, start)
    controller.follow(trajectory.at, compute_compliance(tube), 0.0, blend=False)
    observer, felt, torque = ForceObserver(arm, 0.001), [], None
    for step in range(round(1000 * trajectory.duration)):
        felt.append(np.linalg.norm(observer.update(plant.q, plant.v, torque).force))
        torque = controller.update(0.001 * step, plant.q, plant.v).torque
        plant.step(torque)
    assert max(felt) <= 0.6 * THRESHOLD


def first_taken(take_back, force, duration=3.0):
    """When, s, a force (N, as a function of time) is taken for a person; None where it is not."""
    times = np.arange(0.0, duration, 0.001)
    return next((time for time in times if take_back.update(time, np.array([0.0, 0.0, force(time)]))), None)


def test_a_force_that_comes_slowly_and_stays_is_the_model_and_a_push_on_top_of_it_a_person():
    take_back = TakeBack(threshold=15.0)
    assert first_taken(take_back, lambda t: min(9.0, 10.0 * t)) is None
    assert take_back.usual[2] == pytest.approx(9.0, abs=0.1)
    assert take_back.update(3.0, np.array([0.0, 16.0, 9.0])) is False
    assert take_back.update(3.01, np.array([0.0, 16.0, 9.0])) is True


def test_a_push_that_grows_slowly_is_a_person_too():
    assert first_taken(TakeBack(threshold=15.0), lambda t: 10.0 * t) == pytest.approx(2.5, abs=0.5)


def test_a_hand_that_is_letting_go_takes_nothing_back_and_one_that_does_not_let_go_does():
    letting_go, holding = TakeBack(threshold=15.0), TakeBack(threshold=15.0)
    letting_go.wait(0.5)
    holding.wait(0.5)
    assert first_taken(letting_go, lambda t: 25.0 * max(0.0, 1.0 - t / 0.3)) is None
    assert first_taken(holding, lambda _: 25.0) == pytest.approx(0.5, abs=0.006)


def test_after_the_hand_has_let_go_a_push_counts_at_once():
    take_back = TakeBack(threshold=15.0)
    take_back.wait(0.5)
    taken = first_taken(take_back, lambda t: 20.0 if t < 0.1 or t >= 0.2 else 0.0)
    assert taken == pytest.approx(0.2, abs=0.006)


@pytest.mark.parametrize("wrong", [{"control_period": 0.0}, {"control_period": 0.001, "bandwidth": -1.0}])
def test_a_period_or_bandwidth_that_is_not_positive_is_refused(arm, wrong):
    with pytest.raises(ControlError, match="must be positive"):
        ForceObserver(arm, **wrong)


@pytest.mark.parametrize("wrong", [{"threshold": 0.0}, {"hold_time": -1.0}])
def test_an_impossible_threshold_is_refused(wrong):
    with pytest.raises(ControlError, match="threshold"):
        TakeBack(**wrong)
