"""A tube is executed to its end within the limits, the same each time, and never begun where it cannot be ended."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.exceptions import InvalidFlowTubeError, UnknownArmError, UnreachableError
from pft_exec.execution import ExecutionLog, Stage, execute, prepare
from pft_exec.learning import FlowTube, MotionLibrary
from pft_exec.simulation import Push, World

ROWS = ("configuration", "velocity", "torque", "position", "quaternion", "reference_position", "phase", "hand_force")


def reach_tube(world: World, library: MotionLibrary, seed: int = 0) -> FlowTube:
    prepare(world, "reach", seed=seed)
    return library["reach"].flow_tube(world.scene, world.tool())


@pytest.fixture(scope="module")
def log(shared_world: World, library: MotionLibrary) -> ExecutionLog:
    return execute(shared_world, reach_tube(shared_world, library))


def test_the_tool_ends_where_the_tube_ends(log: ExecutionLog) -> None:
    assert log.success, log.reason
    assert log.details["end_position_error"] < 0.005
    assert log.details["end_rotation_error"] < np.deg2rad(2.0)


def test_torque_position_and_velocity_keep_their_limits(log: ExecutionLog, shared_world: World) -> None:
    limits = shared_world.arm().limits
    assert np.all(np.abs(log.torque) <= limits.torque + 1e-9)
    assert np.all((log.configuration >= limits.lower) & (log.configuration <= limits.upper))
    assert np.all(np.abs(log.velocity) <= limits.velocity)


def test_stages_follow_one_another_and_the_phase_runs_from_begin_to_end(log: ExecutionLog) -> None:
    assert np.all(np.diff(log.stage) >= 0)
    assert set(log.stage) == {Stage.TRANSITION, Stage.TUBE, Stage.HOLD}
    assert np.all(np.diff(log.phase) >= -1e-12)
    assert log.phase[-1] == 1.0


def test_the_commanded_joints_do_not_jump_at_the_seams(log: ExecutionLog, shared_world: World) -> None:
    jerk = shared_world.arm().limits.jerk.min()
    for seam in (1, 2):
        assert log.details[f"seam_{seam}_position"] < 1e-6
        assert log.details[f"seam_{seam}_velocity"] < 1e-6
        assert log.details[f"seam_{seam}_acceleration"] <= jerk * shared_world.control_period


def test_the_command_integrates_over_the_whole_run(log: ExecutionLog) -> None:
    """Position is the integral of velocity everywhere, seams included: what is logged is one smooth reference."""
    step = np.diff(log.reference_position, axis=0)
    mean = 0.5 * (log.reference_velocity[1:] + log.reference_velocity[:-1]) * np.diff(log.time)[:, None]
    assert np.max(np.abs(step - mean)) < 1e-5


def test_the_same_run_twice_is_the_same_bit_for_bit(
    log: ExecutionLog, shared_world: World, library: MotionLibrary
) -> None:
    again = execute(shared_world, reach_tube(shared_world, library))
    for name in ROWS:
        np.testing.assert_array_equal(getattr(log, name), getattr(again, name))


def test_a_push_moves_the_tool_and_the_motion_is_finished_all_the_same(
    log: ExecutionLog, shared_world: World, library: MotionLibrary
) -> None:
    push = Push(1.0, 0.3, (0.0, 0.0, 10.0))
    pushed = execute(shared_world, reach_tube(shared_world, library), pushes=[push])
    during = (pushed.time >= 1.0) & (pushed.time < 1.3)
    np.testing.assert_array_equal(np.flatnonzero(pushed.hand_force), np.flatnonzero(during))
    rows = min(len(log), len(pushed))
    assert np.max(pushed.position[:rows, 2] - log.position[:rows, 2]) > 0.003
    assert pushed.details["end_position_error"] < 0.005


def test_a_slower_pace_takes_longer(log: ExecutionLog, shared_world: World, library: MotionLibrary) -> None:
    slow = execute(shared_world, reach_tube(shared_world, library), pace=0.5)
    assert slow.time[-1] > 1.5 * log.time[-1]
    assert slow.success, slow.reason


def test_control_at_500_hz_over_physics_at_1_khz(library: MotionLibrary) -> None:
    with World("pr2", "tabletop", seed=0, control_period=2e-3) as world:
        log = execute(world, reach_tube(world, library))
    assert log.success, log.reason
    np.testing.assert_allclose(np.diff(log.time), 2e-3, atol=1e-9)


def test_the_tubes_of_a_library_are_not_one_tube(shared_world: World, library: MotionLibrary) -> None:
    with pytest.raises(InvalidFlowTubeError, match="one flow tube"):
        execute(shared_world, library.flow_tubes(shared_world.scene))


def test_a_tube_beyond_reach_is_refused_with_the_distance_before_anything_moves(
    shared_world: World, library: MotionLibrary
) -> None:
    tube = reach_tube(shared_world, library)
    far = replace(tube, position=tube.position + np.linspace(0.0, 0.6, len(tube))[:, None] * [1.0, 0.0, 0.0])
    before = shared_world.time, shared_world.tool()
    with pytest.raises(UnreachableError, match=r"beyond the reach of arm 'right'.*no nearer than \d+ mm"):
        execute(shared_world, far)
    assert (shared_world.time, shared_world.tool()) == before


def test_an_unknown_arm_is_refused_with_the_nearest_name(shared_world: World, library: MotionLibrary) -> None:
    tube = reach_tube(shared_world, library)
    with pytest.raises(UnknownArmError, match="Did you mean 'right'"):
        execute(shared_world, tube, "rigt")


def test_a_motion_that_no_task_knows_succeeds_where_its_tube_ends(shared_world: World, library: MotionLibrary) -> None:
    tube = replace(reach_tube(shared_world, library), label="wave")
    log = execute(shared_world, tube)
    assert log.success
    assert "from the tube's end" in log.reason
