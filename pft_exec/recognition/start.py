"""Where a motion began: counted once, and remembered along the way.

In the flow: a demonstration that began off the mean is off it for a while. Each sample of such a stream would pay for
the same offset again, and the more so the narrower the motion. So the first sample is judged by how widely the motion's
starts are spread, and after it the tube leans towards it by as much as the demonstrations kept of theirs; what is left
of their residuals is what the samples after it are judged by.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import digamma, gammaln

from pft_exec.geometry import Array
from pft_exec.recognition.evidence import TubeEvidence
from pft_exec.recognition.settings import PhaseSettings

Integers = NDArray[np.int64]

GRID = 100  # phases at which the library's mean is taken
_NONE = 1e-12  # of the library's start variance: starts that differ less are all the same
_FAR = 3.0  # standard deviations up to which a start is an offset; beyond them the hand may come to the learned start


@dataclass(frozen=True, eq=False)
class StartModel:
    """Where J components begin.

    Parameters
    ----------
    white : (J, 3, 3)
        Inverse Cholesky factors of the starts' covariances, zero where an axis does not count.
    log_scale : (J,)
        Log normalizer of the density of the start.
    usual : (J,)
        Its expected log density: what a start costs a motion whose tube begins wherever the hand does.
    known : (J,) bool
        Whether the motion has starts of its own; else its tube began where the hand is, and says nothing of it.
    freedom : (J,)
    size : int
        Axes that count.
    weight : float
        What a start is worth, in independent observations.
    """

    white: Array
    log_scale: Array
    usual: Array
    known: NDArray[np.bool_]
    freedom: Array
    size: int
    weight: float

    def judge(self, offset: Array) -> tuple[Array, Array]:
        """Evidence (J,) of starts that are off the means by `offset` (J, 3), m; and the part (J, 3) to lean by."""
        square = (np.einsum("jab,jb->ja", self.white, offset) ** 2).sum(axis=1)
        said = self.log_scale - 0.5 * (self.freedom + self.size) * np.log1p(square / self.freedom)
        level = self.usual[self.known].mean() if self.known.any() else 0.0
        said = np.where(self.known, said, level)
        near = np.minimum(1.0, _FAR / np.sqrt(np.maximum(square, 1e-12)))
        return self.weight * said, offset * near[:, None]


def follow_starts(evidence: Sequence[TubeEvidence], settings: PhaseSettings) -> list[TubeEvidence]:
    """Learn how much of a residual at the start is left at each step, and take that part out of the scatter.

    One share for all axes, regressed over the motion's demonstrations around the one of the whole library.
    """
    cross = [_products_with_start(e) for e in evidence]
    power = np.array([products[0] for products in cross])
    total = float(power.sum())
    if total <= 0.0:
        return list(evidence)
    grid = np.linspace(0.0, 1.0, GRID)
    pooled = np.sum([np.interp(grid, np.linspace(0.0, 1.0, len(c)), c) for c in cross], axis=0) / total
    held = settings.prior_strength * total / sum(e.count - 1 for e, p in zip(evidence, power, strict=True) if p > 0.0)
    result = []
    for item, products, own in zip(evidence, cross, power, strict=True):
        expected = np.interp(np.linspace(0.0, 1.0, len(products)), grid, pooled)
        share = np.clip((products + held * expected) / (own + held), 0.0, 1.0)
        result.append(_without_start(item, share) if own > _NONE * total else item)
    return result


def _products_with_start(evidence: TubeEvidence) -> Array:
    """(N,): inner products of the residuals at each step with those at the start, summed over demonstrations."""
    if len(evidence.position) < 2:
        return np.zeros(len(evidence.clock))
    products: Array = np.einsum("kni,ki->n", evidence.position, evidence.position[:, 0])
    return products


def _without_start(evidence: TubeEvidence, share: Array) -> TubeEvidence:
    result = replace(evidence, follow=share, scatter=evidence.scatter.copy())
    left = result.conditioned
    result.scatter[0] = np.einsum("kni,knj->nij", left, left)
    return result


def learn_starts(
    evidence: Sequence[TubeEvidence],
    which: Integers,
    axes: NDArray[np.bool_],
    extent: float,
    settings: PhaseSettings,
) -> StartModel:
    """Densities of the starts of components that belong to the motions `which`; `axes` (3,) count."""
    size = int(axes.sum())
    freedom = np.array([settings.prior_strength + max(e.count, 1) - 1 for e in evidence])
    factors = [np.linalg.cholesky(_start_covariance(e, axes, extent, settings)) for e in evidence]
    half = 0.5 * (freedom + size)
    scale = gammaln(half) - gammaln(0.5 * freedom) - 0.5 * size * np.log(np.pi * freedom)
    scale -= np.array([np.log(np.diagonal(factor)).sum() for factor in factors])
    rows = np.asarray(which)
    return StartModel(
        white=np.stack([np.linalg.inv(factor) * axes[:, None] for factor in factors])[rows],
        log_scale=scale[rows],
        usual=(scale - half * (digamma(half) - digamma(0.5 * freedom)))[rows],
        known=np.array([bool(e.follow[0] > 0.0) for e in evidence])[rows],
        freedom=freedom[rows],
        size=size,
        weight=settings.start_evidence,
    )


def _start_covariance(evidence: TubeEvidence, axes: NDArray[np.bool_], extent: float, settings: PhaseSettings) -> Array:
    """(3, 3): predictive covariance of where a motion starts; axes that do not count are the identity."""
    scatter, strength, count = evidence.scatter[0, 0], settings.prior_strength, max(evidence.count, 1)
    if len(evidence.position):
        scatter = np.einsum("ki,kj->ij", evidence.position[:, 0], evidence.position[:, 0])
    level = float(np.diagonal(scatter)[axes].mean()) / max(count - 1, 1) + (settings.floor * extent) ** 2
    covariance = (strength * level * np.eye(3) + scatter) / (strength + count - 1) * (1.0 + 1.0 / count)
    result: Array = np.where(axes[:, None] & axes, covariance, np.eye(3))
    return result
