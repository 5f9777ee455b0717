"""A pursuit is supervised: slowed down along the tube, ended with a reason, attended after every period."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.execution.candidates import Candidate
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.log import ExecutionLog, Stage
from pft_exec.execution.preparation import prepare
from pft_exec.execution.pursuit import GO_ON, Instant, Outcome, Pursuit, Verdict
from pft_exec.execution.safety.stopping import stop
from pft_exec.execution.takeover import plan_takeover
from pft_exec.learning import MotionLibrary
from pft_exec.simulation import World


def pursue(world: World, library: MotionLibrary, supervise, attend=lambda _: None) -> tuple[Outcome, ExecutionLog]:
    prepare(world, "reach", seed=0)
    tube = library["reach"].flow_tube(world.scene, world.tool())
    loop = ControlLoop(world)
    takeover = plan_takeover(loop, Candidate(loop, tube, softness=0.1), 0.0)
    outcome = Pursuit(loop, takeover, supervisors=[lambda _: GO_ON, supervise], attendants=[attend]).run()
    if outcome.ending == "stopped":
        stop(loop, outcome.reason)
    return outcome, loop.log.finish(outcome.ending == "finished", outcome.reason)


def test_slowed_down_and_stopped_on_the_way_it_stays_on_the_tube_and_the_reference_is_smooth(
    shared_world: World, library: MotionLibrary
) -> None:
    def supervise(now: Instant) -> Verdict:
        return Verdict(0.0) if 0.5 <= now.time < 1.2 else Verdict(0.5) if now.time < 2.0 else GO_ON

    outcome, log = pursue(shared_world, library, supervise)
    assert (outcome.ending, outcome.fallbacks) == ("finished", 0)
    assert log.phase[-1] == 1.0
    resting = (log.time > 1.1) & (log.time < 1.2)
    assert np.ptp(log.phase[resting]) < 1e-3
    step = np.diff(log.reference_position, axis=0)
    mean = 0.5 * (log.reference_velocity[1:] + log.reference_velocity[:-1]) * np.diff(log.time)[:, None]
    assert np.max(np.abs(step - mean)) < 1e-5
    jerk = np.abs(np.diff(log.reference_acceleration, axis=0)) / shared_world.control_period
    assert (jerk <= 2.0 * shared_world.arm().limits.jerk).all()


def test_a_stop_is_an_outcome_with_its_reason_and_the_arm_comes_to_rest(
    shared_world: World, library: MotionLibrary
) -> None:
    outcome, log = pursue(
        shared_world, library, lambda now: Verdict(ending="stopped", reason="enough") if now.phase > 0.4 else GO_ON
    )
    assert (outcome.ending, outcome.reason) == ("stopped", "enough")
    assert outcome.phase == pytest.approx(0.4, abs=0.01)
    assert log.stage[-1] == Stage.STOPPED
    assert np.abs(log.velocity[-1]).max() < 0.05
    event = log.event("stop")
    assert event is not None
    assert event.detail == "enough"


def test_attendants_see_every_period_with_its_command(shared_world: World, library: MotionLibrary) -> None:
    seen: list[Instant] = []
    outcome, log = pursue(shared_world, library, lambda _: GO_ON, seen.append)
    assert (outcome.ending, outcome.fallbacks) == ("finished", 0)
    assert len(seen) == len(log)
    np.testing.assert_array_equal([instant.phase for instant in seen], log.phase)
    np.testing.assert_array_equal([instant.configuration for instant in seen], log.configuration)
