"""An object that is lost or jumps keeps its pose; one that stays away is believed there, unless the tool took it."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.demonstration import Scene
from pft_exec.execution.scene_watch import SETTLED_TIME, TOUCH, SceneWatch
from pft_exec.geometry import Pose

HOME, AWAY = Pose(np.array([0.5, 0.0, 0.8])), Pose(np.array([0.5, 0.15, 0.8]))
TOOL = Pose(np.array([-0.5, 0.0, 1.5]))
BALL = Pose(np.array([0.5, 0.5, 0.8]))


@pytest.fixture
def watch() -> SceneWatch:
    return SceneWatch(Scene({"cup": HOME, "ball": BALL}))


def seen(cup: Pose | None = HOME) -> Scene:
    return Scene({"ball": BALL} if cup is None else {"cup": cup, "ball": BALL})


def test_a_scene_that_stays_changes_nothing(watch: SceneWatch) -> None:
    shaken = Pose(HOME.position + 0.001)
    assert all(watch.update(0.01 * k, seen(shaken), TOOL) is None for k in range(100))


def test_a_lost_object_stands_where_it_was(watch: SceneWatch) -> None:
    assert all(watch.update(0.01 * k, seen(None), TOOL) is None for k in range(100))
    assert watch.scene["cup"] == HOME


def test_a_pose_that_jumps_for_a_moment_is_not_believed(watch: SceneWatch) -> None:
    assert all(watch.update(0.01 * k, seen(AWAY if 10 <= k < 25 else HOME), TOOL) is None for k in range(60))


def test_a_pose_that_jumps_about_is_never_believed(watch: SceneWatch) -> None:
    places = (AWAY, Pose(np.array([0.6, 0.15, 0.8])))
    assert all(watch.update(0.01 * k, seen(places[k % 2]), TOOL) is None for k in range(100))


def test_an_object_that_stays_elsewhere_was_moved(watch: SceneWatch) -> None:
    assert watch.update(0.0, seen(AWAY), TOOL) is None
    assert watch.update(0.5 * SETTLED_TIME, seen(AWAY), TOOL) is None
    moved = watch.update(SETTLED_TIME, seen(AWAY), TOOL)
    assert moved is not None
    assert moved["cup"] == AWAY
    assert moved["ball"] == BALL
    assert watch.update(2.0 * SETTLED_TIME, seen(AWAY), TOOL) is None


def test_what_the_tool_carries_belongs_to_the_motion(watch: SceneWatch) -> None:
    near = Pose(AWAY.position + np.array([0.0, 0.0, 0.5 * TOUCH]))
    assert watch.update(0.0, seen(AWAY), near) is None
    assert all(watch.update(0.01 * k, seen(AWAY), TOOL) is None for k in range(100))
