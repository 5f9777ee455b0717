"""Yielding: when nobody moves an arm any more."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.execution.safety.yielding import Calm

STILL = np.zeros(3), np.zeros(7)


@pytest.mark.parametrize("lasting", [0.3, 0.6])
def test_it_is_calm_once_force_and_motion_have_been_small_for_long_enough(lasting: float) -> None:
    calm = Calm(0.0, lasting)
    assert not calm.update(lasting - 0.01, *STILL)
    assert calm.update(lasting, *STILL)


@pytest.mark.parametrize(
    "disturbed", [(np.array([0.0, 0.0, 9.0]), np.zeros(7)), (np.zeros(3), np.full(7, 0.06))], ids=["force", "motion"]
)
def test_a_force_or_a_motion_begins_the_time_anew(disturbed: tuple[np.ndarray, np.ndarray]) -> None:
    calm = Calm(0.0, 0.3)
    assert not calm.update(0.2, *disturbed)
    assert not calm.update(0.4, *STILL)
    assert calm.update(0.5, *STILL)
