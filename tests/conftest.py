"""Fixtures that several folders share."""

from __future__ import annotations

import os
from collections.abc import Generator
from pathlib import Path

import pytest

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

_ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="session")
def recordings() -> Path:
    """Folder with recordings of real people, named by PFT_EXEC_DATA or beside the project; never copied into it."""
    folder = Path(os.environ.get("PFT_EXEC_DATA", _ROOT.parent / "shared" / "data"))
    if not (folder / "helloworld.npz").is_file():
        pytest.skip(f"no recordings of real people in {folder}; set PFT_EXEC_DATA to their folder")
    return folder


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Where PFT_EXEC_REQUIRE_DATA is 1, as it is in continuous integration, a test that skips has failed."""
    report = yield
    if report.skipped and os.environ.get("PFT_EXEC_REQUIRE_DATA") == "1":
        report.outcome = "failed"
        report.longrepr = f"skipped where every test must run: {report.longrepr}"
    return report
