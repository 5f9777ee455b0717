"""The person stays master: a push gives the arm back without a bump, and another motion may be recognized."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.demonstration import Scene
from pft_exec.exceptions import ControlError, UnknownMotionError
from pft_exec.execution import ExecutionLog, Stage, assist, execute, prepare
from pft_exec.execution.hand.person import TakeBackPlan
from pft_exec.geometry import Pose
from pft_exec.learning import MotionLibrary
from pft_exec.simulation import Push, World


def torque_steps(log: ExecutionLog, begin: float, duration: float) -> float:
    """Largest step of any joint's torque from one control period to the next, N m, between two times."""
    rows = (log.time >= begin - 1.5e-3) & (log.time < begin + duration)
    return float(np.abs(np.diff(log.torque[rows], axis=0)).max())


@pytest.fixture(scope="module")
def taken_back(shared_world: World, library: MotionLibrary) -> ExecutionLog:
    prepare(shared_world, "move_left", seed=3)
    return assist(shared_world, library, "move_left", seed=3, take_backs=[TakeBackPlan("reach", after=0.4)])


def test_the_person_takes_back_and_the_arm_floats_under_the_hand(taken_back: ExecutionLog) -> None:
    gripped, event = taken_back.event("grip"), taken_back.event("take_back")
    assert gripped is not None
    assert event is not None
    assert gripped.time < event.time < gripped.time + 0.6
    after = (taken_back.time > event.time) & (taken_back.time < event.time + 0.5)
    assert set(taken_back.stage[after]) == {Stage.GUIDED}


def test_there_is_no_bump(taken_back: ExecutionLog) -> None:
    event = taken_back.event("take_back")
    assert event is not None
    assert torque_steps(taken_back, event.time, 0.04) <= 0.5


def test_the_other_motion_is_recognized_and_finished(taken_back: ExecutionLog) -> None:
    assert taken_back.label == "reach"
    assert taken_back.success, taken_back.reason
    assert taken_back.details["taken_back"] == 1.0


@pytest.mark.parametrize("size", [20.0, 40.0])
def test_a_hard_push_is_given_way_to_within_limits_and_the_motion_goes_on(
    size: float, shared_world: World, library: MotionLibrary
) -> None:
    prepare(shared_world, "reach", seed=0)
    tube = library["reach"].flow_tube(shared_world.scene, shared_world.tool())
    log = execute(shared_world, tube, pushes=[Push(1.0, 0.3, (0.0, size, 0.0))])
    event = log.event("take_back")
    assert event is not None
    assert event.time <= 1.02
    assert torque_steps(log, event.time, 0.03) <= 0.5
    assert np.all(np.abs(log.velocity) <= shared_world.arm().limits.velocity)
    assert log.success, log.reason


def test_a_gentle_push_is_the_compliances(shared_world: World, library: MotionLibrary) -> None:
    prepare(shared_world, "reach", seed=0)
    tube = library["reach"].flow_tube(shared_world.scene, shared_world.tool())
    log = execute(shared_world, tube, pushes=[Push(1.0, 0.3, (0.0, 10.0, 0.0))])
    assert log.event("take_back") is None
    assert log.success, log.reason


def test_a_push_while_nobody_leads_interrupts_the_motion_for_a_moment(
    shared_world: World, library: MotionLibrary
) -> None:
    prepare(shared_world, "reach", seed=3)
    log = assist(shared_world, library, "reach", seed=3, pushes=[Push(2.0, 0.3, (0.0, 20.0, 0.0))])
    assert log.event("take_back") is not None
    assert log.label == "reach"
    assert log.success, log.reason


def test_a_pace_slows_down_what_the_robot_finishes(shared_world: World, library: MotionLibrary) -> None:
    durations = []
    for pace in (1.0, 0.5):
        prepare(shared_world, "reach", seed=3)
        log = assist(shared_world, library, "reach", seed=3, pace=pace)
        assert log.success, log.reason
        durations.append(log.time[-1] - log.details["take_over_time"])
    assert durations[1] > 1.5 * durations[0]


def test_tubes_are_made_anew_when_somebody_moves_an_object(shared_world: World, library: MotionLibrary) -> None:
    """Half a second after the hand began, all objects are seen 3 cm away; recognition and take-over go on."""
    prepare(shared_world, "reach", seed=3)
    begin, seen = shared_world.time, World.scene

    def moved(world: World) -> Scene:
        objects = seen.fget(world).objects
        shift = np.array([0.0, 0.03, 0.0]) * (world.time - begin > 0.5)
        return Scene({name: Pose(pose.position + shift, pose.quaternion) for name, pose in objects.items()})

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(World, "scene", property(moved))
        log = assist(shared_world, library, "reach", seed=3)
    assert log.event("scene") is not None
    assert log.label == "reach"
    assert log.position[-1, 1] - library["reach"].flow_tube(shared_world.scene).end.position[1] == pytest.approx(
        0.03, abs=0.01
    )


def test_a_pace_and_a_plan_that_are_none_are_refused(shared_world: World, library: MotionLibrary) -> None:
    with pytest.raises(ControlError, match="pace must be positive"):
        assist(shared_world, library, "reach", pace=0.0)
    with pytest.raises(ControlError, match=r"phase in \[0, 1\]"):
        TakeBackPlan("reach", phase=2.0)
    with pytest.raises(UnknownMotionError):
        assist(shared_world, library, "reach", take_backs=[TakeBackPlan("raech")])


def test_no_torque_steps_in_the_whole_run(taken_back: ExecutionLog) -> None:
    """Not where the hand lets go, not at a join, not where it takes back, not where the robot takes over again."""
    assert torque_steps(taken_back, 0.01, taken_back.time[-1]) <= 0.5


def test_a_person_may_start_elsewhere_than_taught(shared_world: World, library: MotionLibrary) -> None:
    """From the working posture, 20 cm below the taught starts."""
    work = shared_world.arm().configuration("work")
    shared_world.reset(shared_world.draw_scene(1), {"right": work})
    log = assist(shared_world, library, "reach", seed=1)
    assert log.label == "reach"
    assert log.success, log.reason
