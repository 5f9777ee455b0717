"""Planned pushes: on for their time, refused where they are none."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.exceptions import SimulationError
from pft_exec.simulation import Push


def test_a_push_is_on_from_its_start_for_its_duration() -> None:
    push = Push(1.0, 0.5, [0.0, 10.0, 0.0])
    forces = [push.force_at(time)[1] for time in (0.99, 1.0, 1.49, 1.5)]
    assert forces == [0.0, 10.0, 10.0, 0.0]


def test_pushes_that_are_equal_hold_arrays_that_cannot_be_changed() -> None:
    push = Push(0.0, 1.0, (1, 2, 3))
    with pytest.raises(ValueError, match="read-only"):
        push.force_at(0.5)[0] = 9.0


@pytest.mark.parametrize(
    ("start", "duration", "force"),
    [(0.0, 1.0, [1.0, 2.0]), (0.0, -1.0, [0.0, 0.0, 1.0]), (np.nan, 1.0, [0.0, 0.0, 1.0])],
)
def test_a_push_that_is_none_is_refused(start: float, duration: float, force: list[float]) -> None:
    with pytest.raises(SimulationError, match="a push needs a finite start and duration"):
        Push(start, duration, force)
