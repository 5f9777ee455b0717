"""What is held belongs to the arm's model, the gripper is worked as the tube says, and what cannot be is refused."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.description import draw_scene, draw_settings, load_task, random_stream
from pft_exec.exceptions import MissingObjectError, UnreachableError
from pft_exec.execution import ControlLoop, execute, prepare, teach
from pft_exec.execution.grasping import GRIPPER_CLOSED, GripperReplay, GripperWait, handles_objects
from pft_exec.execution.hand.hand_path import Hand, plan_hand_paths
from pft_exec.execution.preparation import trade_places
from pft_exec.execution.pursuit import Instant
from pft_exec.geometry import Pose, quaternion_from_rotation_vector
from pft_exec.learning import Motion, learn_motion
from pft_exec.simulation import World

TASK = load_task("bottle")


@pytest.fixture(scope="module")
def table() -> Iterator[World]:
    with World("pr2", TASK, Scene(draw_scene(TASK, np.random.default_rng(0))), seed=0) as opened:
        yield opened


def _planned(world: World, label: str) -> Motion:
    """A motion learned from what the hand wants, gripper included."""
    rng = random_stream(0, "teach", label, "tests of grasping")
    demonstrations = []
    for setting in draw_settings(TASK, label, 5, rng):
        plan = plan_hand_paths(world, label, "right", setting, rng)[-1]
        time = np.arange(0.0, plan.duration, 0.01)
        closed = np.full(len(time), int(not TASK.motion(label).begins_open))
        for when, what in plan.grips:
            closed[time >= when] = int(what == "close")
        objects = {name: pose.array for name, pose in setting.objects.items()}
        position, quaternion = plan.at(time)
        demonstrations.append(
            Demonstration(label, time, position, quaternion, discrete={GRIPPER_CLOSED: closed}, objects=objects)
        )
    return learn_motion(demonstrations)


@pytest.fixture(scope="module")
def reach(table: World) -> Motion:
    return _planned(table, "reach")


@pytest.mark.parametrize("arm", ["right", "left"])
def test_reach_closes_at_its_end_and_holds_the_bottle(table: World, reach: Motion, arm: str) -> None:
    motion = reach if arm == "right" else reach.mirrored(TASK.robot_base)
    prepare(table, "reach", arm, seed=0)
    assert not table.is_gripper_closed(arm)
    assert table.held(arm) is None
    log = execute(table, motion.flow_tube(table.scene, table.tool(arm)), arm)
    assert log.success, log.reason
    assert table.held(arm) == "bottle"
    assert (np.abs(log.torque) <= table.arm(arm).limits.torque + 1e-9).all()


def test_what_is_held_when_a_run_begins_is_in_the_model_and_leaves_it_when_let_go(table: World) -> None:
    prepare(table, "shake", seed=0)
    loop = ControlLoop(table)
    bare, q = table.arm(), loop.sense()[0]
    weight = np.linalg.norm(loop.arm.gravity(q) - bare.gravity(q))
    assert weight > 1.0
    table.grip("right", closed=False)
    for _ in range(200):
        table.step()
        loop.handling.update()
    assert loop.handling.held is None
    assert loop.arm is bare
    assert loop.handling.measured().held is None


def test_slip_counts_from_where_the_object_was_grasped(table: World) -> None:
    prepare(table, "shake", seed=0)
    loop = ControlLoop(table)
    loop.handling.update()
    assert loop.handling.measured().slip < 1e-4
    pose = table.scene["bottle"]
    table._contents.objects["bottle"].place(Pose(pose.position + np.array([0.0, 0.0, 0.005]), pose.quaternion))
    loop.handling.update()
    assert loop.handling.measured().slip == pytest.approx(0.005, abs=1e-4)


@pytest.mark.parametrize("about", ["the pads", "its middle"])
def test_what_turns_in_the_gripper_slips_wherever_it_turns_about(table: World, about: str) -> None:
    prepare(table, "shake", seed=0)  # held 30 mm above its middle
    loop = ControlLoop(table)
    pose, tool, angle = table.scene["bottle"], table.true_tool(), 0.2
    center = tool.position if about == "the pads" else pose.position
    turn = Pose(np.zeros(3), quaternion_from_rotation_vector(angle * tool.rotation[:, 1]))
    there = Pose(center) @ turn @ Pose(-center) @ pose
    table._contents.objects["bottle"].place(there)
    loop.handling.update()
    assert loop.handling.slip == pytest.approx(2.0 * 0.03 * np.sin(0.5 * angle), abs=5e-4)
    assert loop.handling.turned == pytest.approx(angle, abs=2e-3)


def test_the_gripper_is_told_at_the_phase_of_the_event_and_the_reference_waits(table: World, reach: Motion) -> None:
    prepare(table, "reach", seed=0)
    tube = reach.flow_tube(table.scene, table.tool())
    (event,) = tube.events()
    replay, wait = GripperReplay(table, "right", tube), GripperWait(table, "right")
    assert not table.is_gripper_closed()
    replay(_at(event.phase - 0.01))
    assert not table.is_gripper_closed()
    assert wait(_at(0.5)).rate == 1.0
    replay(_at(event.phase))
    assert table.is_gripper_closed()
    assert wait(_at(event.phase)).rate == 0.0
    for _ in range(1000):
        table.step()
        done = wait(_at(event.phase)).rate == 1.0
    assert done


def test_a_pursuit_that_begins_late_does_not_work_off_what_is_past(table: World, reach: Motion) -> None:
    prepare(table, "shake", seed=0)
    GripperReplay(table, "right", reach.flow_tube(table.scene, table.tool()), phase=1.0)
    assert table.is_gripper_closed()
    assert table.held() == "bottle"


class _Command:
    def __init__(self, phase: float) -> None:
        self.phase = phase


def _at(phase: float) -> Instant:
    return Instant(0.0, 0.0, 0, np.zeros(7), np.zeros(7), _Command(phase))  # type: ignore[arg-type]


def test_a_demonstration_says_when_the_gripper_closed(table: World) -> None:
    (demonstration,) = teach(table, "reach", count=1)
    closed = demonstration.discrete[GRIPPER_CLOSED]
    assert closed[0] == 0
    assert closed[-1] == 1
    width = demonstration.continuous["gripper"]
    assert width[0] == pytest.approx(0.086, abs=1e-3)
    assert width[-1] == pytest.approx(0.06, abs=2e-3)
    assert np.flatnonzero(np.diff(closed))[0] <= np.flatnonzero(width < 0.08)[0]


def test_only_tasks_that_grasp_record_the_gripper() -> None:
    assert handles_objects(TASK)
    assert not handles_objects(load_task("tabletop"))


def test_a_motion_that_follows_is_planned_from_where_the_first_one_ends(table: World) -> None:
    rng = random_stream(0, "evaluate", "chain")
    (setting,) = draw_settings(TASK, "pour_done", 1, rng)
    first, second = plan_hand_paths(table, "pour_done", "right", setting, rng)
    assert (first.label, second.label) == ("pour_into", "pour_done")
    assert np.allclose(first.at(first.duration)[0], second.at(0.0)[0], atol=1e-9)
    assert np.abs(first.joints.samples[-1] - second.joints.samples[0]).max() < 0.05


def test_a_hand_works_the_gripper_when_it_is_there(table: World) -> None:
    prepare(table, "reach", seed=0)
    setting_rng = random_stream(0, "evaluate", "hand")
    (setting,) = draw_settings(TASK, "reach", 1, setting_rng)
    plan = plan_hand_paths(table, "reach", "right", setting, setting_rng)[-1]
    ((when, what),) = plan.grips
    assert what == "close"
    hand = Hand(table, plan)
    hand.pull(when - 0.01)
    assert not table.is_gripper_closed()
    hand.pull(when)
    assert table.is_gripper_closed()


def test_a_bottle_out_of_reach_is_refused_with_the_nearest_that_is_not(table: World) -> None:
    objects = dict(table.draw_scene(0, label="reach").objects)
    objects["bottle"] = Pose(objects["bottle"].position + np.array([0.35, 0.0, 0.0]))
    before = table.time
    with pytest.raises(UnreachableError, match=r"will do: bottle at \(0\.\d+, -0\.\d+\) m"):
        prepare(table, "reach", seed=0, scene=Scene(objects))
    with pytest.raises(UnreachableError, match="nearest placement found that will do: bottle at"):
        teach(table, "reach", count=1, scene=Scene(objects))
    assert table.time == before


def test_a_held_object_may_be_put_anywhere_in_the_scene(table: World) -> None:
    """Where a motion begins with it in the gripper, that is where it is."""
    scene = table.draw_scene(1, label="shake")
    setting = prepare(table, "shake", seed=1, scene=scene)
    assert np.linalg.norm(table.scene["bottle"].position - setting.start.position) < 0.05


def test_a_substitute_is_where_the_taught_object_was_and_stands_on_the_same_table() -> None:
    task = load_task("bottle")
    setting = next(iter(draw_settings(task, "reach", 1, np.random.default_rng(0))))
    traded = trade_places(task, "reach", setting, {"bottle": "can"})
    for now, before in (("can", "bottle"), ("bottle", "can")):
        assert traded.objects[now].position[:2] == pytest.approx(setting.objects[before].position[:2])
        foot = traded.objects[now].position[2] - 0.5 * task.objects[now].shape.height
        assert foot == pytest.approx(setting.objects[before].position[2] - 0.5 * task.objects[before].shape.height)
    held = next(iter(draw_settings(task, "shake", 1, np.random.default_rng(0))))
    assert trade_places(task, "shake", held, {"bottle": "can"}).objects["can"] == held.objects["bottle"]


def test_trading_places_with_what_is_not_there_is_refused_by_name() -> None:
    task = load_task("bottle")
    setting = next(iter(draw_settings(task, "reach", 1, np.random.default_rng(0))))
    for pair in ({"botle": "can"}, {"bottle": "jug"}):
        with pytest.raises(MissingObjectError, match=r"no object is named '(botle'. Did you mean 'bottle'|jug')"):
            trade_places(task, "reach", setting, pair)


def test_a_substitute_is_held_where_the_motion_holds_something(table: World) -> None:
    prepare(table, "shake", seed=0, substitute={"bottle": "can"})
    assert table.held() == "can"


def test_a_substitute_is_grasped_and_judged_in_place_of_what_was_taught(table: World) -> None:
    motion, swap = _planned(table, "reach"), {"bottle": "can"}
    prepare(table, "reach", seed=3, substitute=swap)
    log = execute(table, motion.flow_tube(table.scene, table.tool(), swap), substitute=swap)
    assert table.held() == "can"
    assert log.success, log.reason
