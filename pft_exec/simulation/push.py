"""Pushes: forces that disturb a run at the tool, planned ahead."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.exceptions import SimulationError
from pft_exec.geometry import Array, read_only


@dataclass(frozen=True, eq=False)
class Push:
    """A constant force at the tool for a while.

    Parameters
    ----------
    start, duration : float, s
        On the clock of the run that it disturbs.
    force : (3,), N
        World frame.

    Raises
    ------
    SimulationError
        If the duration is negative, the force has another shape, or a number is not finite.
    """

    start: float
    duration: float
    force: ArrayLike

    def __post_init__(self) -> None:
        force = np.asarray(self.force, dtype=float)
        if force.shape != (3,) or not np.isfinite([*force, self.start, self.duration]).all() or self.duration < 0.0:
            raise SimulationError(
                f"a push needs a finite start and duration (s, not negative) and a force (3,), N; "
                f"got {self.start}, {self.duration} and {self.force!r}."
            )
        object.__setattr__(self, "force", read_only(force))

    def force_at(self, time: float) -> Array:
        """Force (3,), N, world frame, at a time, s: zero before and after."""
        is_on = self.start <= time < self.start + self.duration
        return np.asarray(self.force, dtype=float) if is_on else np.zeros(3)
