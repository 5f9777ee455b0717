"""Scenes for an arm: drawn where it reaches, mirrored for the other, refused with the distance where it does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.demonstration import Scene
from pft_exec.description import TaskDescription, object_clearance
from pft_exec.exceptions import MissingObjectError, UnknownMotionError, UnreachableError
from pft_exec.geometry import Pose
from pft_exec.model import RobotModel
from pft_exec.simulation import World, check_reach, task_for
from pft_exec.simulation.placement import draw_reachable_scene


def test_drawn_scenes_repeat_with_the_seed_and_keep_their_distance(robot: RobotModel, task: TaskDescription) -> None:
    scenes = [draw_reachable_scene(robot, task, "right", seed) for seed in range(5)]
    assert scenes == [draw_reachable_scene(robot, task, "right", seed) for seed in range(5)]
    assert len({scene["bottle"].position.tobytes() for scene in scenes}) == 5
    for scene in scenes:
        assert object_clearance(task, scene.objects) >= task.clearance.objects


def test_the_other_arm_gets_the_mirror_image(robot: RobotModel, task: TaskDescription) -> None:
    """And no matter whether the task is handed in as written or mirrored."""
    right = draw_reachable_scene(robot, task, "right", 7)
    left = draw_reachable_scene(robot, task, "left", 7)
    assert left == draw_reachable_scene(robot, task.mirrored(), "left", 7)
    for name in right:
        np.testing.assert_allclose(left[name].position, right[name].mirrored().position, atol=1e-12)
    for arm, scene in (("right", right), ("left", left)):
        for label in task.labels:
            check_reach(robot.arm(arm), task_for(robot, task, arm), label, scene)


def test_a_scene_that_only_the_other_arm_reaches_is_refused_with_the_distance(
    robot: RobotModel, task: TaskDescription
) -> None:
    objects = dict(draw_reachable_scene(robot, task, "left", 1).objects)
    objects["mat"] = Pose([0.4, 0.65, 0.703])
    scene = Scene(objects)
    check_reach(robot.arm("left"), task_for(robot, task, "left"), "put_on_table", scene)
    with pytest.raises(
        UnreachableError, match=r"the right arm cannot make 'put_on_table' in this scene: .* stays 0\.\d"
    ):
        check_reach(robot.arm("right"), task, "put_on_table", scene)


def test_motions_and_objects_that_do_not_exist_are_refused(robot: RobotModel, task: TaskDescription) -> None:
    with pytest.raises(UnknownMotionError, match="Did you mean 'reach'"):
        check_reach(robot.arm("right"), task, "raech", Scene())
    with pytest.raises(MissingObjectError, match="'bottle'"):
        check_reach(robot.arm("right"), task, "reach", Scene())


def test_a_task_out_of_reach_is_refused_whole(robot: RobotModel, task: TaskDescription) -> None:
    far = replace(task, robot_base=Pose([-3.0, 0.0, 0.0]))
    with pytest.raises(UnreachableError, match="none of 100 placements can be worked in; the right arm cannot make"):
        World(robot, far)
