"""What was measured while a motion was made, besides where it began and ended, and the verdict on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from pft_exec.geometry import Array


@dataclass(frozen=True)
class Verdict:
    """Whether a motion succeeded, and the figures that say so."""

    success: bool
    reason: str


@dataclass(frozen=True, eq=False)
class Measured:
    """The tool's course, what it holds, and what moves besides.

    Parameters
    ----------
    path : (T, 3), m, world frame
        Of the tool, from the beginning of the motion to its end; (0, 3) where nobody measured.
    held : str or None
        Object between the pads now.
    slip : float, m
        How far its middle, or what of it was between the pads, has moved in the gripper since it was grasped, at most.
    liquid : (S, 3), m, world frame
        Balls of the liquid now.
    speed : mapping of object to m/s, now
    """

    path: Array = field(default_factory=lambda: np.zeros((0, 3)))
    held: str | None = None
    slip: float = 0.0
    liquid: Array = field(default_factory=lambda: np.zeros((0, 3)))
    speed: Mapping[str, float] = field(default_factory=dict)
