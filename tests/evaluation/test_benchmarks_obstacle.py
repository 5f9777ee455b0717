"""The benchmark of obstacles: the ball is kept off at rest and moving, and the tube's weights decide who gives way."""

from __future__ import annotations

import pytest

from pft_exec.evaluation.benchmarks import obstacle
from pft_exec.evaluation.protocol import silent

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def tables():
    return list(obstacle.measure_obstacle(0, silent).values())


def test_the_ball_is_kept_off_and_the_way_round_is_where_the_tube_is_wide(tables):
    for rows in tables[:3]:
        assert rows[0]["distance mm"] >= 20.0
        assert rows[0]["off axis mm"] <= 10.0
        assert rows[0]["end error mm"] <= 4.0
        assert rows[0]["torque share"] <= 1.0


def test_equal_weights_give_way_in_the_narrow_directions(tables):
    for rows in tables[:3]:
        assert rows[3]["off axis mm"] > 2.0 * rows[0]["off axis mm"]


def test_not_avoided_it_is_hit(tables):
    assert tables[-1][0]["distance mm"] < 0.0
