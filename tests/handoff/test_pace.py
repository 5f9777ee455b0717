"""The pace: a reference slowed down, stopped and let go on stays smooth, and untouched it keeps time."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.handoff import PacedClock

PERIOD = 0.001


def run(wanted):
    """Time, rate and its change (T, 3) of a clock after each period, for the rates wanted."""
    clock, seen = PacedClock(), []
    for rate in wanted:
        clock.advance(PERIOD, rate)
        seen.append((clock.time, clock.rate, clock.change))
    return np.array(seen).T


def test_undisturbed_it_keeps_time():
    time, rate, change = run([1.0] * 1000)
    np.testing.assert_allclose(time, PERIOD * np.arange(1, 1001), atol=1e-12)
    assert set(rate) == {1.0}
    assert set(change) == {0.0}


def test_stopped_and_let_go_on_nothing_jumps_and_it_never_runs_backwards():
    time, rate, change = run([1.0] * 100 + [0.0] * 1000 + [1.0] * 1000)
    assert np.diff(time).min() >= -1e-12
    np.testing.assert_allclose(np.diff(time), 0.5 * PERIOD * (rate[1:] + rate[:-1]), atol=2e-8)
    np.testing.assert_allclose(np.diff(rate), 0.5 * PERIOD * (change[1:] + change[:-1]), atol=1e-4)
    assert np.abs(np.diff(change)).max() <= 0.15  # 12^2 / s^2 for a period, at most


def test_a_rate_that_is_wanted_is_reached():
    _, rate, change = run([0.3] * 2000)
    assert rate[-1] == pytest.approx(0.3, abs=1e-6)
    assert change[-1] == pytest.approx(0.0, abs=1e-6)
