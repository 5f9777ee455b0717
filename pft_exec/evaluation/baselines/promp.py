r"""Probabilistic movement primitives: a Gaussian over basis weights per label, scored by the likelihood of the prefix.

The weights' distribution is learned by the movement_primitives library [Fabisch2024]_. A recording's pace is unknown
while it is under way, so each label is scored at several durations, which count alike. For one duration the samples
are jointly Gaussian; with the Cholesky factor of their covariance, the likelihoods of all prefixes come from one
triangular solve, since the factor of a prefix is the prefix of the factor.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from movement_primitives.promp import ProMP
from scipy.linalg import solve_triangular

from pft_exec.demonstration import Demonstration
from pft_exec.evaluation.trace import Trace, grouped, moving_axes, softmax
from pft_exec.geometry import Array

WEIGHTS = 12  # basis functions per axis; a circle needs about 8
PACES = 7  # durations at which a label is scored
PACE_MARGIN = 1.35  # how far the durations reach beyond the fastest and slowest demonstration
NOISE = 0.01  # of the motions' median extent: standard deviation of a sample about its primitive
_GRID = 400  # phases at which a primitive's mean and covariance are tabulated


@dataclass(frozen=True, eq=False)
class Primitive:
    """One label: mean (G, d) and basis covariance factor (G, d, r) at G even phases, and its durations (s)."""

    mean: Array
    factor: Array
    durations: Array


@dataclass(frozen=True, eq=False)
class ProMPClassifier:
    """A primitive per label; `noise` (m) is the standard deviation of a sample about its primitive."""

    primitives: dict[str, Primitive]
    axes: list[int]
    noise: float
    _factors: dict[tuple[str, int, bytes], tuple[Array, Array]] = field(default_factory=dict)

    def recognize(self, demonstration: Demonstration) -> Trace:
        """Likelihood of each prefix under each label, averaged over the candidate durations."""
        points = demonstration.position[:, self.axes]
        clock = demonstration.time - demonstration.time[0]
        begin = time.perf_counter()
        scores = np.stack([self._score(label, clock, points) for label in self.primitives], axis=1)
        seconds = (time.perf_counter() - begin) / len(points)
        strangeness = -scores.max(axis=1) / np.arange(1, len(points) + 1)
        return Trace(tuple(self.primitives), scores, softmax(scores), strangeness, seconds)

    def _score(self, label: str, clock: Array, points: Array) -> Array:
        """Log density of ``points[:t + 1]`` (T,) with the durations averaged out."""
        scores = []
        for pace in range(PACES):
            mean, factor = self._gaussian(label, pace, clock)
            whitened = solve_triangular(factor, (points - mean).ravel(), lower=True, check_finite=False)
            terms = -0.5 * whitened**2 - np.log(np.diag(factor)) - 0.5 * np.log(2.0 * np.pi)
            scores.append(np.cumsum(terms.reshape(points.shape).sum(axis=1)))
        top = np.max(scores, axis=0)
        averaged: Array = top + np.log(np.mean(np.exp(np.array(scores) - top), axis=0))
        return averaged

    def _gaussian(self, label: str, pace: int, clock: Array) -> tuple[Array, Array]:
        """Mean (T, d) and Cholesky factor (T d, T d) of the samples at times `clock`; kept for the next recording."""
        key = (label, pace, np.round(np.diff(clock[:2]), 9).tobytes())
        kept = self._factors.get(key)
        even = np.allclose(np.diff(clock), clock[1] - clock[0], rtol=1e-6)
        if kept is None or len(kept[0]) < len(clock) or not even:
            kept = self._fresh(self.primitives[label], pace, clock)
            if even:
                self._factors[key] = kept
        size = len(clock) * len(self.axes)
        return kept[0][: len(clock)], kept[1][:size, :size]

    def _fresh(self, primitive: Primitive, pace: int, clock: Array) -> tuple[Array, Array]:
        place = np.clip(clock / primitive.durations[pace], 0.0, 1.0) * (_GRID - 1)
        index = np.round(place).astype(int)
        factor = primitive.factor[index].reshape(len(clock) * len(self.axes), -1)
        covariance = factor @ factor.T + self.noise**2 * np.eye(len(factor))
        return primitive.mean[index], np.linalg.cholesky(covariance)


def learn_promp(demonstrations: Sequence[Demonstration]) -> ProMPClassifier:
    """Learn one primitive per label."""
    axes = moving_axes(demonstrations)
    extent = float(np.median([np.linalg.norm(np.ptp(item.position, axis=0)) for item in demonstrations]))
    primitives = {label: _primitive(group, axes, extent) for label, group in grouped(demonstrations).items()}
    return ProMPClassifier(primitives, axes, NOISE * extent)


def _primitive(group: Sequence[Demonstration], axes: list[int], extent: float) -> Primitive:
    """Learned in units of `extent`, since the library's EM begins at unit variances."""
    phases = [(item.time - item.time[0]) / item.duration for item in group]
    model = ProMP(n_dims=len(axes), n_weights_per_dim=WEIGHTS)
    model.imitate(phases, [item.position[:, axes] / extent for item in group])
    grid = np.linspace(0.0, 1.0, _GRID)
    durations = np.array([item.duration for item in group])
    paces = np.geomspace(durations.min() / PACE_MARGIN, durations.max() * PACE_MARGIN, PACES)
    return Primitive(extent * model.mean_trajectory(grid), extent * _factor(model, grid, len(axes)), paces)


def _factor(model: ProMP, grid: Array, size: int) -> Array:
    """(G, d, r): its product with its own transpose is the covariance of the trajectory; r is the rank that counts.

    The library gives the covariance of all grid points at once, axis by axis; its leading eigenvectors are the factor.
    """
    coarse = grid[:: max(1, len(grid) // 100)]
    covariance = model.cov_trajectory(coarse)
    values, vectors = np.linalg.eigh(0.5 * (covariance + covariance.T))
    keep = values > 1e-9 * max(float(values[-1]), 1e-300)
    rooted = (vectors[:, keep] * np.sqrt(values[keep])).reshape(size, len(coarse), -1)
    fine = [[np.interp(grid, coarse, rooted[i, :, r]) for r in range(rooted.shape[2])] for i in range(size)]
    return np.moveaxis(np.array(fine), 2, 0)
