"""The supervisor goes on, slows down or stops as state, solver, distance and torque ask for, and says why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.control import Command, TubeMetric
from pft_exec.execution.log import LogRecorder, Stage
from pft_exec.execution.pursuit import Instant
from pft_exec.execution.safety.plausibility import StateGuard
from pft_exec.execution.safety.supervisor import (
    COAST_TIME,
    EXHAUSTED_TIME,
    FALLBACK_TIME,
    FAR,
    FLOOR,
    OFF_TIME,
    QUIET_TIME,
    SATURATED_RATE,
    UNTAUGHT_ROTATION,
    SafetySupervisor,
)
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.model import load_robot

PERIOD = 0.01
ZERO = np.zeros(7)
CALM = Command(
    *[ZERO] * 5,
    position=np.zeros(3),
    quaternion=np.array([0.0, 0.0, 0.0, 1.0]),
    phase=0.5,
    error=np.zeros(6),
    torque_active=ZERO > 1.0,
    bound_active=ZERO > 1.0,
    status="solved",
    fallback=False,
)


@pytest.fixture
def tube() -> FlowTube:
    """5 mm and 0.03 rad wide, but 5 cm along y."""
    covariance = np.diag([0.005, 0.05, 0.005, 0.03, 0.03, 0.03]) ** 2
    time = np.linspace(0.0, 1.0, 11)
    position = np.stack([time, 0.0 * time, 0.0 * time], axis=1)
    return FlowTube("line", time, position, np.tile([0.0, 0.0, 0.0, 1.0], (11, 1)), np.tile(covariance, (11, 1, 1)))


class Run:
    """A supervisor and what it says of one command after the other."""

    def __init__(self, tube: FlowTube) -> None:
        self.log = LogRecorder()
        self.guard = StateGuard(load_robot("pr2").arm("right").limits, PERIOD)
        self.supervisor = SafetySupervisor(tube, self.guard, PERIOD, self.log)
        self.time = 0.0

    def judge(self, command: Command | None = CALM):
        self.time += PERIOD
        return self.supervisor(Instant(self.time, self.time, Stage.TUBE, ZERO, ZERO, command))

    def judge_for(self, duration: float, command: Command):
        verdicts = [self.judge(command) for _ in range(round(duration / PERIOD))]
        return verdicts[-1]

    @property
    def events(self) -> list[str]:
        return [event.name for event in self.log.finish(True, "over").events]


@pytest.fixture
def run(tube: FlowTube) -> Run:
    return Run(tube)


def off(distance: float, axis: int) -> Command:
    error = np.zeros(6)
    error[axis] = distance
    return replace(CALM, error=error)


def test_nothing_wrong_goes_on(run: Run) -> None:
    assert run.judge(None).rate == 1.0
    assert run.judge_for(5.0, CALM).rate == 1.0
    assert run.events == []


def test_the_distance_is_that_of_mahalanobis_with_a_floor(tube: FlowTube) -> None:
    distance = TubeMetric(tube, FLOOR, UNTAUGHT_ROTATION).distance
    for axis, deviation in (
        (0, np.hypot(0.005, FLOOR[0])),
        (1, np.hypot(0.05, FLOOR[0])),
        (3, np.hypot(0.03, FLOOR[1])),
    ):
        error = np.zeros(6)
        error[axis] = 2.0 * deviation
        assert distance(0.5, error) == pytest.approx(2.0)


def test_pushed_off_it_waits_and_back_it_goes_on(run: Run) -> None:
    """6 cm are far in the narrow direction and nothing in the wide one."""
    assert run.judge(off(0.06, 1)).rate == 1.0
    slower = run.judge(off(0.06, 0)).rate
    assert 0.0 < slower < 1.0
    assert run.judge(off(0.12, 0)).rate == 0.0
    assert run.judge_for(QUIET_TIME + 2 * PERIOD, off(0.0, 0)).rate == 1.0
    assert run.events == ["slow", "resume"]


def test_kept_off_the_tube_it_stops(run: Run) -> None:
    far = off(2.0 * FAR * np.hypot(0.005, FLOOR[0]), 0)
    assert run.judge_for(0.9 * OFF_TIME, far).ending is None
    verdict = run.judge_for(0.2 * OFF_TIME, far)
    assert verdict.ending == "stopped"
    assert "deviations from its tube" in verdict.reason


def test_a_solver_that_fails_once_is_waited_for_and_one_that_keeps_failing_is_not(run: Run) -> None:
    failed = replace(CALM, fallback=True, status="no solution: empty")
    assert run.judge(failed).rate == 0.0
    assert run.judge(CALM).rate == 1.0
    verdict = run.judge_for(FALLBACK_TIME + 2 * PERIOD, failed)
    assert verdict.ending == "stopped"
    assert "no solution: empty" in verdict.reason


def test_a_state_in_doubt_is_coasted_over_and_then_stopped(run: Run) -> None:
    run.guard.update(ZERO, ZERO)
    run.guard.update(ZERO + 0.3, ZERO)
    assert run.judge().rate == 0.0
    for _ in range(round(COAST_TIME / PERIOD) + 1):
        run.guard.update(ZERO + 0.3, ZERO)
    verdict = run.judge()
    assert verdict.ending == "stopped"
    assert "jumped by 0.300 rad" in verdict.reason


def test_a_joint_at_its_torque_limit_for_long_slows_down_and_for_too_long_stops(run: Run) -> None:
    active = ZERO > 1.0
    active[2] = True
    full = replace(CALM, torque_active=active)
    assert run.judge(full).rate == 1.0
    assert run.judge_for(0.5, full).rate == SATURATED_RATE
    verdict = run.judge_for(EXHAUSTED_TIME, full)
    assert verdict.ending == "stopped"
    assert "joint 3 is at its torque limit" in verdict.reason
