"""Success is judged by where the tool and the objects are."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.description import draw_setting, judge_motion, load_task, nominal_goal, random_stream
from pft_exec.exceptions import UnknownMotionError
from pft_exec.geometry import Pose, multiply, quaternion_from_rotation_vector

TASK = load_task("tabletop")
SETTING = draw_setting(TASK, "reach", random_stream(0, "evaluate"))
GOAL = nominal_goal(TASK, "reach", SETTING.objects, SETTING.start)


def _shifted(pose: Pose, shift: list[float], turn: list[float]) -> Pose:
    return Pose(pose.position + shift, multiply(pose.quaternion, quaternion_from_rotation_vector(turn)))


@pytest.mark.parametrize(
    ("shift", "turn", "success"),
    [
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], True),
        ([0.02, 0.0, 0.0], [0.0, 0.1, 0.0], True),
        ([0.0, 0.0, 0.03], [0.0, 0.0, 0.0], False),
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.13], False),
    ],
)
def test_the_tool_must_end_within_the_tolerances(shift: list[float], turn: list[float], success: bool) -> None:
    end = _shifted(GOAL, shift, turn)
    verdict = judge_motion(TASK, "reach", SETTING.objects, SETTING.objects, SETTING.start, end)
    assert verdict.success is success
    assert f"{1e3 * np.linalg.norm(shift):.1f} mm" in verdict.reason


@pytest.mark.parametrize(
    ("name", "shift", "turn", "success"),
    [
        ("bottle", [0.0, 0.0, 0.0], [0.0, 0.0, 2.0], True),
        ("bottle", [0.0, 0.0, 0.0], [0.1, 0.0, 0.0], False),
        ("mat", [0.0, 0.0, 0.0], [0.0, 0.0, 0.1], False),
        ("cup", [0.02, 0.0, 0.0], [0.0, 0.0, 0.0], False),
    ],
)
def test_objects_must_stay_where_they_were(name: str, shift: list[float], turn: list[float], success: bool) -> None:
    """A symmetric object may turn about its axis."""
    after = SETTING.objects | {name: _shifted(SETTING.objects[name], shift, turn)}
    verdict = judge_motion(TASK, "reach", SETTING.objects, after, SETTING.start, GOAL)
    assert verdict.success is success
    assert success or name in verdict.reason


def test_objects_that_are_not_seen_are_not_judged() -> None:
    after = {"bottle": SETTING.objects["bottle"]}
    assert judge_motion(TASK, "reach", SETTING.objects, after, SETTING.start, GOAL).success


def test_an_unknown_motion_is_refused() -> None:
    with pytest.raises(UnknownMotionError):
        judge_motion(TASK, "wave", SETTING.objects, SETTING.objects, SETTING.start, GOAL)
