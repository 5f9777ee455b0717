"""Verdicts on the tool's course: each holds for the course that was taught and fails for one that is not it."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.description.course import (
    judge_anchored,
    judge_shaken,
    judge_stirred,
    judge_wound,
    reversals,
    winding,
)
from pft_exec.description.curve import Circle, SCurve, Swing, tabulate_curve
from pft_exec.description.predicates import Anchored, AnchorPassed, Shaken, Stirred, Wound
from pft_exec.geometry import Pose

CUP = {"cup": Pose(np.array([0.6, -0.15, 0.75]))}
STIRRED = Stirred("cup", (-0.04, 0.0, 0.0), 0.04, 5.0)
SHAKEN = Shaken((0.0, 0.0, 1.0), 0.06, 4)
WOUND = Wound("cup", 2.0, (0.05, 0.15))


def _stir(radius: float = 0.04, turns: float = 5.0, aside: float = 0.0) -> np.ndarray:
    return CUP["cup"].position + np.array([aside, 0.0, 0.19]) + tabulate_curve(Circle("circle", radius, turns, 9.0))


def _shake(amplitude: float, count: int = 4) -> np.ndarray:
    offsets = tuple(amplitude * (-1.0) ** k for k in range(count))
    return tabulate_curve(Swing("swing", (0.0, 0.0, 1.0), (*offsets, 0.0), (0.4,) * (count + 1)))


def test_five_turns_about_the_cup_are_stirring() -> None:
    assert judge_stirred(STIRRED, CUP, _stir()).success
    approach = np.linspace([0.5, -0.3, 1.0], _stir()[0], 200)
    assert judge_stirred(STIRRED, CUP, np.concatenate([approach, _stir()])).success


@pytest.mark.parametrize(
    "path",
    [_stir(turns=-5.0), _stir(turns=4.0), _stir(radius=0.03), _stir(radius=0.05), _stir(aside=0.03), np.zeros((0, 3))],
    ids=["wrong sense", "too few turns", "too small", "too wide", "beside the cup", "nothing"],
)
def test_what_is_not_stirring(path) -> None:
    assert not judge_stirred(STIRRED, CUP, path).success


def test_stirring_there_and_back_is_not_one_sense() -> None:
    there = _stir(turns=7.0)
    assert not judge_stirred(STIRRED, CUP, np.concatenate([there, there[::-1][: len(there) // 3]])).success


def test_shaking_counts_reversals_and_their_size() -> None:
    assert judge_shaken(SHAKEN, _shake(0.06)).success
    assert not judge_shaken(SHAKEN, _shake(0.03)).success
    assert not judge_shaken(SHAKEN, _shake(0.06, count=3)).success
    assert not judge_shaken(SHAKEN, _shake(0.06, count=6)).success


def test_tremor_makes_no_reversal() -> None:
    rng = np.random.default_rng(0)
    assert judge_shaken(SHAKEN, _shake(0.06) + 5e-4 * rng.standard_normal((401, 3))).success
    assert len(reversals(1e-3 * rng.standard_normal(500), 0.02)) == 0


def test_winding_counts_turns_with_their_sense() -> None:
    circle = tabulate_curve(Circle("circle", 0.1, 2.0, 8.0))[:, :2]
    assert winding(circle, np.array([-0.1, 0.0])) == (pytest.approx(2.0), pytest.approx(0.0, abs=1e-9))
    assert winding(circle[::-1], np.array([-0.1, 0.0]))[0] == pytest.approx(-2.0)
    assert winding(circle, np.array([0.5, 0.0]))[0] == pytest.approx(0.0, abs=1e-9)


def test_wound_about_the_post_and_not_beside_it_or_the_other_way() -> None:
    post = CUP["cup"].position
    path = post + np.array([0.1, 0.0, 0.2]) + tabulate_curve(Circle("circle", 0.1, 2.0, 8.0))
    assert judge_wound(WOUND, CUP, path).success
    assert not judge_wound(WOUND, CUP, path[::-1]).success
    assert not judge_wound(WOUND, CUP, path + np.array([0.3, 0.0, 0.0])).success
    assert not judge_wound(WOUND, CUP, post + 2.0 * (path - post)).success


def test_anchors_are_passed_in_order_each_on_its_side() -> None:
    anchors = tuple(AnchorPassed((0.0, y, 0.0), side) for y, side in ((0.1, 1.0), (-0.1, -1.0)))
    limits = Anchored("cup", anchors)
    path = CUP["cup"].position + np.array([0.0, 0.2, 0.1]) + tabulate_curve(SCurve("s_curve", (0.09, 0.2), 1.0, 9.0))
    assert judge_anchored(limits, CUP, path).success
    mirrored = CUP["cup"].position + (path - CUP["cup"].position) * [-1.0, 1.0, 1.0]
    for wrong in (mirrored, path[::-1], path[:100]):
        assert not judge_anchored(limits, CUP, wrong).success
