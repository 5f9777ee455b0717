"""Where the hand is and where it is heading, judged as one observation.

In the flow: a path that bows away from the mean is first beside it and then heads away from it: the residual of the
direction of motion repeats much of what the residual of the position said, most of all in the first half. Counted as
two independent observations, a bow is paid twice, and the filter is too sure of itself. So the direction is judged
given the position: the density of both is one Gaussian (then Student t), ``p(x) p(d | x)``, with the regression of d on
x learned from the demonstrations around the correlation that the library shows at each phase. A probabilistic movement
primitive [Paraschos2013]_ has this in its joint covariance of positions and velocities; the covariance between distant
phases, which it has too, is left to the tempering.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pft_exec.geometry import Array
from pft_exec.recognition.evidence import TubeEvidence
from pft_exec.recognition.profile import GRID, on_grid, smoothed

_MOST = 0.95  # correlation: the densities stay proper
_TINY = 1e-300

_LOWER = ([0, 1, 1, 2, 2, 2], [0, 0, 1, 0, 1, 2])  # the order of a factor's six rows


def pooled_correlation(evidence: Sequence[TubeEvidence]) -> Array:
    """(GRID,): correlation, per axis, of the residuals of position and direction over the phases of a library."""
    sums = np.zeros((3, GRID))
    for item in evidence:
        left, direction = item.conditioned, item.direction
        for total, a, b in zip(sums, (direction, left, direction), (left, left, direction), strict=True):
            total += on_grid(np.einsum("kni,kni->n", a, b))
    both, first, second = (smoothed(row) for row in sums)
    correlation: Array = np.clip(both / np.sqrt(np.maximum(first * second, _TINY)), -_MOST, _MOST)
    return correlation


def couple(covariance: Array, cross: Array, white: Array) -> tuple[Array, Array]:
    """The covariance of the direction once the position is known, and the regression that says so.

    Parameters
    ----------
    covariance : (N, 3, 3)
        Of the direction.
    cross : (N, 3, 3)
        Covariance of direction (rows) and position (columns).
    white : (6, N)
        Rows of the inverse Cholesky factor of the position's covariance.

    Returns
    -------
    gain : (N, 3, 3)
        Expected residual of the direction for each unit of the position's.
    left : (N, 3, 3)
        Covariance of the direction around that.
    """
    factor = np.zeros_like(cross)
    factor[:, _LOWER[0], _LOWER[1]] = white.T
    half = cross @ factor.swapaxes(-1, -2)
    return half @ factor, covariance - half @ half.swapaxes(-1, -2)
