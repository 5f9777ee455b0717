"""The tasks of a single arm with a gripper: feasible with room to spare, and judged by what was done."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.description import Measured, draw_setting, judge_motion, load_task, random_stream, resolve_waypoints
from pft_exec.evaluation.table3 import MOTIONS
from pft_exec.exceptions import UnreachableError
from pft_exec.execution.hand.hand_path import plan_hand_path
from pft_exec.geometry import Array, Pose
from pft_exec.model import load_robot
from pft_exec.report.check import check_description
from pft_exec.simulation import World


def course(label: str, seed: int = 3) -> tuple[object, Pose, Pose, Array]:
    """Setting, start, end and the bare path (T, 3) of a motion that is one curve."""
    task = load_task(MOTIONS[label])
    setting = draw_setting(task, label, random_stream(seed, "evaluate", label))
    waypoints = resolve_waypoints(task, label, setting.objects, setting.start)
    assert waypoints.curve is not None
    return setting, setting.start, waypoints.end, waypoints.positions[-1] + waypoints.curve


def judged(label: str, path: Array, setting: object, start: Pose) -> tuple[bool, str]:
    objects = setting.objects  # type: ignore[attr-defined]
    end = Pose(path[-1], start.quaternion)
    verdict = judge_motion(load_task(MOTIONS[label]), label, objects, objects, start, end, measured=Measured(path=path))
    return verdict.success, verdict.reason


@pytest.mark.parametrize("name", sorted(set(MOTIONS.values())))
def test_every_task_passes_its_check(name: str) -> None:
    rows = check_description("task", name)
    assert all(row["ok"] for row in rows)
    assert len(rows) == 1 + len(load_task(name).labels)


@pytest.mark.parametrize("label", MOTIONS)
def test_a_hand_can_lead_the_arm_in_most_drawn_scenes(label: str) -> None:
    """With the gripper, at most 0.7 of each joint's speed and 0.05 rad from its limits; the rest is drawn anew."""
    task, led = load_task(MOTIONS[label]), 0
    with World(load_robot("wam", tool="gripper"), task, seed=1) as world:
        for number in range(6):
            rng = random_stream(number, "evaluate", "feasible", label)
            try:
                plan_hand_path(world, label, "arm", draw_setting(task, label, rng), rng)
            except UnreachableError:
                continue
            led += 1
    assert led >= 4


@pytest.mark.parametrize(("label", "other"), [("wind", "unwind"), ("unwind", "wind")])
def test_winding_counts_turns_and_their_sense(label: str, other: str) -> None:
    setting, start, _, path = course(label)
    assert judged(label, path, setting, start)[0]
    assert not judged(other, path, setting, start)[0]
    assert not judged(label, path[: len(path) // 2], setting, start)[0]  # one turn
    assert not judged(label, path + np.array([0.25, 0.0, 0.0]), setting, start)[0]  # beside the post


@pytest.mark.parametrize(
    ("label", "other"), [("anchor_left_right", "anchor_right_left"), ("anchor_right_left", "anchor_left_right")]
)
def test_anchors_count_in_their_order_and_on_their_sides(label: str, other: str) -> None:
    setting, start, _, path = course(label)
    assert judged(label, path, setting, start)[0]
    assert not judged(other, path, setting, start)[0]
    middle = setting.objects["anchors"].position  # type: ignore[attr-defined]
    mirrored = path * [-1.0, 1.0, 1.0] + [2.0 * middle[0], 0.0, 0.0]
    assert not judged(label, mirrored, setting, start)[0]  # both posts on the wrong side
    assert not judged(label, middle + (path - middle) * [0.1, 1.0, 1.0], setting, start)[0]  # too near the posts


def test_courses_of_a_pair_are_each_other_s_reverse() -> None:
    for label, other in (("wind", "unwind"), ("anchor_left_right", "anchor_right_left")):
        there, back = course(label)[3], course(other)[3][::-1]
        assert np.allclose(there - there[0], back - back[0], atol=1e-9)


@pytest.mark.slow
def test_the_ball_is_in_the_bin_when_it_was_taught() -> None:
    """Grasped by friction, carried, let go: the ball ends within the walls, below the rim."""
    from pft_exec.execution import teach

    with World(load_robot("wam", tool="gripper"), "ball_bin", seed=2) as world:
        (demonstration,) = teach(world, "ball_to_bin", count=1)
        ball, box = world.scene["ball"].position, world.scene["bin"].position
    assert np.all(np.abs(ball - box)[:2] < 0.09 - 0.03)
    assert ball[2] < box[2] + 0.06
    assert np.ptp(demonstration.objects["ball"][:, 2]) > 0.2
    assert set(demonstration.discrete["gripper_closed"]) == {0, 1}
