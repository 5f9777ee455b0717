"""Assistance with objects: the robot works the gripper once it has the arm, takes a substitute, keeps off."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pft_exec.control import Avoidance
from pft_exec.demonstration import Scene
from pft_exec.exceptions import MissingObjectError, UnreachableError
from pft_exec.execution import assist, execute, prepare
from pft_exec.execution.hand.hand_path import lead_motion
from pft_exec.execution.refusal import refusal_here
from pft_exec.execution.surroundings import Surroundings
from pft_exec.geometry import Pose
from pft_exec.learning import MotionLibrary
from pft_exec.simulation import World
from tests.execution.test_grasping import TASK, _planned

LABELS = ("reach", "put_on_table", "move_left")
ASIDE, BESIDE = np.array([0.0, 0.20, 0.0]), 0.085
"""m; where a motion to the left ends, from where it began, and how far to the gripper's right a bottle is there."""
SWAP = {"bottle": "can"}


@pytest.fixture(scope="module")
def table() -> Iterator[World]:
    with World("pr2", TASK, seed=0, control_period=0.002) as opened:
        yield opened


@pytest.fixture(scope="module")
def motions(table: World) -> MotionLibrary:
    return MotionLibrary({label: _planned(table, label) for label in LABELS})


def test_a_hand_that_has_let_go_works_the_gripper_no_more(table: World) -> None:
    prepare(table, "reach", seed=0)
    hand = lead_motion(table, "reach", seed=0)
    hand.guide.let_go(0.5)
    hand.pull(hand.duration)
    assert not table.is_gripper_closed("right")


def test_the_gripper_closes_after_the_take_over_as_the_tube_says(table: World, motions: MotionLibrary) -> None:
    prepare(table, "reach", seed=0)
    log = assist(table, motions, "reach", seed=0)
    assert log.label == "reach"
    assert log.success, log.reason
    assert table.held() == "bottle"


def test_what_is_in_the_gripper_from_the_start_is_put_down_and_let_go(table: World, motions: MotionLibrary) -> None:
    prepare(table, "put_on_table", seed=1)
    assert table.held() == "bottle"
    log = assist(table, motions, "put_on_table", seed=1)
    assert log.label == "put_on_table"
    assert log.success, log.reason
    assert log.event("released").time > log.event("take_over").time


@pytest.mark.parametrize("label", ["reach", "put_on_table"])
def test_a_substitute_is_recognized_handled_and_judged_in_place_of_what_was_taught(
    table: World, motions: MotionLibrary, label: str
) -> None:
    prepare(table, label, seed=3, substitute=SWAP)
    log = assist(table, motions, label, seed=3, substitute=SWAP)
    assert log.label == label
    assert log.success, log.reason
    assert (table.held() == "can") is (label == "reach")


def test_a_substitute_that_is_not_there_is_refused(table: World, motions: MotionLibrary) -> None:
    prepare(table, "reach", seed=3)
    with pytest.raises(MissingObjectError, match="jug"):
        assist(table, motions, "reach", seed=3, substitute={"bottle": "jug"})


def test_the_arm_keeps_off_what_it_is_told_to_once_the_robot_has_it(table: World, motions: MotionLibrary) -> None:
    """A bottle beside the end of a motion to the left: the fingers would come nearer than the distance that is kept."""
    near = {told: _nearest(table, motions, told) for told in (False, True)}
    assert near[False] < 0.02
    assert near[True] > near[False] + 0.005


def _nearest(table: World, motions: MotionLibrary, is_told: bool) -> float:
    """Least distance, m, between the arm and a bottle held in the air beside the end of a motion to the left."""
    prepare(table, "move_left", seed=3)
    tool, bottle = table.tool(), table._contents.objects["bottle"]
    beside = Pose(tool.position + ASIDE + BESIDE * np.array([tool.rotation[1, 0], -tool.rotation[0, 0], 0.0]))
    bottle.place(beside)
    eyes, witness, least = Surroundings(table, "right", ["bottle"], other_arms=False), Avoidance(table.arm(), False), []

    def look(now: World) -> None:
        bottle.place(beside)
        witness.watch(eyes.look(), 0.0)
        near = witness.near(now.arm(), *now.true_state("right"), 0.0)
        least.append(np.inf if near is None else float(near.distance.min()))

    log = assist(table, motions, "move_left", seed=3, avoid=["bottle"] if is_told else (), observer=look)
    assert log.label == "move_left"
    return min(least)


def test_what_is_out_of_reach_is_refused_with_the_nearest_placement_before_anything_moves(
    table: World, motions: MotionLibrary
) -> None:
    prepare(table, "reach", seed=3, substitute=SWAP)
    standing = dict(table.scene.objects)
    away = standing["can"].position + np.array([0.25, -0.6, 0.0])
    table.reset(Scene({**standing, "can": Pose(away)}), {"right": table.state("right")[0]})
    tube, before = motions["reach"].flow_tube(table.scene, table.tool(), SWAP), table.time
    with pytest.raises(UnreachableError, match=r"beyond the reach .* nearest placement found that will do: can at \("):
        execute(table, tube, substitute=SWAP)
    with pytest.raises(UnreachableError, match=r"'reach'.* nearest placement found that will do: can at \("):
        assist(table, motions, "reach", substitute=SWAP)
    assert table.time == before


def test_where_the_placement_is_not_at_fault_no_other_is_told(table: World) -> None:
    prepare(table, "reach", seed=3)
    assert str(refusal_here(table, "reach", "right", "The tube is too long.")) == "The tube is too long."
    assert str(refusal_here(table, "unheard of", "right", "The tube is too long.")) == "The tube is too long."


def test_an_object_that_the_task_has_not_cannot_be_avoided(table: World, motions: MotionLibrary) -> None:
    prepare(table, "move_left", seed=3)
    with pytest.raises(MissingObjectError, match="jug"):
        assist(table, motions, "move_left", seed=3, avoid=["jug"])
