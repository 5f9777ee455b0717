"""Verdicts on what was held, set down and poured look at physics, and fail where it is not so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.description import Measured, judge_motion, load_task, nominal_goal, nominal_setting
from pft_exec.description.contact import inside, judge_held, judge_placed, judge_poured, judge_rests_in
from pft_exec.description.predicates import Held, Placed, Poured, RestsIn
from pft_exec.geometry import Pose, quaternion_from_rotation_vector

TASK = load_task("bottle")
CUP = Pose(np.array([0.6, -0.15, 0.75]))
BOTTLE = Pose(np.array([0.7, -0.2, 0.9]), quaternion_from_rotation_vector(np.array([-1.9, 0.0, 0.0])))
POURED = Poured("bottle", "cup")


def _leaning(pose: Pose, angle: float) -> Pose:
    return Pose(pose.position, quaternion_from_rotation_vector(np.array([angle, 0.0, 0.0])))


def _verdict(in_cup: int, in_bottle: int, cup: Pose = CUP) -> bool:
    beside = np.tile([0.9, 0.3, 0.71], (20 - in_cup - in_bottle, 1))
    balls = np.concatenate([np.tile(cup.position, (in_cup, 1)), np.tile(BOTTLE.position, (in_bottle, 1)), beside])
    after = {"cup": cup, "bottle": BOTTLE}
    return judge_poured(TASK, POURED, {"cup": CUP}, after, Measured(liquid=balls)).success


def test_poured_needs_four_fifths_in_the_cup_and_no_more_than_a_tenth_left() -> None:
    assert _verdict(20, 0)
    assert _verdict(16, 2)
    assert not _verdict(15, 0)
    assert not _verdict(16, 3)


def test_a_cup_that_was_pushed_or_toppled_is_no_success() -> None:
    assert not _verdict(20, 0, Pose(CUP.position + np.array([0.021, 0.0, 0.0])))
    assert not _verdict(20, 0, _leaning(CUP, 0.4))


def test_nothing_poured_without_liquid() -> None:
    assert not judge_poured(TASK, POURED, {"cup": CUP}, {"cup": CUP, "bottle": BOTTLE}, Measured()).success


def test_held_needs_contact_and_little_slip() -> None:
    limits = Held("bottle", 0.002)
    assert judge_held(limits, Measured(held="bottle", slip=0.0019)).success
    assert not judge_held(limits, Measured(held="bottle", slip=0.0021)).success
    assert not judge_held(limits, Measured(held=None)).success


def test_placed_counts_from_where_the_frame_was_before() -> None:
    limits = Placed("bottle", "coaster", (0.0, 0.0, 0.093))
    before = {"coaster": Pose(np.array([0.55, -0.3, 0.703])), "bottle": BOTTLE}
    there = Pose(np.array([0.55, -0.3, 0.796]))
    assert judge_placed(limits, before, {"bottle": there}).success
    assert not judge_placed(limits, before, {"bottle": Pose(there.position + np.array([0.011, 0.0, 0.0]))}).success
    assert not judge_placed(limits, before, {"bottle": _leaning(there, 0.06)}).success
    own = Placed("bottle", "start", (0.02, 0.2, 0.0))
    assert judge_placed(own, before, {"bottle": Pose(BOTTLE.position + np.array([0.02, 0.2, 0.0]))}).success


def test_resting_in_a_container_needs_to_be_inside_and_at_rest() -> None:
    limits = RestsIn("can", "cup")
    assert judge_rests_in(TASK, limits, {"cup": CUP, "can": CUP}, Measured()).success
    assert not judge_rests_in(TASK, limits, {"cup": CUP, "can": CUP}, Measured(speed={"can": 0.1})).success
    above = Pose(CUP.position + np.array([0.0, 0.0, 0.1]))
    assert not judge_rests_in(TASK, limits, {"cup": CUP, "can": above}, Measured()).success


def test_inside_turns_with_the_vessel() -> None:
    top = BOTTLE.apply(np.array([[0.0, 0.0, 0.089], [0.0, 0.0, 0.1], [0.029, 0.0, 0.0], [0.04, 0.0, 0.0]]))
    assert inside(TASK, "bottle", BOTTLE, top).tolist() == [True, False, True, False]


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_mirrored_task_judges_the_mirrored_course(sense: float) -> None:
    """Stirring counterclockwise with the right arm is stirring clockwise with the left."""
    task = TASK.mirrored()
    cup = CUP.mirrored(task.robot_base)
    objects = {"cup": cup, "bottle": BOTTLE, "coaster": CUP, "can": CUP}
    setting = nominal_setting(task, "stir", objects)
    angle = sense * np.linspace(0.0, -10.0 * np.pi, 500)
    circle = 0.04 * np.stack([np.cos(angle) - 1.0, np.sin(angle), 0.0 * angle], axis=1)
    measured = replace(Measured(), path=setting.start.position + circle)
    verdict = judge_motion(task, "stir", objects, objects, setting.start, setting.start, measured)
    assert verdict.success is (sense > 0.0)


def test_a_substitute_is_judged_in_place_of_what_was_taught() -> None:
    objects = {name: Pose(np.array([0.1 * k + 0.5, 0.0, 0.79])) for k, name in enumerate(TASK.placed)}
    start = Pose(np.array([0.5, -0.4, 1.0]))
    end = nominal_goal(TASK, "reach", dict(objects) | {"bottle": objects["can"]}, start)
    measured = Measured(held="can")
    assert not judge_motion(TASK, "reach", objects, objects, start, end, measured).success
    assert judge_motion(TASK, "reach", objects, objects, start, end, measured, {"bottle": "can"}).success
    taught = replace(measured, held="bottle")
    assert not judge_motion(TASK, "reach", objects, objects, start, end, taught, {"bottle": "can"}).success


@pytest.mark.parametrize("sense", [1.0, -1.0], ids=["as taught", "mirrored"])
def test_a_shorter_substitute_stands_lower_and_what_it_replaces_stays(sense: float) -> None:
    task = TASK if sense > 0.0 else TASK.mirrored()
    before = {name: Pose(np.array([0.1 * k + 0.5, 0.0, 0.79])) for k, name in enumerate(TASK.placed)}
    before["coaster"] = Pose(np.array([0.5, 0.3 * sense, 0.703]))
    height = {name: TASK.objects[name].shape.height for name in ("can", "coaster")}
    middle = before["coaster"].position + np.array([0.0, 0.0, 0.5 * sum(height.values())])
    after = before | {"can": Pose(middle)}
    at = Pose(np.array([0.5, 0.3 * sense, 0.9]))
    verdict = judge_motion(task, "put_on_table", before, after, at, at, Measured(), {"bottle": "can"})
    assert verdict.success, verdict.reason
    knocked = after | {"bottle": Pose(before["bottle"].position + np.array([0.05, 0.0, 0.0]))}
    assert not judge_motion(task, "put_on_table", before, knocked, at, at, Measured(), {"bottle": "can"}).success


def test_a_substitute_that_the_task_does_not_know_is_taken_to_be_as_high_as_what_it_stands_for() -> None:
    before = {name: Pose(np.array([0.1 * k + 0.5, 0.0, 0.79])) for k, name in enumerate(TASK.placed)}
    before["coaster"] = Pose(np.array([0.5, 0.3, 0.703]))
    height = {name: TASK.objects[name].shape.height for name in ("bottle", "coaster")}
    stands = Pose(before["coaster"].position + np.array([0.0, 0.0, 0.5 * sum(height.values())]))
    at, swap = Pose(np.array([0.5, 0.3, 0.9])), {"bottle": "flask"}
    after, lifted = (before | {"flask": pose} for pose in (stands, at))
    before |= {"flask": at}
    assert judge_motion(TASK, "put_on_table", before, after, at, at, Measured(), swap).success
    assert not judge_motion(TASK, "put_on_table", before, lifted, at, at, Measured(), swap).success


def test_what_is_poured_into_a_substitute_is_judged_by_the_substitutes_own_walls() -> None:
    """The can is higher than the cup that it stands for, and narrower."""
    before = {name: Pose(np.array([0.2 * k + 0.5, 0.0, 0.79])) for k, name in enumerate(TASK.placed)}
    high, beside = (before["can"].position + np.array(offset) for offset in ([0.0, 0.0, 0.07], [0.04, 0.0, 0.0]))
    at = Pose(np.array([0.5, 0.3, 0.9]))
    for ball, share in ((high, "20 of 20"), (beside, "0 of 20")):
        measured = Measured(held="bottle", liquid=np.tile(ball, (20, 1)))
        verdict = judge_motion(TASK, "pour_into", before, before, at, at, measured, {"cup": "can"})
        assert f"{share} balls in the cup" in verdict.reason


@pytest.mark.parametrize("speed", [0.0, 0.5])
def test_a_substitute_in_a_container_has_to_be_at_rest_itself(speed: float) -> None:
    task = load_task("ball_bin")
    objects = {"ball": Pose(np.array([0.5, -0.2, 0.08])), "bin": Pose(np.array([0.5, 0.2, 0.11]))}
    after = objects | {"plum": objects["bin"]}
    at = Pose(np.array([0.5, 0.2, 0.3]))
    measured = Measured(speed={"ball": 0.0, "plum": speed})
    verdict = judge_motion(task, "ball_to_bin", objects | {"plum": at}, after, at, at, measured, {"ball": "plum"})
    assert verdict.success is (speed == 0.0), verdict.reason
