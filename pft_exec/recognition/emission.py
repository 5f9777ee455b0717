"""Emission: the density of a sample at each step of each tube.

Position, direction of motion given the position, and orientation have a covariance each: normal-inverse-Wishart around
a variance profile over phase that is pooled over the library, with the posterior predictive of few demonstrations
(Student t) [Dong2012]_ does not have. Floors are the library's, never a motion's; an axis that never varies anywhere is
left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pft_exec.geometry import Array
from pft_exec.recognition.coupling import couple, pooled_correlation
from pft_exec.recognition.evidence import FEW, TubeEvidence
from pft_exec.recognition.profile import from_grid, on_grid, smoothed
from pft_exec.recognition.settings import PhaseSettings

Mask = NDArray[np.bool_]

_STILL = 1e-6  # of the extent (or rad): an axis that varies less anywhere in the library is left out


@dataclass(frozen=True, eq=False)
class Prior:
    """Expected covariances at each step of each tube, and the axes that count.

    Parameters
    ----------
    variance : list of (3, N)
        Variance per axis of position, direction and orientation.
    cross : list of (N,)
        Covariance per axis of position and direction.
    kept : (3, 3) bool
        Rows position, direction, orientation.
    floor : (3,)
        The part of every variance that stands for what no demonstration can show: the library's floor.
    """

    variance: list[Array]
    cross: list[Array]
    kept: Mask
    floor: Array

    def floor_share(self, evidence: TubeEvidence, tube: int, strength: float) -> float:
        """How much of a tube's predictive variances the floor makes up, the mean over phase and the axes that count."""
        scatter = np.einsum("bnii->bin", evidence.scatter)
        held = strength * self.variance[tube][:, None] + scatter
        variance = held / (strength + evidence.count - 1) * (1.0 + 1.0 / max(evidence.count, 1))
        return float((self.floor[:, None, None] / variance)[self.kept].mean())


@dataclass(frozen=True, eq=False)
class Emission:
    """Densities of one tube.

    Parameters
    ----------
    white : (18, N)
        Rows of the inverse Cholesky factors of the three covariances; that of the direction is given the position.
    gain : (9, N)
        Rows of the regression of the direction's residual on the position's.
    log_determinant : (3, N)
        Of the three covariances, over the axes that count.
    freedom : float
        Of the Student t.
    """

    white: Array
    gain: Array
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
        pooled = smoothed(np.mean([on_grid(profile) for profile in profiles], axis=0))
        level = float(pooled.mean())
        for values, profile in zip(variance, profiles, strict=True):
            share = np.sqrt(float(profile.mean()) / level) if level > 0.0 else 0.0
            values[rows] += share * from_grid(pooled, len(profile))
    return Prior(variance, _expected_cross(evidence, variance), kept, floors)


def _expected_cross(evidence: Sequence[TubeEvidence], variance: Sequence[Array]) -> list[Array]:
    """Covariances (N,) of position and direction; none where there are no demonstrations that show it."""
    correlation = pooled_correlation(evidence)
    return [
        from_grid(correlation, len(e.clock)) * np.sqrt(v[0] * v[1]) * float(len(e.position) > 0)
        for e, v in zip(evidence, variance, strict=True)
    ]


def covariances(scatter: Array, count: int, variance: Array, kept: Mask, strength: float) -> Array:
    """Predictive covariances (3, N, 3, 3); axes that do not count are the identity."""
    posterior = predictive(scatter, count, variance, strength)
    both = kept[:, None, :, None] & kept[:, None, None, :]
    result: Array = np.where(both, posterior, np.eye(3))
    return result


def predictive(scatter: Array, count: int, expected: Array, strength: float) -> Array:
    """(..., 3, 3): scatter around an expected multiple (...) of the identity, and a mean known from `count` only."""
    held = strength * expected[..., None, None] * np.eye(3)
    result: Array = (held + scatter) / (strength + count - 1) * (1.0 + 1.0 / max(count, 1))
    return result


def tail_freedom(count: int, settings: PhaseSettings) -> float:
    """Degrees of freedom of the Student t that `count` demonstrations leave."""
    return min(settings.prior_strength + max(count, 1) - 1.0, settings.most_freedom)


def whitened(covariance: Array, kept: Mask) -> tuple[Array, Array]:
    """Rows of B inverse Cholesky factors (6 B, N), zero where an axis does not count, and log determinants (B, N).

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
    white = np.stack(rows, axis=1).reshape(6 * len(covariance), -1)
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


def coupled(covariance: Array, cross: Array, kept: Mask) -> tuple[Array, Array, Array]:
    """Whitening (18, N), log determinants (3, N) and gain (9, N), for covariances whose direction knows the position.

    Parameters
    ----------
    covariance : (3, N, 3, 3)
    cross : (N, 3, 3)
        Covariance of direction (rows) and position (columns).
    kept : (3, 3) bool
    """
    white, log_determinant = whitened(covariance[::2], kept[::2])
    gain, left = couple(covariance[1], cross * (kept[1][:, None] & kept[0]), white[:6])
    white_direction, log_direction = whitened(left[None], kept[1:2])
    return (
        np.concatenate([white[:6], white_direction, white[6:]]),
        np.stack([log_determinant[0], log_direction[0], log_determinant[1]]),
        np.ascontiguousarray(gain.reshape(-1, 9).T),
    )


def emission(evidence: TubeEvidence, prior: Prior, tube: int, settings: PhaseSettings) -> Emission:
    """The densities of one tube, the library's number `tube`."""
    strength, kept, count = settings.prior_strength, prior.kept, evidence.count
    covariance = covariances(evidence.scatter, count, prior.variance[tube], kept, strength)
    covariance = covariance + _excess(evidence, covariance, kept)
    cross = predictive(evidence.cross, count, prior.cross[tube], strength)
    white, log_determinant, gain = coupled(covariance, cross, kept)
    return Emission(white, gain, log_determinant, tail_freedom(count, settings))
