"""A figure says whether its floor is reached; what could not be measured never is."""

from __future__ import annotations

import math

import pytest

from pft_exec.evaluation.figures import Figure, figures_to_dict, share, wilson_interval, worst


@pytest.mark.parametrize(
    ("value", "bound", "reached"),
    [
        (1.0, "at most", True),
        (1.1, "at most", False),
        (1.0, "at least", True),
        (0.9, "at least", False),
        (math.nan, "at most", False),
        (math.nan, "at least", False),
    ],
)
def test_a_floor_is_reached_on_its_own_side_only(value: float, bound: str, reached: bool) -> None:
    assert Figure(value, 1.0, "mm", bound).ok is reached


def test_what_could_not_be_measured_is_null_in_json() -> None:
    written = figures_to_dict({"force": Figure(math.nan, 15.0, "N")})
    assert written == {"force": {"value": None, "floor": 15.0, "unit": "N", "bound": "at most", "ok": False}}


def test_nothing_measured_has_neither_a_worst_nor_a_share() -> None:
    assert math.isnan(worst([]))
    assert math.isnan(share([]))
    assert share([True, False, False, False]) == 25.0


def test_the_wilson_interval_agrees_with_published_values() -> None:
    """81 of 263: 25.5 to 36.6 % (Newcombe 1998, Statistics in Medicine 17, table I, method 3); 0 of 20: 0 to 16.1 %."""
    low, high = wilson_interval(81, 263)
    assert low == pytest.approx(25.53, abs=0.01)
    assert high == pytest.approx(36.62, abs=0.01)
    assert wilson_interval(0, 20) == pytest.approx((0.0, 16.11), abs=0.01)
    assert wilson_interval(0, 0) == (0.0, 100.0)
