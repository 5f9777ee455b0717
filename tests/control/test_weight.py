"""The estimate of an unknown weight: found within a second, never a person's force, bounded, calm with noise."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control import TrackingController, constant_compliance, holding
from pft_exec.control.weight import BOUNDS, WeightEstimate, weight_torque
from tests.control.plant import Plant

PERIOD = 0.002


def swaying(start):
    """A slow motion of all joints about a configuration, so that friction does not hide a weight."""

    def at(time):
        still = holding(start)(time)
        amplitude, rate = 0.1, 2.0
        wave = amplitude * (1.0 - np.cos(rate * time))
        return type(still)(
            start + wave,
            np.full(7, amplitude * rate * np.sin(rate * time)),
            np.full(7, amplitude * rate**2 * np.cos(rate * time)),
        )

    return at


def mass_after(arm, start, duration, payload=0.0, force=(0.0, 0.0, 0.0), blend=False):
    controller = TrackingController(arm, PERIOD)
    controller.follow(swaying(start), constant_compliance(200.0), 0.0, blend=blend)
    plant = Plant(arm, start, payload=payload)
    for step in range(round(duration / PERIOD)):
        command = controller.update(PERIOD * step, plant.q, plant.v)
        for _ in range(2):
            plant.step(command.torque, force)
    return controller.unknown_mass


def test_half_a_kilogram_is_found_within_three_seconds(arm, start):
    assert mass_after(arm, start, 3.0, payload=0.5) == pytest.approx(0.5, abs=0.08)


def test_a_weight_that_a_hand_has_borne_until_now_is_found_in_the_time_of_a_transition(arm, start):
    """Where the arm has tracked before, a force that comes may be a person's, and is not cancelled as soon."""
    assert mass_after(arm, start, 0.4, payload=0.5, blend=True) == pytest.approx(0.5, abs=0.12)
    assert mass_after(arm, start, 0.4, payload=0.5) <= 0.25


def test_a_second_after_a_take_over_a_push_is_a_person_again(arm, start):
    estimate = WeightEstimate(arm)
    estimate.expect()
    dynamics = arm.dynamics(start, np.zeros(7))
    push = -dynamics.jacobian[:3].T @ np.array([0.0, 0.0, -5.0])

    def hold(periods, first, missing):
        for k in range(first, first + periods):
            estimate.remember(PERIOD * k, np.zeros(7), dynamics, missing)
            estimate.update(PERIOD * (k + 1), np.zeros(7))

    hold(500, 0, np.zeros(7))
    hold(150, 500, push)
    assert abs(estimate.mass) <= 0.25


def test_where_a_hand_takes_over_what_was_known_of_the_weight_is_forgotten(arm, start):
    """The hand may have set it down: neither its mass nor the force that told it, nor the period before, counts."""
    controller = TrackingController(arm, PERIOD)
    controller.follow(swaying(start), constant_compliance(200.0), 0.0, blend=False)
    plant = Plant(arm, start, payload=1.0)
    for step in range(200):
        command = controller.update(PERIOD * step, plant.q, plant.v)
        plant.step(command.torque)
        plant.step(command.torque)
    assert controller.unknown_mass > 0.05
    controller.follow(holding(start), constant_compliance(200.0), PERIOD * 200)
    assert controller.unknown_mass == 0.0
    controller.update(PERIOD * 200, plant.q, plant.v)
    assert controller.unknown_mass == 0.0


def test_no_weight_is_found_where_there_is_none(arm, start):
    assert abs(mass_after(arm, start, 2.0)) <= 0.05


def test_a_force_from_the_side_is_left_to_the_person(arm, start):
    assert abs(mass_after(arm, start, 2.0, force=(0.0, 10.0, -5.0))) <= 0.05


def test_a_weight_beyond_its_bounds_is_not_believed(arm, start):
    assert mass_after(arm, start, 4.0, force=(0.0, 0.0, -30.0)) <= BOUNDS[1]


def test_a_short_vertical_push_is_hardly_cancelled(arm, start):
    """10 N for 0.3 s count as less than a third of the mass that they would weigh."""
    assert mass_after(arm, start, 0.3, force=(0.0, 0.0, -10.0)) <= 0.33


def test_the_torque_of_a_mass_is_that_of_a_payload(arm, start):
    expected = arm.with_payload(0.4).gravity(start) - arm.gravity(start)
    np.testing.assert_allclose(weight_torque(0.4, arm.jacobian(start)), expected, atol=1e-9)


def test_velocities_that_come_in_the_same_array_every_time_are_told_apart(arm, start):
    falling = np.linalg.pinv(arm.jacobian(start)) @ np.array([0.0, 0.0, -1e-3, 0.0, 0.0, 0.0])
    estimate, fresh, v = WeightEstimate(arm), WeightEstimate(arm), np.zeros(7)
    estimate.remember(0.0, v, arm.dynamics(start, v), np.zeros(7))
    fresh.remember(0.0, v.copy(), arm.dynamics(start, v), np.zeros(7))
    v += falling
    assert estimate.update(PERIOD, v) == fresh.update(PERIOD, v) > 0.0


def test_a_pause_is_not_judged(arm, start):
    estimate = WeightEstimate(arm)
    estimate.remember(0.0, np.zeros(7), arm.dynamics(start, np.zeros(7)), np.ones(7))
    assert estimate.update(1.0, np.ones(7)) == 0.0
    estimate.forget()
    assert estimate.update(0.001, np.ones(7)) == 0.0
