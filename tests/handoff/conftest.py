"""An arm whose limits transitions keep."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.model import load_robot


@pytest.fixture(scope="session")
def arm():
    return load_robot("pr2").arm("right")


@pytest.fixture(scope="session")
def start(arm):
    return np.array(arm.configuration("work"))
