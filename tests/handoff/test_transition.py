"""Transitions: they begin where the arm is, end where the target is, keep the limits, and fail as a value."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.handoff import plan_transition


def moving(start, amplitude=0.3, frequency=2.0):
    """A target that swings about a configuration."""

    def at(time):
        phase = frequency * time + np.arange(7)
        q = start + amplitude * np.sin(phase)
        return q, amplitude * frequency * np.cos(phase), -amplitude * frequency**2 * np.sin(phase)

    return at


def random_state(target, generator):
    q, v, _ = target(0.0)
    return q + generator.uniform(-0.15, 0.15, 7), v + generator.normal(0.0, 0.1, 7), generator.uniform(-1.0, 1.0, 7)


def test_from_200_random_states_the_moving_target_is_met(arm, start):
    """Start error zero, end error 1e-6, velocity, acceleration and jerk within their limits; 0.7 s at most."""
    generator, target, limits = np.random.default_rng(0), moving(start), arm.limits
    for _ in range(200):
        state = random_state(target, generator)
        transition = plan_transition(state, target, limits)
        assert transition.found, transition.reason
        assert transition.duration <= 0.7
        for got, expected in zip(transition.at(0.0), state, strict=True):
            np.testing.assert_array_equal(got, expected)
        just_before = transition.at(transition.duration * (1.0 - 1e-12))
        for got, expected in zip(just_before, target(transition.duration), strict=True):
            np.testing.assert_allclose(got, expected, atol=1e-6)
        times = np.linspace(0.0, transition.duration, 60)
        _, v, a = (np.array(part) for part in zip(*(transition.at(t) for t in times), strict=True))
        assert (np.abs(v) <= limits.velocity + 1e-9).all()
        assert (np.abs(a) <= limits.acceleration + 1e-9).all()
        assert (np.abs(np.diff(a, axis=0)) <= limits.jerk * times[1] + 1e-6).all()


def test_position_velocity_and_acceleration_are_continuous(arm, start):
    target = moving(start)
    transition = plan_transition(random_state(target, np.random.default_rng(1)), target, arm.limits)
    times = np.arange(0.0, transition.duration + 0.05, 1e-3)
    states = [transition.at(t) if t < transition.duration else target(t) for t in times]
    q, v, a = (np.array(part) for part in zip(*states, strict=True))
    np.testing.assert_allclose(np.diff(q, axis=0), 0.5e-3 * (v[1:] + v[:-1]), atol=1e-7)
    assert (np.abs(np.diff(a, axis=0)) <= arm.limits.jerk * 1e-3 + 1e-6).all()


def test_from_rest_on_a_target_at_rest_it_is_immediate(arm, start):
    still = start, np.zeros(7), np.zeros(7)
    transition = plan_transition(still, lambda _: still, arm.limits)
    assert transition.found
    assert transition.duration <= 0.001


def test_the_shortest_arrival_that_suffices_is_taken(arm, start):
    """Half the arrival time does not suffice: the quickest move there takes longer."""
    goal = start + 0.2, np.zeros(7), np.zeros(7)
    transition = plan_transition((start, np.zeros(7), np.zeros(7)), lambda _: goal, arm.limits)
    shorter = plan_transition(
        (start, np.zeros(7), np.zeros(7)), lambda _: goal, arm.limits, longest=0.9 * transition.duration
    )
    assert transition.found
    assert not shorter.found


def test_acceleration_of_the_target_at_its_limit_is_met_within_a_hundredth(arm, start):
    target = lambda _: (start, np.zeros(7), np.array(arm.limits.acceleration))  # noqa: E731
    transition = plan_transition((start, np.zeros(7), np.zeros(7)), target, arm.limits)
    assert transition.found
    np.testing.assert_allclose(transition.end[2], 0.99 * arm.limits.acceleration)


def test_a_joint_limit_on_the_way_is_a_reason_not_to(arm, start):
    """Moving fast towards a limit that is too near to stop before."""
    q, v = np.array(start), np.zeros(7)
    q[3], v[3] = arm.limits.upper[3] - 0.01, 0.9 * arm.limits.velocity[3]
    transition = plan_transition((q, v, np.zeros(7)), lambda _: (start, np.zeros(7), np.zeros(7)), arm.limits)
    assert not transition.found
    assert "joint limit" in transition.reason
    np.testing.assert_array_equal(transition.at(0.5)[0], q)


def test_a_target_that_cannot_be_caught_is_a_reason_not_to(arm, start):
    runaway = lambda t: (start + 1.0 + 10.0 * t, np.zeros(7), np.zeros(7))  # noqa: E731
    transition = plan_transition((start, np.zeros(7), np.zeros(7)), runaway, arm.limits, longest=0.5)
    assert not transition.found
    assert "cannot be met within 0.5 s" in transition.reason


@pytest.mark.parametrize("part", [0, 1, 2])
def test_what_is_not_finite_is_a_reason_not_to(arm, start, part):
    still = [np.array(start), np.zeros(7), np.zeros(7)]
    spoiled = [np.array(values) for values in still]
    spoiled[part][4] = np.nan
    assert "state is not finite" in plan_transition(tuple(spoiled), lambda _: tuple(still), arm.limits).reason
    assert "target is not finite" in plan_transition(tuple(still), lambda _: tuple(spoiled), arm.limits).reason


def test_limits_that_ruckig_refuses_are_a_reason_not_to(arm, start):
    wrong = replace(arm.limits, jerk=-np.ones(7))
    still = start, np.zeros(7), np.zeros(7)
    transition = plan_transition(still, lambda _: still, wrong)
    assert not transition.found
    assert "ruckig" in transition.reason


def test_beyond_its_ends_a_transition_stays(arm, start):
    goal = start + 0.1, np.zeros(7), np.zeros(7)
    transition = plan_transition((start, np.zeros(7), np.zeros(7)), lambda _: goal, arm.limits)
    np.testing.assert_array_equal(transition.at(-1.0)[0], start)
    np.testing.assert_array_equal(transition.at(99.0)[0], goal[0])
