"""Pictures of a run: belief, seam, stiffness."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pft_exec.exceptions import InvalidFlowTubeError, StorageError
from pft_exec.execution.log import ExecutionLog, Stage
from pft_exec.report import plot_belief, plot_log, plot_run, plot_seam, plot_stiffness

PNG = b"\x89PNG"


def test_belief_is_drawn_with_and_without_the_moment_of_take_over(log: ExecutionLog, tmp_path: Path) -> None:
    plot_belief(log.belief, tmp_path / "a.png", take_over=0.8, truth="reach")
    plot_belief(log.belief, tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() != (tmp_path / "b.png").read_bytes()


def test_seam_and_whole_run_are_drawn(log: ExecutionLog, tmp_path: Path) -> None:
    plot_seam(log, tmp_path / "seam.png")
    plot_run(log, tmp_path / "run.png")
    assert (tmp_path / "seam.png").read_bytes().startswith(PNG)
    assert (tmp_path / "run.png").read_bytes().startswith(PNG)


def test_a_run_with_a_handoff_is_drawn_around_it_and_one_without_as_a_whole(log: ExecutionLog, tmp_path: Path) -> None:
    plot_log(log, tmp_path / "with.png")
    plot_seam(log, tmp_path / "seam.png")
    assert (tmp_path / "with.png").read_bytes() == (tmp_path / "seam.png").read_bytes()
    alone = replace(log, stage=np.maximum(log.stage, Stage.TRANSITION))
    plot_log(alone, tmp_path / "without.png")
    plot_run(alone, tmp_path / "run.png")
    assert (tmp_path / "without.png").read_bytes() == (tmp_path / "run.png").read_bytes()


def test_pictures_are_the_same_each_time(log: ExecutionLog, tmp_path: Path) -> None:
    plot_seam(log, tmp_path / "a.png")
    plot_seam(log, tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_stiffness_is_drawn_beside_the_spread(tmp_path: Path) -> None:
    time, stiffness = np.linspace(0.0, 2.0, 40), np.full((40, 3), 300.0)
    plot_stiffness(time, stiffness, tmp_path / "a.png")
    plot_stiffness(time, stiffness, tmp_path / "b.png", deviation=np.full((40, 3), 0.01), label="reach")
    assert (tmp_path / "a.png").stat().st_size < (tmp_path / "b.png").stat().st_size


def test_stiffness_of_another_shape_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidFlowTubeError, match=r"stiffness must have shape \(40, 3\); got \(40, 6\)"):
        plot_stiffness(np.arange(40.0), np.zeros((40, 6)), tmp_path / "a.png")
    with pytest.raises(InvalidFlowTubeError, match=r"deviation must have shape \(40, 3\); got \(39, 3\)"):
        plot_stiffness(np.arange(40.0), np.zeros((40, 3)), tmp_path / "a.png", np.zeros((39, 3)))


@pytest.mark.parametrize("draw", [plot_seam, plot_run])
def test_a_run_is_not_drawn_into_a_missing_folder(draw: object, log: ExecutionLog, tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="does not exist"):
        draw(log, tmp_path / "nowhere" / "a.png")  # type: ignore[operator]
