"""Curves: what a hand draws in one go has the shape that is asked for, and begins where it begins."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.description.curve import Circle, SCurve, Swing, tabulate_curve


@pytest.mark.parametrize(
    "curve",
    [
        Circle("circle", 0.04, 5.0, 9.0, angle=0.3, rise=0.02),
        Swing("swing", (0.0, 0.0, 2.0), (0.06, -0.06, 0.0), (0.25, 0.4, 0.3)),
        SCurve("s_curve", (0.09, 0.2), -1.0, 9.0),
    ],
)
def test_a_curve_is_relative_to_where_it_begins_and_rests_at_both_ends(curve) -> None:
    table = tabulate_curve(curve)
    assert np.allclose(table[0], 0.0, atol=1e-15)
    steps = np.linalg.norm(np.diff(table, axis=0), axis=1)
    assert max(steps[0], steps[-1]) < 0.02 * steps.max()


def test_a_circle_keeps_its_radius_about_a_centre_and_rises() -> None:
    circle = Circle("circle", 0.1, -2.0, 8.0, angle=0.5, rise=0.02)
    table = tabulate_curve(circle)
    center = -0.1 * np.array([np.cos(0.5), np.sin(0.5)])
    assert np.allclose(np.linalg.norm(table[:, :2] - center, axis=1), 0.1)
    assert np.allclose(table[-1], [0.0, 0.0, 0.02])
    angle = np.unwrap(np.arctan2(*(table[:, :2] - center).T[::-1]))
    assert angle[-1] - angle[0] == pytest.approx(-4.0 * np.pi)


def test_a_swing_reaches_each_offset_in_turn() -> None:
    swing = Swing("swing", (0.0, 0.0, 2.0), (0.06, -0.06, 0.0), (0.25, 0.4, 0.35))
    assert swing.duration == pytest.approx(1.0)
    assert np.allclose(swing.displacement([0.25, 0.65, 1.0])[:, 2], [0.06, -0.06, 0.0])


def test_an_s_curve_takes_one_side_and_then_the_other() -> None:
    table = tabulate_curve(SCurve("s_curve", (0.09, 0.2), 1.0, 9.0))
    assert table[-1, 1] == pytest.approx(-0.4)
    assert table[:, 0].max() == pytest.approx(0.09, abs=1e-4)
    assert np.argmax(table[:, 0]) < np.argmin(table[:, 0])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Circle("circle", 0.0, 1.0, 1.0), "must be above 0"),
        (lambda: Swing("swing", (0.0, 0.0, 1.0), (0.1,), (0.1, 0.2)), "as many durations as offsets"),
        (lambda: Swing("swing", (0.0, 0.0, 0.0), (0.1,), (0.1,)), "length of the direction"),
        (lambda: SCurve("s_curve", (0.1, 0.1), 0.5, 1.0), "sign must be 1 or -1"),
    ],
)
def test_what_is_no_curve_is_refused(make, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()
