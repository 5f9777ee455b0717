"""Emission: the density of a sample at each step of each tube.

Position, direction of motion and orientation have a covariance each: normal-inverse-Wishart around a variance profile
over phase that is pooled over the library, with the posterior predictive of few demonstrations (Student t) [Dong2012]_
does not have. Floors are the library's, never a motion's; an axis that never varies anywhere is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pft_exec.geometry import Array
from pft_exec.recognition.evidence import FEW, TubeEvidence
from pft_exec.recognition.settings import PhaseSettings

Mask = NDArray[np.bool_]

GRID = 100  # phases at which variance profiles are pooled
_SMOOTHING = 0.045  # of the motion, over which a profile is averaged
_STILL = 1e-6  # of the extent (or rad): an axis that varies less anywhere in the library is left out


@dataclass(frozen=True, eq=False)
class Prior:
    """Expected covariances at each step of each tube, and the axes that count.

    Parameters
    ----------
    variance : list of (3, N)
        Variance per axis of position, direction and orientation.
    kept : (3, 3) bool
        Rows position, direction, orientation.
    """

    variance: list[Array]
    kept: Mask


@dataclass(frozen=True, eq=False)
class Emission:
    """Densities of one tube.

    Parameters
    ----------
    white : (18, N)
        Rows of the inverse Cholesky factors of the three covariances.
    log_determinant : (3, N)
        Of the three covariances, over the axes that count.
    freedom : float
        Of the Student t.
    """

    white: Array
    log_determinant: Array
    freedom: float


def kept_axes(evidence: Sequence[TubeEvidence], means: Sequence[Array], extent: float, turned: bool) -> Mask:
    """(3, 3) bool: axes of position, direction and orientation that vary somewhere in the library."""
    ranges = np.max([np.ptp(mean, axis=0) for mean in means], axis=0)
    spread = np.max([np.einsum("bnii->bni", e.scatter).max(axis=1) for e in evidence], axis=0) ** 0.5
    moving = (ranges > _STILL * extent) | (spread[0] > _STILL * extent)
    if not moving.any():
        moving[:] = True
    kept: Mask = np.stack([moving, moving, np.full(3, turned)])
    return kept


def pooled_prior(evidence: Sequence[TubeEvidence], kept: Mask, extent: float, settings: PhaseSettings) -> Prior:
    """Variance profiles over phase, pooled over the library; each tube's level is half its own."""
    floors = np.array([settings.floor * extent, settings.floor * extent, settings.rotation_floor]) ** 2
    variance = [np.tile(floors[:, None], (1, len(e.clock))) for e in evidence]
    for rows in ([0, 1], [2]):
        axes = kept[rows]
        if not axes.any():
            continue
        profiles = [
            np.einsum("bnii->bni", e.scatter[rows])[:, :, :].transpose(1, 0, 2)[:, axes].mean(axis=1)
            / max(e.count - 1, 1)
            for e in evidence
        ]
        grid = np.linspace(0.0, 1.0, GRID)
        pooled = np.mean([np.interp(grid, np.linspace(0, 1, len(p)), p) for p in profiles], axis=0)
        pooled = _smoothed(pooled)
        level = float(pooled.mean())
        for values, profile in zip(variance, profiles, strict=True):
            share = np.sqrt(float(profile.mean()) / level) if level > 0.0 else 0.0
            values[rows] += share * np.interp(np.linspace(0, 1, len(profile)), grid, pooled)
    return Prior(variance, kept)


def _smoothed(profile: Array) -> Array:
    width = max(round(_SMOOTHING * len(profile)), 1) // 2 * 2 + 1
    padded = np.pad(profile, width // 2, mode="edge")
    return np.convolve(padded, np.full(width, 1.0 / width), "valid")


def covariances(scatter: Array, count: int, variance: Array, kept: Mask, strength: float) -> Array:
    """Predictive covariances (3, N, 3, 3); axes that do not count are the identity."""
    expected = variance[:, :, None, None] * np.eye(3)
    posterior = (strength * expected + scatter) / (strength + count - 1) * (1.0 + 1.0 / max(count, 1))
    both = kept[:, None, :, None] & kept[:, None, None, :]
    result: Array = np.where(both, posterior, np.eye(3))
    return result


def whitened(covariance: Array, kept: Mask) -> tuple[Array, Array]:
    """Rows of the inverse Cholesky factors (18, N), zero where an axis does not count, and log determinants (3, N).

    Written out for 3 x 3 matrices: eight times as fast as general routines, for every tube of every scene.
    """
    xx, yy, zz = (covariance[..., a, a] for a in range(3))
    xy, xz, yz = covariance[..., 1, 0], covariance[..., 2, 0], covariance[..., 2, 1]
    a = np.sqrt(xx)
    b, c = xy / a, xz / a
    d = np.sqrt(yy - b**2)
    e = (yz - c * b) / d
    f = np.sqrt(zz - c**2 - e**2)
    low = -b / (a * d)
    inverse = [1.0 / a, low, 1.0 / d, -(c / a + e * low) / f, -e / (d * f), 1.0 / f]
    rows = [row * kept[:, axis, None] for row, axis in zip(inverse, (0, 1, 1, 2, 2, 2), strict=True)]
    white = np.stack(rows, axis=1).reshape(18, -1)
    return white, 2.0 * np.log(a * d * f)


def _excess(evidence: TubeEvidence, covariance: Array, kept: Mask) -> Array:
    """(3, N, 3, 3): what the tube's own covariance has beyond the demonstrations' scatter, the more the more there are.

    A tube of a scene that nobody demonstrated knows how wrong its ends may be; the scatter inside one scene does not.
    """
    both = kept[:, None, :, None] & kept[:, None, None, :]
    values, vectors = np.linalg.eigh(np.where(both, evidence.promised - covariance, 0.0))
    share = evidence.count / (evidence.count + FEW)
    excess: Array = share * (vectors * np.maximum(values, 0.0)[..., None, :]) @ vectors.swapaxes(-1, -2)
    return excess


def emission(evidence: TubeEvidence, variance: Array, kept: Mask, settings: PhaseSettings) -> Emission:
    """The densities of one tube."""
    strength = settings.prior_strength
    covariance = covariances(evidence.scatter, evidence.count, variance, kept, strength)
    covariance = covariance + _excess(evidence, covariance, kept)
    white, log_determinant = whitened(covariance, kept)
    return Emission(white, log_determinant, strength + max(evidence.count, 1) - 1)
