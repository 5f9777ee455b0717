"""What a file holds, in rows and as a picture."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, save_demonstrations
from pft_exec.demonstration.hdf5 import read_format, write_file
from pft_exec.exceptions import StorageError
from pft_exec.execution.log import ExecutionLog
from pft_exec.learning import MotionLibrary
from pft_exec.report import (
    decision_rows,
    demonstration_rows,
    log_rows,
    log_summary,
    plot_contents,
    read_contents,
)


def test_demonstrations_are_told_by_motion(demonstrations: list[Demonstration]) -> None:
    rows = demonstration_rows(demonstrations)
    assert [row["motion"] for row in rows] == ["reach", "lift"]
    assert rows[1]["count"] == 5
    assert rows[1]["samples"] == 60
    assert rows[1]["duration (s)"] == pytest.approx(2.0)
    assert rows[1]["path (m)"] == pytest.approx(0.3, abs=0.02)
    assert not rows[1]["orientation"]
    assert rows[1]["objects"] == "box"


def test_decisions_are_told_in_words_without_the_label_twice(library: MotionLibrary) -> None:
    rows = decision_rows(library)
    assert {row["motion"] for row in rows} == {"reach", "lift"}
    ends = [row["decision"] for row in rows if row["motion"] == "reach" and "ends" in row["decision"]]
    assert len(ends) == 1
    assert "box" in ends[0]
    assert "`reach`" not in ends[0]


def test_a_run_is_told_with_its_figures_and_events(log: ExecutionLog) -> None:
    summary = log_summary(log)
    assert summary["largest_force_at_tool"] == 5.0
    assert summary["details"] == {"end_position_error": 0.003}
    assert summary["events"] == [{"time": 0.8, "name": "take_over", "detail": "reach 0.99"}]
    json.dumps(summary)
    rows = log_rows(log)
    assert {"what": "take_over", "value": "reach 0.99", "unit": "at 0.80 s"} in rows
    units = {row["what"]: row["unit"] for row in rows}
    assert (units["duration"], units["end position error"]) == ("s", "m")


def test_each_kind_of_file_is_known_by_what_it_says(
    demonstrations: list[Demonstration], library: MotionLibrary, log: ExecutionLog, tmp_path: Path
) -> None:
    save_demonstrations(tmp_path / "d.h5", demonstrations)
    library.save(tmp_path / "m.h5")
    log.save(tmp_path / "l.h5")
    kinds = [type(read_contents(tmp_path / name).data) for name in ("d.h5", "m.h5", "l.h5")]
    assert kinds == [list, MotionLibrary, ExecutionLog]
    for name in ("d.h5", "m.h5", "l.h5"):
        contents = read_contents(tmp_path / name)
        assert contents.rows
        plot_contents(contents, tmp_path / f"{name}.png")
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000


def test_a_file_of_another_kind_is_refused_with_the_kinds_that_are_known(tmp_path: Path) -> None:
    write_file(tmp_path / "a.h5", {"x": np.zeros(3)}, "somebody's numbers", 1)
    assert read_format(tmp_path / "a.h5") == "somebody's numbers"
    with pytest.raises(StorageError, match=r"holds \"somebody's numbers\"; expected one of: pft_exec demonstrations"):
        read_contents(tmp_path / "a.h5")


def test_a_missing_or_broken_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="there is no file"):
        read_contents(tmp_path / "a.h5")
    (tmp_path / "b.h5").write_bytes(b"\x89HDF\r\n\x1a\n and no more")
    with pytest.raises(StorageError, match="truncated or damaged"):
        read_format(tmp_path / "b.h5")
