"""Teaching: the hand leads the floating arm, what the arm did is recorded, and what cannot be led is refused first."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.demonstration.synthetic import STEADY
from pft_exec.description import Setting, draw_setting, judge_motion, random_stream
from pft_exec.exceptions import (
    LearningError,
    MissingObjectError,
    UnknownArmError,
    UnknownMotionError,
    UnreachableError,
)
from pft_exec.execution import GuidingFigures, teach
from pft_exec.execution.hand import hand_path
from pft_exec.execution.hand.guiding import swivel_between
from pft_exec.execution.hand.hand_path import Hand, lead_motion, plan_hand_path, resting_posture
from pft_exec.geometry import Pose, geodesic_distance, quaternion_from_rotation_vector
from pft_exec.simulation import World


@pytest.fixture(scope="module")
def world() -> Iterator[World]:
    with World("pr2", "tabletop", seed=0) as opened:
        yield opened


@pytest.fixture(scope="module")
def setting(world: World) -> Setting:
    return draw_setting(world.task, "reach", random_stream(0, "evaluate", "teaching"))


def _moved(setting: Setting, name: str, shift: list[float]) -> Scene:
    objects = dict(setting.objects)
    objects[name] = Pose(objects[name].position + shift, objects[name].quaternion)
    return Scene(objects)


# --- before anything moves -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arm", ["right", "left"])
def test_the_planned_path_begins_with_the_tool_at_the_start(world: World, arm: str) -> None:
    setting = draw_setting(world.task_for(arm), "reach", random_stream(1, "evaluate", "teaching"))
    plan = plan_hand_path(world, "reach", arm, setting, np.random.default_rng(0))
    tool = world.base @ world.arm(arm).forward(plan.configuration)
    np.testing.assert_allclose(tool.position, setting.start.position, atol=2e-6)
    assert geodesic_distance(tool.quaternion, setting.start.quaternion) < 2e-6
    position, quaternion = plan.at([0.0, plan.rest_before])
    np.testing.assert_allclose(position, [setting.start.position] * 2, atol=1e-12)
    assert geodesic_distance(quaternion, setting.start.quaternion).max() < 1e-7


def test_the_path_rests_at_both_ends_and_ends_near_the_goal(world: World, setting: Setting) -> None:
    plan = plan_hand_path(world, "reach", None, setting, np.random.default_rng(0))
    assert 0.15 <= plan.rest_before <= 0.4
    assert 0.25 <= plan.rest_after <= 0.5
    end, resting = plan.at([plan.duration - plan.rest_after, plan.duration])[0]
    np.testing.assert_array_equal(end, resting)
    assert np.linalg.norm(end - plan.goal.position) < 0.01


def test_a_scene_out_of_reach_is_refused_with_the_distance_before_anything_moves(
    world: World, setting: Setting
) -> None:
    before = world.time, world.tool()
    with pytest.raises(UnreachableError, match=r"right arm cannot make 'reach'.*stays 0\.\d+ m"):
        teach(world, "reach", scene=_moved(setting, "bottle", [0.6, 0.0, 0.0]))
    assert (world.time, world.tool()) == before


def test_a_path_out_of_reach_is_refused_with_the_distance(world: World, setting: Setting) -> None:
    far = Setting(dict(_moved(setting, "bottle", [0.2, -0.25, 0.0]).objects), setting.start)
    with pytest.raises(UnreachableError, match=r"cannot be led through 'reach'.*misses by \d+ mm"):
        plan_hand_path(world, "reach", "right", far, np.random.default_rng(0))


def test_a_path_out_of_the_workspace_is_refused_with_the_distance(world: World, setting: Setting) -> None:
    far = Setting(dict(_moved(setting, "bottle", [0.6, 0.0, 0.0]).objects), setting.start)
    with pytest.raises(UnreachableError, match=r"'reach' would leave the workspace of task 'tabletop' by \d+ mm"):
        plan_hand_path(world, "reach", "right", far, np.random.default_rng(0))


@pytest.mark.parametrize(
    ("bound", "value", "message"),
    [
        ("LIMIT_MARGIN", 3.0, r"a joint would be 0\.\d+ rad from its limit \(least: 3\.0\)"),
        ("LEAST_MANIPULABILITY", 1.0, r"nearly singular \(0\.\d+; least: 1\.0\)"),
        ("VELOCITY_SHARE", 0.01, r"turn at 0\.\d+ of its velocity limit \(most: 0\.01\)"),
    ],
)
def test_a_path_without_room_is_refused_with_the_figure(
    world: World, setting: Setting, monkeypatch: pytest.MonkeyPatch, bound: str, value: float, message: str
) -> None:
    monkeypatch.setattr(hand_path, bound, value)
    with pytest.raises(UnreachableError, match=message):
        plan_hand_path(world, "reach", "right", setting, np.random.default_rng(0))


def test_a_path_through_a_joint_limit_is_refused(world: World, setting: Setting) -> None:
    start = Pose(np.array([0.49, -0.33, 1.0]), quaternion_from_rotation_vector(np.array([0.0, 0.0, 0.95])))
    with pytest.raises(UnreachableError, match=r"rad from its limit"):
        plan_hand_path(world, "move_left", "right", Setting(setting.objects, start), np.random.default_rng(0), STEADY)


def test_an_object_in_the_way_is_refused(world: World, setting: Setting) -> None:
    goal = plan_hand_path(world, "reach", None, setting, np.random.default_rng(0)).goal
    objects = setting.objects | {"cup": Pose(goal.position + np.array([0.0, 0.0, -0.07]))}
    with pytest.raises(UnreachableError, match="no scene and start found"):
        teach(world, "reach", scene=Scene(objects))


def test_unknown_names_and_empty_lessons_are_refused(world: World, setting: Setting) -> None:
    with pytest.raises(UnknownMotionError, match="Did you mean 'reach'"):
        teach(world, "raech")
    with pytest.raises(UnknownArmError, match="'right'"):
        teach(world, "reach", arm="rihgt")
    with pytest.raises(LearningError, match="count=0"):
        teach(world, "reach", count=0)
    lacking = {name: pose for name, pose in setting.objects.items() if name != "bottle"}
    with pytest.raises(MissingObjectError, match="'bottle'"):
        plan_hand_path(world, "reach", None, Setting(lacking, setting.start), np.random.default_rng(0))


def test_a_hand_leads_from_where_the_tool_is(world: World) -> None:
    world.reset(None, {"right": resting_posture(world.arm("right"))})
    hand = lead_motion(world, "move_left", "right", seed=3)
    tool = world.tool("right")
    assert isinstance(hand, Hand)
    np.testing.assert_allclose(hand.guide.pose(0.0)[0], tool.position, atol=1e-12)
    np.testing.assert_allclose(hand.goal.position - tool.position, [0.0, 0.2, 0.0], atol=1e-12)
    assert np.linalg.norm(hand.pull(0.0)) < 1e-6
    assert hand.duration == hand.plan.duration


def test_the_swivel_sees_the_elbow_and_not_the_tool(world: World) -> None:
    """A small swivel by a known angle about the line from shoulder to wrist, up to the offsets of a real shoulder."""
    arm = world.arm("right")
    q = resting_posture(arm)
    jacobian = arm.jacobian(q)
    elbow = np.linalg.svd(jacobian)[2][6]
    rate = np.linalg.norm(jacobian[3:, :3] @ elbow[:3])  # of the upper arm
    tool = np.linalg.pinv(jacobian) @ np.array([0.01, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert swivel_between(arm, q - 0.005 * elbow, q + 0.005 * elbow) == pytest.approx(0.01 * rate, rel=0.05)
    assert swivel_between(arm, q, q + tool) < 1e-3
    assert swivel_between(arm, q[:6], q[:6]) == 0.0


# --- simulated -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def taught(world: World) -> tuple[list[Demonstration], list[GuidingFigures]]:
    figures: list[GuidingFigures] = []
    return teach(world, "reach", count=2, seed=5, report=figures.append), figures


@pytest.mark.slow
def test_the_tool_follows_the_hand(taught: tuple[list[Demonstration], list[GuidingFigures]]) -> None:
    """Floors: 10 mm rms, 15 N, an elbow drift of 0.1 rad."""
    for figures in taught[1]:
        assert figures.rms_error <= 0.010
        assert figures.largest_error >= figures.rms_error
        assert figures.peak_force <= 15.0
        assert figures.swivel_drift <= 0.1


@pytest.mark.slow
def test_a_demonstration_holds_what_the_arm_did(
    world: World, taught: tuple[list[Demonstration], list[GuidingFigures]]
) -> None:
    for demonstration in taught[0]:
        assert demonstration.label == "reach"
        np.testing.assert_allclose(np.diff(demonstration.time), 0.01, atol=1e-9)
        assert set(demonstration.objects) == set(world.task.placed)
        assert demonstration.continuous["gripper"].shape == demonstration.time.shape
        for index in (0, len(demonstration) // 2, -1):
            tool = world.base @ world.arm().forward(demonstration.configuration[index])
            np.testing.assert_allclose(tool.position, demonstration.position[index], atol=1e-9)


@pytest.mark.slow
def test_a_demonstration_rests_at_both_ends_and_does_the_motion(
    world: World, taught: tuple[list[Demonstration], list[GuidingFigures]]
) -> None:
    for demonstration in taught[0]:
        assert np.linalg.norm(demonstration.position[10] - demonstration.position[0]) < 1e-3
        assert np.linalg.norm(demonstration.position[-10] - demonstration.position[-1]) < 1e-3
        after = {name: Pose.from_array(poses[-1]) for name, poses in demonstration.objects.items()}
        verdict = judge_motion(
            world.task, "reach", demonstration.scene.objects, after, demonstration.start, demonstration.end
        )
        assert verdict.success, verdict.reason


@pytest.mark.slow
def test_scenes_and_starts_differ_from_time_to_time(
    taught: tuple[list[Demonstration], list[GuidingFigures]],
) -> None:
    first, second = taught[0]
    assert np.linalg.norm(first.start.position - second.start.position) > 0.01
    assert np.linalg.norm(first.scene["bottle"].position - second.scene["bottle"].position) > 0.01


@pytest.mark.slow
def test_the_same_seed_gives_the_same_demonstration_bit_for_bit_in_another_world() -> None:
    """Also where it was reported on, and whatever the world did before."""
    taught = []
    for report in (None, lambda _: None):
        with World("pr2", "tabletop", seed=int(report is None)) as world:
            taught += teach(world, "move_left", count=1, seed=2, report=report)
    first, second = taught
    for name in ("time", "position", "quaternion", "configuration"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    assert first.scene == second.scene


@pytest.mark.slow
def test_the_left_arm_is_taught_in_the_mirror_image(world: World) -> None:
    figures: list[GuidingFigures] = []
    (demonstration,) = teach(world, "move_left", "left", count=1, seed=4, report=figures.append)
    shift = demonstration.end.position - demonstration.start.position
    np.testing.assert_allclose(shift, [0.0, -0.2, 0.0], atol=0.01)
    assert demonstration.start.position[1] > 0.3
    assert figures[0].rms_error <= 0.010
    assert figures[0].peak_force <= 15.0


@pytest.mark.slow
def test_a_scene_of_the_users_is_the_scene_of_every_demonstration(world: World, setting: Setting) -> None:
    scene = Scene(setting.objects)
    (demonstration,) = teach(world, "go_home", count=1, scene=scene)
    for name in world.task.placed:
        np.testing.assert_allclose(demonstration.scene[name].position, scene[name].position, atol=1e-3)
