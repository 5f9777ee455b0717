"""The picture of a run shows what the controller did where the log says so, and marks events."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pft_exec.execution.control_history import ControlHistory
from pft_exec.execution.log import Event, ExecutionLog
from pft_exec.report import plot_log, plot_run, plot_seam


@pytest.fixture
def told(log: ExecutionLog) -> ExecutionLog:
    count, size = log.torque.shape
    active = np.zeros((count, size), dtype=bool)
    active[900:950, 2] = True
    history = ControlHistory(
        costs={"tracking": np.full(count, 1e-3), "posture": np.full(count, np.nan)},
        torque_active=active,
        bound_active=~active & False,
        apart={"forearm / bottle": active[:, 2]},
        fallback=active[:, 2],
        solve_time=np.full(count, 2e-5),
        rate=np.ones(count),
    )
    return replace(log, control=history)


def test_a_run_with_a_history_shows_more_than_one_without(
    log: ExecutionLog, told: ExecutionLog, tmp_path: Path
) -> None:
    plot_run(log, tmp_path / "without.png")
    plot_run(told, tmp_path / "with.png")
    assert (tmp_path / "with.png").stat().st_size > (tmp_path / "without.png").stat().st_size


def test_a_handoff_with_a_history_is_drawn_beside_the_whole_run(told: ExecutionLog, tmp_path: Path) -> None:
    plot_log(told, tmp_path / "both.png")
    plot_seam(told, tmp_path / "seam.png")
    assert (tmp_path / "both.png").stat().st_size > 1.5 * (tmp_path / "seam.png").stat().st_size


def test_events_are_marked(told: ExecutionLog, tmp_path: Path) -> None:
    plot_run(told, tmp_path / "a.png")
    plot_run(replace(told, events=(*told.events, Event(1.5, "slow", "pushed"))), tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() != (tmp_path / "b.png").read_bytes()
