"""Curves that a hand draws in one go: circles, swings to and fro, S-curves; relative to where they begin.

A waypoint is reached and left; a curve is one movement whose course is the point of it. Each is given by its
displacement over the share of its time, minimum-jerk in its own law of time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.description.quantities import Vector, check_positive
from pft_exec.geometry import Array

CURVE_SAMPLES = 401  # of a tabulated curve: five circles have 80 samples each


@dataclass(frozen=True)
class Circle:
    """Circles in a level plane.

    Parameters
    ----------
    radius : float, m
    turns : float
        Above 0 counterclockwise, seen from above.
    angle : float, rad
        Where on the circle it begins, from the world's x axis, seen from the centre.
    rise : float, m
        Over all turns.
    duration : float, s
    """

    kind: Literal["circle"]
    radius: float
    turns: float
    duration: float
    angle: float = 0.0
    rise: float = 0.0

    def __post_init__(self) -> None:
        check_positive("radius and duration", self.radius, self.duration)

    def displacement(self, share: ArrayLike) -> Array:
        """From the beginning (N, 3), m, world axes, at shares (N,) of the duration."""
        u = _minimum_jerk(np.asarray(share, dtype=float))
        angle = self.angle + 2.0 * np.pi * self.turns * u
        level = self.radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        begin = self.radius * np.array([np.cos(self.angle), np.sin(self.angle)])
        return np.concatenate([level - begin, self.rise * u[..., None]], axis=-1)


@dataclass(frozen=True)
class Swing:
    """To and fro on a line: rests at each reversal.

    Parameters
    ----------
    direction : (3,)
        World axes; its length does not matter.
    offsets : tuple of float, m
        Along the direction, from the beginning, one reversal after another.
    durations : tuple of float, s
        To each from the one before.
    """

    kind: Literal["swing"]
    direction: Vector
    offsets: tuple[float, ...]
    durations: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.offsets or len(self.offsets) != len(self.durations):
            raise ValueError(f"as many durations as offsets; got {len(self.durations)} and {len(self.offsets)}.")
        check_positive("durations", *self.durations)
        check_positive("length of the direction", float(np.linalg.norm(self.direction)))

    @property
    def duration(self) -> float:
        """Of all together, s."""
        return sum(self.durations)

    def displacement(self, share: ArrayLike) -> Array:
        """From the beginning (N, 3), m, world axes, at shares (N,) of the duration."""
        time = np.asarray(share, dtype=float) * self.duration
        begins = np.append(0.0, np.cumsum(self.durations)[:-1])
        ratio = np.clip((time[..., None] - begins) / np.array(self.durations), 0.0, 1.0)
        along = _minimum_jerk(ratio) @ np.diff(np.append(0.0, self.offsets))
        direction = np.array(self.direction) / np.linalg.norm(self.direction)
        curve: Array = along[..., None] * direction
        return curve


@dataclass(frozen=True)
class SCurve:
    """Around two things that stand behind one another in y: x = sign ax sin(2 pi u), y = sign ay cos(pi u).

    Parameters
    ----------
    amplitude : (2,), m
        Along the world's x and y axes.
    sign : float
        1 or -1: where it begins and which side it takes first.
    duration : float, s
    """

    kind: Literal["s_curve"]
    amplitude: tuple[float, float]
    sign: float
    duration: float

    def __post_init__(self) -> None:
        check_positive("duration", self.duration)
        if self.sign not in (1.0, -1.0):
            raise ValueError(f"sign must be 1 or -1; got {self.sign:g}.")

    def displacement(self, share: ArrayLike) -> Array:
        """From the beginning (N, 3), m, world axes, at shares (N,) of the duration."""
        u = _minimum_jerk(np.asarray(share, dtype=float))
        x = self.sign * self.amplitude[0] * np.sin(2.0 * np.pi * u)
        y = self.sign * self.amplitude[1] * (np.cos(np.pi * u) - 1.0)
        return np.stack([x, y, np.zeros_like(u)], axis=-1)


Curve = Circle | Swing | SCurve


def tabulate_curve(curve: Curve) -> Array:
    """Displacement (`CURVE_SAMPLES`, 3), m, world axes, at even shares of the duration."""
    return curve.displacement(np.linspace(0.0, 1.0, CURVE_SAMPLES))


def _minimum_jerk(ratio: Array) -> Array:
    """Share of the way at shares of the time: 10 u^3 - 15 u^4 + 6 u^5 [Flash1985]_."""
    share: Array = ratio**3 * (10.0 - 15.0 * ratio + 6.0 * ratio**2)
    return share
