"""Where a tool is at a given time: a flow tube's spread at a place of the motion, together with that of its timing.

A tube's covariance says how far demonstrations are aside at the same place of the motion. Over time that is not all:
who is late is elsewhere. Here a path passes step n at ``time[n] + z * time_deviation[n]``, late everywhere by the same
standard normal number z; the deviation aside is normal as well.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr, ndtri

from pft_exec.geometry import Array
from pft_exec.learning import FlowTube

_NODES = 101  # equally probable values of lateness
_INSTANTS = 120
_HALVINGS = 30


def band_over_time(tube: FlowTube, axis: int, sigmas: float) -> tuple[Array, Array, Array]:
    """Between what bounds one axis of the tool lies at each time.

    Parameters
    ----------
    tube : FlowTube
    axis : int
    sigmas : float
        The bounds hold as much as so many standard deviations of a Gaussian.

    Returns
    -------
    time, low, high : (M,), s and m
        Until the last path that counts has ended.
    """
    spread = np.zeros(len(tube)) if tube.time_deviation is None else tube.time_deviation
    time: Array = np.linspace(0.0, float(tube.time[-1] + sigmas * spread[-1]), _INSTANTS)
    late = ndtri((np.arange(_NODES) + 0.5) / _NODES)
    passed = np.maximum.accumulate(tube.time + late[:, None] * spread, axis=1)
    deviation = np.sqrt(tube.covariance[:, axis, axis])
    mean, aside = (
        np.array([np.interp(time, when, values) for when in passed]) for values in (tube.position[:, axis], deviation)
    )
    return time, _quantile(mean, aside, ndtr(-sigmas)), _quantile(mean, aside, ndtr(sigmas))


def _quantile(mean: Array, deviation: Array, probability: float) -> Array:
    """Of mixtures (M,) of P equally probable Gaussians each, (P, M), by halving an interval."""
    reach = abs(float(ndtri(probability))) * deviation
    low, high = (mean - reach).min(axis=0), (mean + reach).max(axis=0)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        is_below = ndtr((middle - mean) / deviation).mean(axis=0) < probability
        low, high = np.where(is_below, middle, low), np.where(is_below, high, middle)
    found: Array = 0.5 * (low + high)
    return found
