"""Packages that only the baselines need: who lacks them is told so, and the rest works without."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from pft_exec.evaluation import extras, reproduce
from pft_exec.evaluation.benchmarks import benchmark
from pft_exec.exceptions import MissingPackageError


def test_who_lacks_a_package_is_told_which_and_how_to_get_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda _: None)
    for run in (lambda: reproduce("table1", out=tmp_path / "out"), lambda: benchmark("recognition")):
        with pytest.raises(MissingPackageError, match=r"hmmlearn and movement-primitives.*evaluation"):
            run()
    assert not (tmp_path / "out").exists()


def test_everything_else_is_imported_without_them() -> None:
    """What the lock file of a plain installation has must do for the tables that have no baselines."""
    lock = Path(__file__).parents[2] / "requirements.lock"
    assert "threadpoolctl==" in lock.read_text()
    hidden = "import sys; sys.modules.update(dict.fromkeys(['hmmlearn', 'sklearn', 'movement_primitives']));"
    modules = "import pft_exec.evaluation.reproduction, pft_exec.evaluation.benchmarks, pft_exec.evaluation.table3"
    subprocess.run([sys.executable, "-c", f"{hidden} {modules}"], check=True, timeout=120)
