"""The time law: constant rate, a smooth stop, and the derivatives it claims."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control.time_law import TimeLaw

LAWS = [
    TimeLaw(0.0, 2.0),
    TimeLaw(0.5, 2.0, 0.7, 0.4),
    TimeLaw(1.9, 2.0, 1.5, 0.5),
    TimeLaw(0.2, 2.0, 0.8, 0.1, 0.3),
    TimeLaw(0.2, 2.0, 0.8, 0.1, 0.3, 0.4),
]


@pytest.mark.parametrize("law", LAWS)
def test_rate_and_change_are_the_derivatives(law):
    step = 1e-6
    for time in np.linspace(0.01, law.duration - 0.003, 50):
        before, now, after = law.at(time - step), law.at(time), law.at(time + step)
        assert (after[0] - before[0]) / (2 * step) == pytest.approx(now[1], abs=1e-6)
        assert (after[1] - before[1]) / (2 * step) == pytest.approx(now[2], abs=1e-3)


def test_it_begins_at_the_beginning_and_rests_at_the_end():
    law = TimeLaw(0.5, 2.0, 1.2, 0.3)
    assert law.at(0.0) == (0.5, 1.2, 0.0)
    assert law.at(law.duration) == (2.0, 0.0, 0.0)
    assert law.at(1e9) == (2.0, 0.0, 0.0)
    theta, rate, change = law.at(law.duration - 1e-6)
    assert (theta, rate, change) == pytest.approx((2.0, 0.0, 0.0), abs=1e-4)


def test_stop_costs_half_of_its_time():
    assert TimeLaw(0.0, 2.0, 1.0, 0.4).duration == pytest.approx(2.2)
    assert TimeLaw(2.0, 2.0).at(0.0) == (2.0, 0.0, 0.0)


def test_from_a_standstill_it_comes_up_to_its_rate() -> None:
    """At rest and without acceleration at first; half of the time of the start is lost, nothing of the way."""
    law = TimeLaw(0.0, 2.0, 1.0, 0.4, 0.3)
    assert law.at(0.0) == (0.0, 0.0, 0.0)
    assert law.at(0.3)[1] == pytest.approx(1.0)
    assert law.duration == pytest.approx(2.0 + 0.2 + 0.15)
    assert law.at(law.duration - 1e-9)[0] == pytest.approx(2.0)


def test_a_start_that_has_no_room_beside_the_stop_is_shortened() -> None:
    law = TimeLaw(0.0, 0.1, 1.0, 0.5, 0.3)
    assert law.at(0.0)[0] == pytest.approx(0.0)
    assert law.at(law.duration)[0] == 0.1


def test_it_comes_up_from_a_share_of_its_rate() -> None:
    law = TimeLaw(0.0, 2.0, 0.8, 0.4, 0.3, 0.5)
    assert law.at(0.0) == (0.0, pytest.approx(0.4), 0.0)
    assert law.at(0.3)[:2] == pytest.approx((0.8 * (0.3 - 0.5 * 0.5 * 0.3), 0.8))
    assert law.at(law.duration - 1e-9)[0] == pytest.approx(2.0)
    assert TimeLaw(0.0, 2.0, 0.8, 0.4, 0.3, 1.0).at(0.1) == TimeLaw(0.0, 2.0, 0.8, 0.4).at(0.1)
    assert TimeLaw(0.0, 0.1, 1.0, 0.5, 0.3, 0.5).at(0.0)[0] == pytest.approx(0.0)
