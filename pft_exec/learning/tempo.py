"""Tempo: how far along its way a motion is at each share of the time, as the demonstrations were.

In the flow: `blending` gives the blended path the tempo that the demonstrations have in common. Weights that change
along the path push the blend from one expert to another, and the push is no speed that anybody showed; where it goes
depends on the scene, so no alignment takes it out. How a share of the way goes with a share of the time does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pft_exec.geometry import Array
from pft_exec.learning.smoothing import smoothed
from pft_exec.learning.turning import turn_between, turn_by

EVEN = 0.05  # share of the way that goes by the clock alone, so that a rest is a place like any other
WINDOW = 0.02  # of the motion over which steps are averaged before their lengths count: tremor is no way


@dataclass(frozen=True, eq=False)
class Tempo:
    """How far K demonstrations were at N even steps.

    Parameters
    ----------
    passed : (K, N)
        Whole legs, from landmark to landmark, and the share of the present one; increasing from 0.
    legs : (L + 1,)
        Steps at which legs begin and the last one ends.
    turn_weight : float
        Length that one radian counts as, m.
    """

    passed: Array
    legs: NDArray[np.int64]
    turn_weight: float

    def given_to(self, position: Array, turn: Array | None, leave_out: bool) -> tuple[Array, Array | None]:
        """Paths (M, N, 3) and orientations (M, N, 4), or None, passed in this tempo.

        `leave_out`: M = K, each in the tempo of the others.
        """
        mean = self.passed.mean(axis=0, keepdims=True)
        if leave_out:
            mean = mean + (mean - self.passed) / (len(self.passed) - 1)
        own = way_passed(position, turn, self.legs, self.turn_weight)
        steps = np.arange(position.shape[1], dtype=float)
        wanted = np.broadcast_to(mean, own.shape)
        places = np.stack([np.interp(want, has, steps) for want, has in zip(wanted, own, strict=True)])
        index = np.minimum(places.astype(np.int64), len(steps) - 2)
        ratio = (places - index)[..., None]
        scene = np.arange(len(position))[:, None]
        paced = position[scene, index] * (1.0 - ratio) + position[scene, index + 1] * ratio
        if turn is None:
            return paced, None
        first = turn[scene, index]
        return paced, turn_by(first, turn_between(first, turn[scene, index + 1]) * ratio)


def find_tempo(position: Array, turn: Array | None, passed: Array, turn_weight: float) -> Tempo:
    """The tempo of demonstrations.

    Parameters
    ----------
    position : (K, N, 3), m
    turn : (K, N, 4), (x, y, z, w), or None
    passed : (N,)
        How many landmarks lie behind each step.
    turn_weight : float
        Length that one radian counts as, m.
    """
    changes = np.flatnonzero(np.diff(passed) > 0.0) + 1
    legs = np.unique(np.concatenate([[0], changes, [len(passed) - 1]])).astype(np.int64)
    return Tempo(way_passed(position, turn, legs, turn_weight), legs, turn_weight)


def way_passed(position: Array, turn: Array | None, legs: NDArray[np.int64], turn_weight: float) -> Array:
    """Legs passed (M, N) along paths (M, N, 3) with orientations (M, N, 4); parameters as of `Tempo`."""
    steps = position.shape[1]
    calm = smoothed(np.diff(np.moveaxis(position, 1, 0), axis=0), WINDOW * steps)
    square = np.sum(calm**2, axis=-1).T
    if turn is not None:
        square = square + turn_weight**2 * np.sum(turn_between(turn[:, :-1], turn[:, 1:]) ** 2, axis=-1)
    length = np.sqrt(square)
    passed = np.zeros((len(position), steps))
    for leg, (begin, stop) in enumerate(pairwise(legs)):
        gone = np.cumsum(length[:, begin:stop], axis=1)
        even = np.arange(1, stop - begin + 1) / (stop - begin)
        whole = gone[:, -1:]
        share = np.where(whole > 0.0, gone / np.where(whole > 0.0, whole, 1.0), even)
        passed[:, begin + 1 : stop + 1] = leg + (1.0 - EVEN) * share + EVEN * even
    return passed
