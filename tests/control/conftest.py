"""An arm, a tube and a place to start from."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.model import load_robot
from tests.control.plant import arch


@pytest.fixture(scope="session")
def arm():
    return load_robot("pr2").arm("right")


@pytest.fixture(scope="session")
def start(arm):
    return np.array(arm.configuration("work"))


@pytest.fixture(scope="session")
def tube(arm, start):
    return arch(arm, start, duration=2.0, steps=60)
