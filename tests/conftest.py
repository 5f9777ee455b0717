"""Fixtures that several folders share."""

from __future__ import annotations

import os
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
