"""The nine motions with the bottle can be made by the PR2 on either side, and what they relate to can be found."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.demonstration.synthetic import STEADY, human_path
from pft_exec.description import Setting, draw_scene, draw_settings, load_task, random_stream, resolve_waypoints
from pft_exec.evaluation.measurements import found_relations
from pft_exec.exceptions import UnreachableError
from pft_exec.execution.hand.hand_path import plan_hand_paths
from pft_exec.geometry import Array, Pose
from pft_exec.learning import learn_motion
from pft_exec.simulation import World

TASK = load_task("bottle")
LABELS = ("move_left", "up_and_over", "go_home", "pour_into", "pour_done", "reach", "put_on_table", "shake", "stir")


def _path(label: str, setting: Setting, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Time, position and orientation of a person's hand in the last motion of a chain."""
    start = setting.start
    for part in TASK.chain(label):
        ways = resolve_waypoints(TASK, part, Scene(setting.objects), start)
        path = human_path(
            ways.positions,
            ways.quaternions,
            ways.durations,
            rng,
            rests=ways.rests,
            curve=ways.curve,
            curve_duration=ways.curve_duration,
        )
        time, position, quaternion = path.sample(0.02)
        start = Pose(position[-1], quaternion[-1])
    return time, position, quaternion


def _demonstration(label: str, setting: Setting, rng: np.random.Generator) -> Demonstration:
    time, position, quaternion = _path(label, setting, rng)
    objects = {name: pose.array for name, pose in setting.objects.items()}
    held = [TASK.motion(part).holds for part in TASK.chain(label)]
    for holds in (each for each in held if each is not None):
        objects[holds.object] = np.array(
            [(Pose(p, q) @ holds.grip).array for p, q in zip(position, quaternion, strict=True)]
        )
    return Demonstration(label, time, position, quaternion, objects=objects)


def test_the_nine_motions_are_those_of_the_paper() -> None:
    assert TASK.labels == LABELS


@pytest.mark.parametrize("label", LABELS)
def test_what_a_motion_relates_to_is_found_in_what_a_person_shows(label: str) -> None:
    settings = draw_settings(TASK, label, 5, random_stream(0, "teach", label, "tests"))
    shown = [
        _demonstration(label, setting, random_stream(k, "teach", label, "hand")) for k, setting in enumerate(settings)
    ]
    assert found_relations({label: learn_motion(shown)}, label) == TASK.relations(label)


@pytest.mark.parametrize("arm", ["right", "left"])
def test_most_drawn_scenes_can_be_worked_in(arm: str) -> None:
    scene = Scene(draw_scene(TASK, np.random.default_rng(0)))
    with World("pr2", TASK, scene) as world:
        for label in LABELS:
            rng = random_stream(3, "evaluate", label)
            feasible = 0
            for setting in draw_settings(world.task_for(arm), label, 6, rng):
                try:
                    plan_hand_paths(world, label, arm, setting, rng, STEADY)
                    feasible += 1
                except UnreachableError:
                    continue
            assert feasible >= 4, label


def test_a_gripped_bottle_has_its_lip_where_the_pouring_says() -> None:
    """The lip's distance from the grip is what the waypoint aims."""
    bottle, holds = TASK.objects["bottle"].shape, TASK.motion("pour_into").holds
    aim = TASK.motion("pour_into").waypoints[-1].position.aim
    assert aim[2] == pytest.approx(holds.position[2] + 0.5 * bottle.height)
