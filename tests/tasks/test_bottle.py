"""The nine motions with the bottle can be made by the PR2 on either side, and are those of the paper."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.demonstration import Scene
from pft_exec.demonstration.synthetic import STEADY
from pft_exec.description import draw_scene, draw_settings, load_task, random_stream
from pft_exec.exceptions import UnreachableError
from pft_exec.execution.hand.hand_path import plan_hand_paths
from pft_exec.simulation import World

TASK = load_task("bottle")
LABELS = ("move_left", "up_and_over", "go_home", "pour_into", "pour_done", "reach", "put_on_table", "shake", "stir")


def test_the_nine_motions_are_those_of_the_paper() -> None:
    assert TASK.labels == LABELS


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
