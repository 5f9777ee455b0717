"""The covariance of a tube from a handful of residuals: shrunk to a variance profile, and predictive.

Five demonstrations do not estimate a covariance. A normal-inverse-Wishart prior of a few degrees of freedom around the
isotropic variance of the neighboring steps takes the place of what they leave open; the predictive distribution is then
a Student t, whose covariance this is.

Of what a residual is there are two accounts. In one it is an error of places, in the axes of the world. In the other
it is an error of places across the way, and of timing along it, which is several times as large and turns with the way
in each scene; an isotropic prior is too wide across and too narrow along it. Which one holds differs from motion to
motion, and neither is right alone: both are believed alike (`Spread`), and the covariance is that of their mixture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pft_exec.geometry import Array
from pft_exec.learning.smoothing import smoothed

PRIOR_DEGREES = 4.0  # weight of the prior, in demonstrations
WINDOW = 0.05  # of the motion, over which the variance profile is averaged
GROWTH = (0.5, 2.0)  # bounds of the variance in a new scene, in units of the demonstrated one
POOLED = 0.25  # share of the level of the whole motion in the profile (geometric): one step tells little


@dataclass(frozen=True, eq=False)
class Spread:
    """What a blend leaves of demonstrations, by either account.

    Parameters
    ----------
    world : (N, 3, 3) or (N, 6, 6), m^2, rad^2
        Covariance in the axes of the world.
    across : (N, 3, 3) or (N, 6, 6), m^2, rad^2
        Of what remains once the part along the way is taken out.
    along : (N,), m^2
        Variance along the way.
    """

    world: Array
    across: Array
    along: Array

    def mixed(self, other: Spread, share: float) -> Spread:
        """Both by the share in [0, 1] that is the other."""
        pairs = zip((self.world, self.across, self.along), (other.world, other.across, other.along), strict=True)
        return Spread(*((1.0 - share) * own + share * theirs for own, theirs in pairs))

    def in_scene(self, path: Array, residual: Array, carried: Array, floor: float) -> Array:
        """Covariance (N, 3, 3) or (N, 6, 6) along the path (N, 3), m, of a scene; others as of `carried_covariance`."""
        world, across = (carried_covariance(c, residual, carried, floor) for c in (self.world, self.across))
        way = directions_of(path[None])[0]
        known = np.einsum("ni,nij,nj->n", way, across[:, :3, :3], way)
        missing = np.maximum(growth(residual, carried, floor) * self.along - known, 0.0)
        across[:, :3, :3] += missing[:, None, None] * way[:, :, None] * way[:, None, :]
        covariance: Array = 0.5 * (world + across)
        return covariance


def directions_of(path: Array) -> Array:
    """Unit directions (M, N, 3) of paths (M, N, 3); zero where a path stands."""
    step = np.gradient(path, axis=1)
    length = np.linalg.norm(step, axis=-1, keepdims=True)
    directions: Array = step / np.where(length > 0.0, length, 1.0)
    return directions


def find_spread(residual: Array, path: Array, floor: float, turn_floor: float) -> Spread:
    """Both accounts of residuals (K, N, 3 or 6), m and rad, from paths (K, N, 3), m; floors as below."""
    way = directions_of(path)
    along = np.sum(residual[..., :3] * way, axis=-1)
    across = residual.copy()
    across[..., :3] -= along[..., None] * way
    count, steps = along.shape
    square = np.mean(along**2, axis=0)
    own = smoothed(square, WINDOW * steps) + floor**2
    prior = own ** (1.0 - POOLED) * own.mean() ** POOLED
    variance = (count * square + PRIOR_DEGREES * prior) / (count + PRIOR_DEGREES - 2.0) + floor**2
    return Spread(
        residual_covariance(residual, floor, turn_floor),
        residual_covariance(across, floor, turn_floor, taken_out=1),
        variance,
    )


def residual_covariance(residual: Array, floor: float, turn_floor: float, taken_out: int = 0) -> Array:
    """Covariance (N, 3, 3) or (N, 6, 6) of leave-one-out residuals (K, N, 3 or 6), m and rad; positive definite.

    Parameters
    ----------
    residual : (K, N, 3) or (K, N, 6)
        Position, then rotation vector.
    floor, turn_floor : float
        Smallest standard deviations, m and rad.
    taken_out : int
        Directions along which the positions have no residual any more.
    """
    count, steps, size = residual.shape
    squares = np.mean(residual**2, axis=0)
    blocks = [(slice(0, 3), floor)] + ([(slice(3, 6), turn_floor)] if size == 6 else [])
    prior = np.empty((steps, size))
    least = np.empty(size)
    for block, smallest in blocks:
        active = int(np.sum(squares[:, block].max(axis=0) > 1e-6 * squares[:, block].max()))
        active = max(active - (taken_out if block.start == 0 else 0), 1)
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
    deviation = np.ones(covariance.shape[:2])
    deviation[:, :3] = np.sqrt(growth(residual, carried, floor))[:, None]
    return covariance * deviation[:, :, None] * deviation[:, None, :]


def growth(residual: Array, carried: Array, floor: float) -> Array:
    """(N,): how many times as large the variance of positions is in another scene, as of `carried_covariance`."""
    width = WINDOW * residual.shape[1]
    before, after = (smoothed(np.mean(np.sum(r**2, axis=2), axis=0), width) + floor**2 for r in (residual, carried))
    times: Array = np.clip(after / before, *GROWTH)
    return times
