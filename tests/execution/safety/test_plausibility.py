"""Readings that cannot be are left out, and what can be is believed to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.execution.safety.plausibility import COAST_TIME, STILL_TIME, StateGuard
from pft_exec.model import load_robot

PERIOD = 0.002
LIMITS = load_robot("pr2").arm("right").limits
TIMES = PERIOD * np.arange(400)
JOINT = 3


def swing(time: float) -> tuple[np.ndarray, np.ndarray]:
    """A smooth motion of all joints: 0.3 rad at 1 Hz."""
    return 0.3 * np.sin(2.0 * np.pi * time) * np.ones(7) - 1.0, 0.6 * np.pi * np.cos(2.0 * np.pi * time) * np.ones(7)


def worst_error(spoil) -> tuple[float, StateGuard]:
    """Largest error of the believed positions where `spoil(k, q, v)` is what is read."""
    guard, worst = StateGuard(LIMITS, PERIOD), 0.0
    for k, time in enumerate(TIMES):
        q, v = swing(time)
        believed, _ = guard.update(*spoil(k, q.copy(), v.copy()))
        worst = max(worst, float(np.abs(believed - q).max()))
    return worst, guard


def test_a_motion_is_believed_as_it_is_read() -> None:
    worst, guard = worst_error(lambda _, q, v: (q, v))
    assert worst == 0.0
    assert guard.doubt == 0.0
    assert guard.reason == ""


def test_readings_that_come_in_the_same_arrays_every_time_are_told_apart() -> None:
    guard, q, v = StateGuard(LIMITS, PERIOD), np.zeros(7), np.zeros(7)
    for time in TIMES:
        q[:], v[:] = swing(time)
        guard.update(q, v)
        assert guard.doubt == 0.0, guard.reason
    q += 0.2
    guard.update(q, v)
    assert "jumped by 0.199 rad" in guard.reason


def test_ordinary_noise_and_a_hit_are_no_faults() -> None:
    rng = np.random.default_rng(0)

    def noisy(k, q, v):
        return q + 1e-4 * rng.standard_normal(7), v + 3e-3 * rng.standard_normal(7)

    worst, _ = worst_error(noisy)
    assert 0.0 < worst < 1e-3
    guard = StateGuard(LIMITS, PERIOD)
    q, v = np.full(7, -1.0), np.zeros(7)
    guard.update(q, v)
    hit = np.zeros(7)
    hit[JOINT] = 900.0 * PERIOD  # rad/s after a period of 900 rad/s^2
    guard.update(q + 0.5 * PERIOD * hit, hit)
    assert guard.doubt == 0.0


def test_single_readings_that_are_off_are_left_out() -> None:
    def spiked(k, q, v):
        q[JOINT] += 0.05 * (k % 20 == 10)
        return q, v

    worst, guard = worst_error(spiked)
    assert worst < 1e-3
    assert guard.doubt == 0.0


@pytest.mark.parametrize("jump", [0.02, -0.5])
def test_an_encoder_that_slipped_is_followed_by_its_increments(jump: float) -> None:
    def slipped(k, q, v):
        q[JOINT] += jump * (k >= 100)
        return q, v

    worst, guard = worst_error(slipped)
    assert worst < 5e-3
    assert guard.doubt == pytest.approx(300 * PERIOD)
    assert f"joint {JOINT + 1}" in guard.reason


def test_no_number_is_bridged_by_the_velocity_and_seen_again_afterwards() -> None:
    def blind(k, q, v):
        q[JOINT] = np.nan if 100 <= k < 108 else q[JOINT]
        return q, v

    worst, guard = worst_error(blind)
    assert worst < 1e-3
    assert guard.doubt == 0.0


def test_nothing_read_is_nothing_but_finite() -> None:
    """With neither positions nor velocities the joints are believed to come to rest, and their speed is not seen."""
    guard = StateGuard(LIMITS, PERIOD)
    for k, time in enumerate(TIMES):
        q, v = swing(time)
        believed = guard.update(*((q, v) if k < 100 else (q * np.nan, v * np.nan)))
        assert np.isfinite(believed).all()
    assert np.abs(believed[1]).max() < 0.05
    assert guard.unseen.all()
    assert guard.doubt == pytest.approx(300 * PERIOD)


def test_a_first_reading_that_is_no_number_is_replaced_by_the_middle_of_the_limits() -> None:
    guard = StateGuard(LIMITS, PERIOD)
    q, v = guard.update(np.full(7, np.nan), np.zeros(7))
    assert ((q > LIMITS.lower) & (q < LIMITS.upper)).all()
    assert guard.doubt > 0.0
    read = np.full(7, -1.0)
    np.testing.assert_array_equal(guard.update(read, v)[0], read)
    assert guard.doubt == 0.0 or guard.reason == ""


def test_a_moving_arm_that_repeats_its_reading_is_not_seen() -> None:
    guard = StateGuard(LIMITS, PERIOD)
    last = swing(TIMES[99])
    for k, time in enumerate(TIMES[:110]):
        guard.update(*(swing(time) if k < 100 else last))
    assert guard.doubt == pytest.approx(10 * PERIOD)
    assert "repeat" in guard.reason


def test_an_arm_that_rests_may_repeat_its_reading_for_a_moment_and_is_not_seen_then() -> None:
    """Nothing else tells frozen encoders from rest under a hand: it would lead an arm that sees nothing."""
    guard, given = StateGuard(LIMITS, PERIOD), round(STILL_TIME / PERIOD)
    for _ in range(1 + given):
        guard.update(np.full(7, -1.0), np.zeros(7))
        assert guard.doubt == 0.0
    for _ in range(round(COAST_TIME / PERIOD) + 2):
        guard.update(np.full(7, -1.0), np.zeros(7))
    assert guard.is_lost
    assert guard.unseen.all()
    assert "repeat" in guard.reason


def test_an_arm_at_rest_whose_readings_carry_noise_is_believed() -> None:
    guard, generator = StateGuard(LIMITS, PERIOD), np.random.default_rng(0)
    for _ in range(500):
        guard.update(np.full(7, -1.0) + 1e-9 * generator.standard_normal(7), np.zeros(7))
    assert guard.doubt == 0.0


def test_coarse_encoders_may_be_given_all_the_time_that_they_need() -> None:
    guard = StateGuard(LIMITS, PERIOD, still_time=np.inf)
    for _ in range(500):
        guard.update(np.full(7, -1.0), np.zeros(7))
    assert guard.doubt == 0.0
