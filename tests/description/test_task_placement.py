"""Scenes and starts drawn from a task: within their ranges, clear, spread, reproducible, and mirrored as a whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.demonstration import Scene
from pft_exec.description import (
    TaskDescription,
    draw_scene,
    draw_setting,
    draw_settings,
    hand_clearance,
    load_task,
    nominal_goal,
    nominal_setting,
    object_clearance,
    path_is_free,
    random_stream,
    resolve_waypoints,
    workspace_excess,
)
from pft_exec.exceptions import MissingObjectError, UnknownMotionError, UnreachableError
from pft_exec.geometry import Pose, geodesic_distance, multiply

LABELS = ("reach", "put_on_table", "move_left", "go_home")


@pytest.fixture(scope="module")
def task() -> TaskDescription:
    return load_task("tabletop")


def test_drawn_objects_stand_on_the_table_within_their_ranges_and_clear_of_one_another(task: TaskDescription) -> None:
    rng = random_stream(0, "evaluate")
    for _ in range(50):
        objects = draw_scene(task, rng)
        assert tuple(objects) == task.placed
        assert object_clearance(task, objects) >= task.clearance.objects
        for name, pose in objects.items():
            item = task.objects[name]
            assert item.placement.x[0] <= pose.position[0] <= item.placement.x[1]
            assert item.placement.y[0] <= pose.position[1] <= item.placement.y[1]
            assert pose.position[2] == pytest.approx(0.70 + 0.5 * item.shape.height, abs=1e-12)


def test_drawn_starts_lie_in_their_ranges_and_turn_no_further_than_stated(task: TaskDescription) -> None:
    rng = random_stream(0, "evaluate")
    start = task.start_of("reach")
    for _ in range(50):
        pose = draw_setting(task, "reach", rng).start
        for value, (least, greatest) in zip(pose.position, (start.x, start.y, start.z), strict=True):
            assert least <= value <= greatest
        assert geodesic_distance(start.quaternion, pose.quaternion) <= np.linalg.norm(start.turned) + 1e-12


@pytest.mark.parametrize("label", LABELS)
def test_five_draws_spread_starts_by_6_cm_and_objects_by_7_cm(task: TaskDescription, label: str) -> None:
    """Otherwise a displacement would look like a place."""
    for seed in range(5):
        settings = draw_settings(task, label, 5, random_stream(seed, "teach", label))
        starts = np.array([setting.start.position for setting in settings])
        assert np.ptp(starts, axis=0).min() >= 0.06
        for name in task.placed:
            places = np.array([setting.objects[name].position[:2] for setting in settings])
            assert np.ptp(places, axis=0).min() >= 0.07


@pytest.mark.parametrize("label", LABELS)
def test_the_path_of_every_setting_is_free(task: TaskDescription, label: str) -> None:
    for setting in draw_settings(task, label, 5, random_stream(3, "teach", label)):
        assert path_is_free(task, label, setting)


def test_the_same_stream_gives_the_same_settings(task: TaskDescription) -> None:
    first, second = (draw_settings(task, "reach", 3, random_stream(7, "teach", "reach")) for _ in range(2))
    assert first == second


def test_what_is_refused_is_drawn_again(task: TaskDescription) -> None:
    middle = 0.5 * sum(task.start.x)
    accept = lambda setting: setting.start.position[0] < middle  # noqa: E731
    assert draw_setting(task, "reach", random_stream(0, "evaluate"), accept).start.position[0] < middle


def test_settings_that_nobody_accepts_are_refused_with_advice(task: TaskDescription) -> None:
    with pytest.raises(UnreachableError, match="'reach' can be made; widen the ranges"):
        draw_settings(task, "reach", 2, random_stream(0, "teach"), lambda _: False)
    with pytest.raises(UnreachableError, match="widen the ranges"):
        draw_setting(task, "reach", random_stream(0, "teach"), lambda _: False)


def test_a_scene_without_room_is_refused(task: TaskDescription) -> None:
    crowded = replace(task, clearance=replace(task.clearance, objects=5.0))
    with pytest.raises(UnreachableError, match="no placement found"):
        draw_scene(crowded, random_stream(0, "evaluate"))


@pytest.mark.parametrize("label", LABELS)
def test_the_mirrored_task_draws_and_resolves_the_mirror_image(task: TaskDescription, label: str) -> None:
    plane = Pose(np.array([0.1, 0.2, 0.0]), np.array([0.0, 0.0, np.sin(0.2), np.cos(0.2)]))
    right, left = task, task.mirrored(plane)
    ours = draw_setting(right, label, random_stream(1, "evaluate"))
    theirs = draw_setting(left, label, random_stream(1, "evaluate"))
    assert Scene(ours.objects).mirrored(plane).objects == theirs.objects
    goal = nominal_goal(left, label, Scene(theirs.objects), theirs.start)
    expected = nominal_goal(right, label, Scene(ours.objects), ours.start).mirrored(plane)
    np.testing.assert_allclose(goal.position, expected.position, atol=1e-12)
    assert geodesic_distance(goal.quaternion, expected.quaternion) < 1e-7


def test_reach_ends_012_m_short_of_the_bottle_along_the_gripper(task: TaskDescription) -> None:
    setting = draw_setting(task, "reach", random_stream(2, "evaluate"))
    goal = nominal_goal(task, "reach", setting.objects, setting.start)
    beyond = goal.apply(np.array([0.12, 0.0, 0.0]))
    np.testing.assert_allclose(beyond[:2], setting.objects["bottle"].position[:2], atol=1e-4)


def test_put_on_table_turns_with_the_mat(task: TaskDescription) -> None:
    setting = draw_setting(task, "put_on_table", random_stream(2, "evaluate"))
    goal = nominal_goal(task, "put_on_table", setting.objects, setting.start)
    nominal = task.motion("put_on_table").waypoints[-1].orientation.quaternion
    assert geodesic_distance(goal.quaternion, multiply(setting.objects["mat"].quaternion, nominal)) < 1e-7


def test_move_left_keeps_its_start(task: TaskDescription) -> None:
    setting = draw_setting(task, "move_left", random_stream(2, "evaluate"))
    waypoints = resolve_waypoints(task, "move_left", setting.objects, setting.start)
    np.testing.assert_allclose(waypoints.positions[-1] - waypoints.positions[0], [0.0, 0.2, 0.0], atol=1e-12)
    assert waypoints.end == Pose(waypoints.positions[-1], waypoints.quaternions[-1])


def test_the_nominal_start_is_mirrored_with_the_task(task: TaskDescription) -> None:
    start = nominal_setting(task, "reach", {}).start
    assert nominal_setting(task.mirrored(), "reach", {}).start == start.mirrored(task.robot_base)


def test_a_scene_without_an_object_of_the_motion_is_refused(task: TaskDescription) -> None:
    start = draw_setting(task, "reach", random_stream(0, "evaluate")).start
    with pytest.raises(MissingObjectError, match="'bottle'"):
        resolve_waypoints(task, "reach", Scene({}), start)
    with pytest.raises(UnknownMotionError):
        resolve_waypoints(task, "wave", Scene({}), start)


def test_clearances_of_figures_that_are_known(task: TaskDescription) -> None:
    objects = {"bottle": Pose(np.array([0.6, 0.0, 0.8])), "cup": Pose(np.array([0.6, 0.2, 0.75]))}
    assert object_clearance(task, objects) == pytest.approx(0.2 - 0.03 - 0.04)
    assert object_clearance(task, {}) == np.inf
    hand = task.clearance.hand
    above = np.array([[0.6, 0.0, 1.0]])
    upright = np.array([[0.0, 0.0, 0.0, 1.0]])
    assert hand_clearance(task, objects, above, upright) == pytest.approx(0.1 - hand.radius)
    inside = hand_clearance(task, objects, np.array([[0.6, 0.0, 0.8]]), upright)
    assert inside < -hand.radius
    assert hand_clearance(task, {}, above, upright) == np.inf


def test_the_workspace_is_measured_and_mirrored(task: TaskDescription) -> None:
    beyond = np.array([[0.5, -0.3, 1.0], [0.5, -0.75, 1.0]])
    assert workspace_excess(task, beyond) == pytest.approx(0.05)
    assert workspace_excess(task, beyond[:1]) == 0.0
    assert workspace_excess(task.mirrored(), beyond * [1.0, -1.0, 1.0]) == pytest.approx(0.05)


def test_a_path_out_of_the_workspace_is_not_free(task: TaskDescription) -> None:
    setting = draw_setting(task, "move_left", random_stream(2, "evaluate"))
    narrow = replace(task, workspace=replace(task.workspace, y=(-0.7, -0.3)))
    assert path_is_free(task, "move_left", setting)
    assert not path_is_free(narrow, "move_left", setting)


def test_where_objects_are_given_only_the_start_is_drawn(task: TaskDescription) -> None:
    objects = draw_scene(task, random_stream(4, "evaluate"))
    settings = draw_settings(task, "reach", 3, random_stream(4, "teach"), objects=objects)
    assert all(setting.objects == objects for setting in settings)
    assert len({tuple(setting.start.position) for setting in settings}) == 3


def test_what_is_taught_and_what_is_evaluated_share_no_scene(task: TaskDescription) -> None:
    """Streams of different purposes differ for every pair of seeds, also for the same seed."""
    taught = {
        tuple(np.round(setting.objects["bottle"].position, 9))
        for seed in range(10)
        for label in LABELS
        for setting in draw_settings(task, label, 5, random_stream(seed, "teach", label))
    }
    evaluated = {
        tuple(np.round(draw_scene(task, random_stream(seed, "evaluate", number))["bottle"].position, 9))
        for seed in range(10)
        for number in range(20)
    }
    assert len(taught) == 10 * len(LABELS) * 5
    assert len(evaluated) == 200
    assert not taught & evaluated


def test_streams_depend_on_each_key_and_its_kind() -> None:
    draws = [
        random_stream(*keys).random()
        for keys in ((0, "teach"), (1, "teach"), (0, "evaluate"), (0, "teach", "1"), (0, "teach", 1))
    ]
    assert len(set(draws)) == len(draws)
