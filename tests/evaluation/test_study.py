"""The study goes on where it stopped, and refuses files that it cannot trust."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pft_exec import __version__
from pft_exec.evaluation.study import run_study
from pft_exec.exceptions import StorageError

MEASURED = {
    "guiding_rms": [0.002],
    "guiding_force": [5.0],
    "guiding_swivel": [0.05],
    "variables_right": [1.0, 1.0, 1.0, 0.0],
    "refused": [1.0],
    "right_recognized": [1.0, 1.0],
}


def write(folder: Path, seed: int, version: str = __version__) -> Path:
    path = folder / f"seed_{seed:04d}.json"
    path.write_text(json.dumps({"version": version, "seed": seed, "measurements": MEASURED}))
    return path


def test_seeds_that_are_done_are_not_repeated_and_counted_together(tmp_path: Path) -> None:
    for seed in (4, 5):
        write(tmp_path, seed)
    report = run_study([4, 5], tmp_path)
    assert report["figures"]["motion variables exactly right"]["value"] == pytest.approx(75.0)
    counted = report["intervals"]["variables_right"]
    assert (counted["hits"], counted["count"]) == (6, 8)
    assert counted["low"] < 75.0 < counted["high"]
    assert json.loads((tmp_path / "report.json").read_text()) == report


def test_a_damaged_file_is_refused_by_name(tmp_path: Path) -> None:
    write(tmp_path, 1).write_text('{"version": "0')
    with pytest.raises(StorageError, match=r"seed_0001\.json is damaged"):
        run_study([1], tmp_path)


def test_a_file_of_another_version_is_refused(tmp_path: Path) -> None:
    write(tmp_path, 1, version="0.0.0")
    with pytest.raises(StorageError, match=r"measured by version 0\.0\.0"):
        run_study([1], tmp_path)
