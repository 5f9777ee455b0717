"""The benchmark of the controller: every solver solves what the exact one does, and the tool tracks its reference."""

from __future__ import annotations

import pytest

from pft_exec.evaluation.benchmarks import control, periods
from pft_exec.evaluation.protocol import silent

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def tables():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(control, "ROUNDS", 1)
        patch.setattr(control, "SHARE", 0.2)
        patch.setattr(periods, "ROUNDS", 1)
        return list(control.time_control(0, silent).values())


def test_every_solver_solves_every_program(tables):
    for row in (*tables[0], *tables[1]):
        assert row["solved"], row
        assert row["torque error N m"] < 0.1, row


def test_limits_are_at_work_in_the_tight_run_alone(tables):
    assert all(row["limits at work"] > 0.0 for row in tables[1])
    assert all(row["limits at work"] <= tables[1][0]["limits at work"] for row in tables[0])


def test_pairs_are_near_where_there_are_obstacles(tables):
    for table in tables[2:4]:
        without, crowded = table
        assert without["pairs near"] == 0
        assert crowded["pairs near"] >= 18
        assert crowded["median us"] > without["median us"]


def test_a_whole_period_takes_longer_than_the_controller_alone(tables):
    for alone, whole in zip(tables[2], tables[3], strict=True):
        assert whole["median us"] > alone["median us"]


def test_the_tool_tracks_with_either_solver(tables):
    perfect, wrong, _ = tables[4]
    for solver in ("daqp", "osqp"):
        assert perfect[f"{solver} mm"] <= 0.3
        assert perfect[f"{solver} mrad"] <= 0.5
        assert wrong[f"{solver} mm"] <= 3.0
        assert wrong[f"{solver} mrad"] <= 30.0
