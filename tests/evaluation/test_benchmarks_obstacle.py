"""The benchmark of obstacles: the ball is kept off at rest and moving, and the tube's weights decide who gives way."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.evaluation.benchmarks import obstacle
from pft_exec.evaluation.protocol import silent

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def tables():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(obstacle, "PLACEMENTS", 2)
        patch.setattr(obstacle, "SPEEDS", (0.0, 0.1))
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


def test_wherever_a_ball_is_placed_and_however_it_moves_it_is_passed_within_the_tube(tables):
    for row in tables[3]:
        assert row["all floors kept %"] == 100.0
        assert row["distance mm, least"] >= 20.0
        assert row["off axis, largest"] <= 10.0
        assert row["end error, largest"] <= 4.0


def test_draws_without_room_come_to_an_end_and_are_counted(monkeypatch):
    """A ball that only just crosses the tube is drawn at last; where there never is room, an error says so."""
    from pft_exec.exceptions import InvalidSceneError
    from pft_exec.model import load_robot

    balls = obstacle._Round(load_robot("pr2").arm("right"))
    monkeypatch.setattr(balls, "has_room", lambda _: False)
    with pytest.raises(InvalidSceneError, match=f"{obstacle.DRAWS} balls"):
        balls.ball(0.1, np.random.default_rng(0))
    answers = iter([False, False, True])
    monkeypatch.setattr(balls, "has_room", lambda _: next(answers))
    ball, drawn = balls.ball(0.1, np.random.default_rng(0))
    assert drawn == 3
    assert np.linalg.norm(ball.velocity[:3]) == pytest.approx(0.1)


@pytest.mark.parametrize("has_room", [True, False])
def test_a_tube_has_room_round_a_ball_in_its_middle_and_none_where_the_ball_stays_at_its_end(has_room):
    from pft_exec.geometry import Pose
    from pft_exec.model import Obstacle, Sphere, load_robot

    balls = obstacle._Round(load_robot("pr2").arm("right"))
    ball = obstacle._ball(balls.tube.position[len(balls.tube) // 2], 0.0, balls.tube.time[-1])
    if not has_room:
        ball = Obstacle("ball", Sphere(obstacle.RADIUS), Pose(balls.tube.position[-1]))
    assert balls.has_room(ball) is has_room


def test_not_avoided_it_is_hit(tables):
    assert tables[-1][0]["distance mm"] < 0.0
