"""The covariance of a tube from a handful of residuals: shrunk to a variance profile, and predictive.

Five demonstrations do not estimate a covariance. A normal-inverse-Wishart prior of a few degrees of freedom around the
isotropic variance of the neighboring steps takes the place of what they leave open; the predictive distribution is then
a Student t, whose covariance this is.
"""

from __future__ import annotations

import numpy as np

from pft_exec.geometry import Array
from pft_exec.learning.smoothing import smoothed

PRIOR_DEGREES = 4.0  # weight of the prior, in demonstrations
WINDOW = 0.05  # of the motion, over which the variance profile is averaged
GROWTH = (0.5, 2.0)  # bounds of the variance in a new scene, in units of the demonstrated one
POOLED = 0.25  # share of the level of the whole motion in the profile (geometric): one step tells little


def residual_covariance(residual: Array, floor: float, turn_floor: float) -> Array:
    """Covariance (N, 3, 3) or (N, 6, 6) of leave-one-out residuals (K, N, 3 or 6), m and rad; positive definite.

    Parameters
    ----------
    residual : (K, N, 3) or (K, N, 6)
        Position, then rotation vector.
    floor, turn_floor : float
        Smallest standard deviations, m and rad.
    """
    count, steps, size = residual.shape
    squares = np.mean(residual**2, axis=0)
    blocks = [(slice(0, 3), floor)] + ([(slice(3, 6), turn_floor)] if size == 6 else [])
    prior = np.empty((steps, size))
    least = np.empty(size)
    for block, smallest in blocks:
        active = max(int(np.sum(squares[:, block].max(axis=0) > 1e-6 * squares[:, block].max())), 1)
        own = smoothed(squares[:, block].sum(axis=1) / active, WINDOW * steps) + smallest**2
        prior[:, block] = (own ** (1.0 - POOLED) * own.mean() ** POOLED)[:, None]
        least[block] = smallest
    scatter = np.einsum("kni,knj->nij", residual, residual)
    shrunk = (scatter + PRIOR_DEGREES * prior[:, :, None] * np.eye(size)) / (count + PRIOR_DEGREES)
    degrees = count + PRIOR_DEGREES
    covariance: Array = shrunk * degrees / (degrees - 2.0) + np.diag(least**2)
    return covariance


def carried_covariance(covariance: Array, residual: Array, carried: Array, floor: float) -> Array:
    """The covariance in another scene, where the residuals of the positions are others.

    Parameters
    ----------
    covariance : (N, 3, 3) or (N, 6, 6), m^2, rad^2
    residual, carried : (K, N, 3), m
        In the demonstrated scenes, and as they would be in the other one.
    floor : float
        Standard deviation below which places count as equal, m.

    Notes
    -----
    Scaled, not estimated anew: a handful of residuals says how the scatter grows better than how it is turned.
    """
    width = WINDOW * residual.shape[1]
    before, after = (smoothed(np.mean(np.sum(r**2, axis=2), axis=0), width) + floor**2 for r in (residual, carried))
    deviation = np.ones(covariance.shape[:2])
    deviation[:, :3] = np.sqrt(np.clip(after / before, *GROWTH))[:, None]
    return covariance * deviation[:, :, None] * deviation[:, None, :]
