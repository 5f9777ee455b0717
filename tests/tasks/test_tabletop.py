"""The tabletop task can be done by the PR2 on either side, and its motions can be told apart."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.assets import task_names
from pft_exec.demonstration.synthetic import human_path
from pft_exec.description import draw_setting, draw_settings, load_task, nominal_goal, random_stream, resolve_waypoints
from pft_exec.geometry import multiply
from pft_exec.model import follow_path, load_robot

LABELS = ("reach", "put_on_table", "move_left", "go_home")


@pytest.fixture(scope="module")
def robot():
    return load_robot("pr2")


@pytest.mark.parametrize("name", task_names())
def test_every_task_loads_and_its_folder_is_complete(name: str) -> None:
    task = load_task(name)
    assert task.name == name
    assert (task.folder / "README.md").is_file()
    text = (task.folder / "README.md").read_text(encoding="utf-8")
    assert all(f"`{label}`" in text for label in task.labels)


@pytest.mark.parametrize("name", task_names())
def test_no_task_names_a_robot(name: str) -> None:
    text = (load_task(name).folder / "task.toml").read_text(encoding="utf-8").lower()
    assert not any(word in text for word in ("pr2", "wam", "joint"))


@pytest.mark.parametrize("name", task_names())
def test_relations_are_those_of_the_last_waypoint(name: str) -> None:
    """What a motion is said to obey is what its demonstrators are led by."""
    task = load_task(name)
    for label in task.labels:
        if not task.motion(label).waypoints:
            continue  # a curve alone ends relative to where it begins
        relations = task.relations(label)
        position, orientation = task.motion(label).waypoints[-1].frames
        words = {"world": "absolute"}
        assert relations["end.position"] == words.get(position, position)
        assert relations["end.orientation"] == words.get(orientation, orientation)


def test_ranges_are_wide_enough_to_tell_a_displacement_from_a_place() -> None:
    task = load_task("tabletop")
    assert min(high - low for low, high in (task.start.x, task.start.y, task.start.z)) >= 0.1 - 1e-12
    for name in task.placed:
        placement = task.objects[name].placement
        assert min(high - low for low, high in (placement.x, placement.y)) >= 0.08


def test_objects_stand_on_the_table_and_not_over_its_edge() -> None:
    task = load_task("tabletop")
    table = task.objects["table"]
    near_edge = table.fixed.position[0] - 0.5 * table.shape.size[0]
    for name in task.placed:
        item = task.objects[name]
        assert item.placement.x[0] - item.shape.outline > near_edge - 1e-9


@pytest.mark.parametrize("arm", ["right", "left"])
@pytest.mark.parametrize("label", LABELS)
def test_the_arm_follows_every_drawn_path_with_room_at_its_limits(robot, arm: str, label: str) -> None:
    task = load_task("tabletop") if arm == "right" else load_task("tabletop").mirrored()
    model = robot.arm(arm)
    back = task.robot_base.inverse()
    rng = random_stream(11, "evaluate", label)
    for _ in range(25):
        setting = draw_setting(task, label, rng)
        waypoints = resolve_waypoints(task, label, setting.objects, setting.start)
        path = human_path(waypoints.positions, waypoints.quaternions, waypoints.durations, rng)
        time, positions, quaternions = path.sample(0.05)
        joints = follow_path(
            model, back.apply(positions), multiply(back.quaternion, quaternions), model.configuration("teach")
        )
        assert joints.found
        assert joints.limit_margin > 0.1
        assert joints.manipulability > 0.04
        speed = np.abs(np.diff(joints.samples, axis=0)) / np.diff(time)[:, None]
        assert (speed < 0.5 * model.limits.velocity).all()


def test_goals_of_different_motions_lie_apart() -> None:
    task = load_task("tabletop")
    rng = random_stream(1, "evaluate", "apart")
    distances = []
    for _ in range(200):
        setting = draw_setting(task, "reach", rng)
        goals = [nominal_goal(task, label, setting.objects, setting.start).position for label in LABELS]
        distances.append([np.linalg.norm(goals[i] - goals[j]) for i in range(4) for j in range(i)])
    assert np.min(distances) > 0.1
    assert np.mean(distances, axis=0).min() > 0.15


def test_motions_part_before_sixty_percent_on_average() -> None:
    """By then the mean distance between steady paths from one start is well above what a hand scatters."""
    from pft_exec.demonstration.synthetic import STEADY

    task = load_task("tabletop")
    rng = random_stream(2, "evaluate", "apart")
    nearest = []
    for setting in draw_settings(task, "reach", 20, rng):
        at = []
        for label in LABELS:
            w = resolve_waypoints(task, label, setting.objects, setting.start)
            path = human_path(w.positions, w.quaternions, w.durations, rng, STEADY)
            at.append(path.at(0.5 * path.duration)[0])
        nearest.append(min(np.linalg.norm(at[i] - at[j]) for i in range(4) for j in range(i)))
    assert np.mean(nearest) > 0.04
