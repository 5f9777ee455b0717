"""Figures come from the logs alone: limits, seams, shares and what the task says is true."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.evaluation.measurements import beyond, figures, joined_measurements, longest_beyond
from pft_exec.execution.log import ExecutionLog, Stage
from pft_exec.model import JointLimits, load_robot


@pytest.fixture(scope="module")
def limits() -> JointLimits:
    return load_robot("pr2").arm("right").limits


def log_at(configuration: np.ndarray, velocity: np.ndarray, stage: list[Stage]) -> ExecutionLog:
    rows = len(stage)
    return ExecutionLog(
        time=0.001 * np.arange(rows),
        configuration=configuration,
        velocity=velocity,
        torque=np.zeros_like(configuration),
        position=np.zeros((rows, 3)),
        quaternion=np.tile([0.0, 0.0, 0.0, 1.0], (rows, 1)),
        phase=np.zeros(rows),
        success=True,
        reason="",
        stage=np.array(stage),
    )


@pytest.fixture
def still(limits: JointLimits) -> ExecutionLog:
    middle = np.tile(0.5 * (np.maximum(limits.lower, -3.0) + np.minimum(limits.upper, 3.0)), (10, 1))
    return log_at(middle, np.zeros_like(middle), [Stage.GUIDED] * 5 + [Stage.TUBE] * 5)


def test_a_row_beyond_a_limit_counts_for_whoever_had_the_arm(still: ExecutionLog, limits: JointLimits) -> None:
    configuration = still.configuration.copy()
    configuration[2, 1] = limits.upper[1] + 0.007
    log = replace(still, configuration=configuration)
    assert beyond(log, limits, guided=True)[0] == pytest.approx(0.007)
    assert beyond(log, limits, guided=False)[0] < 0.0


def test_velocity_beyond_its_limit_is_found(still: ExecutionLog, limits: JointLimits) -> None:
    velocity = still.velocity.copy()
    velocity[7, 0] = -limits.velocity[0] - 0.1
    assert beyond(replace(still, velocity=velocity), limits, guided=False)[1] == pytest.approx(0.1)


def test_the_longest_stay_beyond_a_limit_is_unbroken(still: ExecutionLog, limits: JointLimits) -> None:
    configuration = still.configuration.copy()
    configuration[[1, 2, 3, 6, 7], 3] = limits.lower[3] - 0.001
    assert longest_beyond(replace(still, configuration=configuration), limits) == pytest.approx(0.003)
    assert longest_beyond(still, limits) == 0.0


def test_measurements_of_several_seeds_are_joined_before_a_median_is_taken() -> None:
    parts = [{"right_tube_goal": [0.001]}, {"right_tube_goal": [0.003, 0.004]}, {"left_tube_goal": [0.1]}]
    joined = joined_measurements(parts)
    assert joined == {"right_tube_goal": [0.001, 0.003, 0.004], "left_tube_goal": [0.1]}
    name = "right: tube's end to the task's goal, median"
    measured = {**{key: [0.0] for key in ("guiding_rms", "guiding_force", "guiding_swivel")}, **joined}
    found = figures({**measured, "variables_right": [1.0], "refused": [1.0]})
    assert found[name].value == pytest.approx(3.0)
    assert not found["right: recognized by the take-over"].ok  # nothing was run: not reached, rather than vacuously so
