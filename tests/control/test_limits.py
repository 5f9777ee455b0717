"""Bounds on accelerations: never empty, and what they allow stays within the limits for ever."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pft_exec.control import acceleration_bounds, torque_constraint
from pft_exec.control.limits import AUTHORITY, BRAKING_SHARE, SPEED_SHARE, largest_acceleration

COUNT = 1_000_000


class ManyJoints:
    """Limits of very many joints, so that one call is a million random states."""

    def __init__(self, seed):
        generator = np.random.default_rng(seed)
        self.lower = generator.uniform(-3.0, 0.0, COUNT)
        self.acceleration = generator.uniform(2.0, 20.0, COUNT)
        self.velocity = generator.uniform(0.3, 4.0, COUNT)
        self.upper = self.lower + generator.uniform(0.01, 5.0, COUNT)
        self.brake = BRAKING_SHARE * self.acceleration
        self.fastest = SPEED_SHARE * self.velocity

    def viable(self, q, v):
        """How far each state is outside the set from which the joint can still stop in time; 0 inside."""
        over = np.maximum(q + np.maximum(v, 0.0) ** 2 / (2 * self.brake) - self.upper, 0.0)
        under = np.maximum(self.lower - (q - np.minimum(v, 0.0) ** 2 / (2 * self.brake)), 0.0)
        return np.maximum(np.maximum(over, under), np.maximum(np.abs(v) - self.fastest, 0.0))

    def viable_states(self, generator):
        """Random states inside that set, a third of them on its edge."""
        q = generator.uniform(self.lower, self.upper)
        highest = np.minimum(self.fastest, np.sqrt(2 * self.brake * (self.upper - q)))
        lowest = -np.minimum(self.fastest, np.sqrt(2 * self.brake * (q - self.lower)))
        share = np.clip(generator.uniform(-0.5, 1.5, COUNT), 0.0, 1.0)
        return q, lowest + share * (highest - lowest)


@pytest.mark.parametrize("period", [0.001, 0.002])
def test_from_a_million_viable_states_every_allowed_acceleration_leads_to_a_viable_state(period):
    generator = np.random.default_rng(1)
    limits = ManyJoints(2)
    q, v = limits.viable_states(generator)
    lower, upper = acceleration_bounds(limits, period, q, v)
    assert (lower <= upper).all()
    assert (np.maximum(np.abs(lower), np.abs(upper)) <= AUTHORITY * limits.acceleration).all()
    for share in (0.0, 0.3, 1.0):
        a = lower + share * (upper - lower)
        outside = limits.viable(q + period * v + 0.5 * period**2 * a, v + period * a)
        assert outside.max() <= 1e-9


def test_a_million_arbitrary_states_have_an_interval_that_is_never_empty():
    generator = np.random.default_rng(3)
    limits = ManyJoints(4)
    q, v = generator.uniform(-10.0, 10.0, COUNT), generator.normal(0.0, 5.0, COUNT)
    lower, upper = acceleration_bounds(limits, 0.001, q, v)
    assert (lower <= upper).all()
    assert (np.maximum(np.abs(lower), np.abs(upper)) <= AUTHORITY * limits.acceleration).all()


def test_largest_allowed_acceleration_held_for_long_stops_at_the_end():
    q, v, period = 0.0, 0.0, 0.001
    for _ in range(5000):
        a = largest_acceleration(1.0 - q, v, 2.0, 8.0, period)
        q, v = q + period * v + 0.5 * period**2 * a, v + period * a
        assert q <= 1.0 + 1e-12
    assert q == pytest.approx(1.0, abs=1e-4)
    assert abs(v) <= BRAKING_SHARE * 8.0 * period


def test_a_joint_that_is_pressed_on_keeps_room_below_its_velocity_limit():
    v = 0.0
    for _ in range(2000):
        v += 0.001 * largest_acceleration(10.0, v, 2.0, 8.0, 0.001)
    assert v == pytest.approx(SPEED_SHARE * 2.0)


def test_a_joint_pushed_beyond_its_limit_is_back_within_a_fifth_of_a_second():
    q, v, period = 1.01, 0.0, 0.001
    for _ in range(200):
        a = largest_acceleration(1.0 - q, v, 2.0, 6.0, period)
        q, v = q + period * v + 0.5 * period**2 * a, v + period * a
    assert q <= 1.0005


@given(
    room=st.floats(-5.0, 5.0),
    v=st.floats(-20.0, 20.0),
    speed=st.floats(0.1, 5.0),
    acceleration=st.floats(1.0, 30.0),
)
@settings(max_examples=300, deadline=None, derandomize=True)
def test_compiled_and_plain_function_agree(room, v, speed, acceleration):
    plain = largest_acceleration.py_func(room, v, speed, acceleration, 0.001)
    assert largest_acceleration(room, v, speed, acceleration, 0.001) == pytest.approx(plain, rel=1e-12, abs=1e-12)


def test_torque_rows_hold_exactly_where_the_motor_is_within_its_limit(arm, start):
    """``lower <= M qdd <= upper`` is ``|M qdd + load| <= limit``, friction and springs included."""
    generator = np.random.default_rng(5)
    load, mass_matrix = generator.normal(0.0, 10.0, 7), arm.mass_matrix(start)
    rows = torque_constraint(mass_matrix, load, arm.limits.torque)
    torque = arm.limits.torque * generator.choice([-1.0, 1.0], 7)
    qdd = np.linalg.solve(mass_matrix, torque - load)
    at_limit = rows.G @ qdd
    np.testing.assert_allclose(np.where(torque > 0, rows.upper, rows.lower), at_limit, atol=1e-9)
    assert not rows.soft
