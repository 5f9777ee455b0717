r"""Which frame explains each end of a motion best: a competition of frames with a posterior.

Derivation (ours). Seen in frame :math:`f`, one end of K demonstrations leaves a sum of squares :math:`S_f` about its
mean with :math:`\nu = d (K - 1)` degrees of freedom. All frames are rigid motions of one another, so likelihoods
:math:`\sigma^{-\nu} \exp(-S_f / 2 \sigma^2)` of different frames compare directly: the ratio of two is the F test of
their variances. A relevant frame holds the end as precisely as a demonstrator works, :math:`\sigma \sim` log-normal
about :math:`\sigma_r`, which both ends of the motion share; where nothing is relevant the end scatters in the world
with a :math:`\sigma` of the order of the motion. Both are marginalized on a grid, in units of the extent of the motion
(radians for orientation), so that a change of units changes nothing. A motion without a target does not contract: an
end that is much narrower than its start is unlikely to be free.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from pft_exec.geometry import Array
from pft_exec.learning.frames import Candidate
from pft_exec.learning.variables import ABSOLUTE, NONE, START

PRECISION = 0.015  # median standard deviation per axis of a relevant end, in extents; prior, spread over decades
PRECISION_LOG_DEVIATION = 0.6
SHARED_LOG_DEVIATION = 0.4  # how far the precisions of the two ends of one motion lie apart
SCATTER = 0.15  # median standard deviation per axis of an end that nothing determines, in extents; prior
SCATTER_LOG_DEVIATION = 0.5
CONTRACTION_WIDTH = 0.25  # log units over which a free end narrower than its start becomes unlikely
FLOOR = 0.002  # in extents: a spread below it is as good as none
PRIOR = {NONE: 2.0, ABSOLUTE: 1.0, START: 1.0, "objects": 1.0}  # before seeing the data; all objects share theirs
APART = 0.1  # times that: an object that turns the tool, but does not hold its place at that end
DECISIVE = 0.8  # posterior below which a decision counts as ambiguous
TURN_EXTENT = 1.0  # rad, the extent that orientations are measured by
TURN_SCATTER = 0.08  # rad, `SCATTER` of orientations: a hand that may hold the tool anyhow still holds it naturally

FLAT = 0.1  # of the widest axis: an axis narrower than it is one along which an end does not scatter

_GRID = np.linspace(np.log(2e-4), np.log(2.0), 120)


@dataclass(frozen=True, eq=False)
class Evidence:
    """Posterior of the candidates at one end.

    Parameters
    ----------
    candidates : list of C candidates
    posterior : (C + 1,)
        The last entry is "none".
    """

    candidates: Sequence[Candidate]
    posterior: Array

    def by_name(self) -> dict[str, float]:
        """Posterior of each name, its kinds of axes added up; "" is none."""
        total: dict[str, float] = {}
        for candidate, probability in zip(self.candidates, self.posterior, strict=False):
            total[candidate.name] = total.get(candidate.name, 0.0) + float(probability)
        return total | {NONE: float(self.posterior[-1])}


def _log_normal(log_value: Array, log_median: Array | float, deviation: float) -> Array:
    density: Array = np.exp(-0.5 * ((log_value - log_median) / deviation) ** 2)
    weights: Array = density / density.sum(axis=-1, keepdims=True)
    return weights


_AROUND = _log_normal(_GRID[None, :], _GRID[:, None], SHARED_LOG_DEVIATION)
_SHARED = _log_normal(_GRID, np.log(PRECISION), PRECISION_LOG_DEVIATION)


def _log_likelihoods(candidates: Sequence[Candidate], extent: float, dimension: int) -> Array:
    """(C, G): log likelihood of each candidate on the grid of standard deviations, in extents."""
    degrees = dimension * (len(candidates[0].residual) - 1)
    squares = np.array([np.sum(c.residual**2) for c in candidates]) / extent**2 + degrees * FLOOR**2
    return -degrees * _GRID - 0.5 * squares[:, None] * np.exp(-2.0 * _GRID)


def _prior(names: Sequence[str], near: Collection[str] | None) -> Array:
    """(C,): prior weight of each candidate; kinds of axes share that of their frame.

    `near` are the frames that hold the place at this end, None where this is about the place.
    """
    objects = len(set(names) - {ABSOLUTE, START})
    prior = np.array([PRIOR.get(n, PRIOR["objects"] / max(objects, 1)) / names.count(n) for n in names])
    if near is not None:
        prior *= [1.0 if n in (ABSOLUTE, START) or n in near else APART for n in names]
    return prior


def _scatter(other: float, median: float) -> Array:
    """(G,): prior of the standard deviation of a free end whose motion began with `other`, both in extents."""
    scatter = _log_normal(_GRID, np.log(median), SCATTER_LOG_DEVIATION)
    narrower = (np.log(max(other, FLOOR)) - _GRID) / CONTRACTION_WIDTH
    weights: Array = scatter / (1.0 + np.exp(np.clip(narrower, -50.0, 50.0)))
    return weights


def _hypotheses(
    candidates: Sequence[Candidate], prior: Array, extent: float, dimension: int, other: float, scatter: float
) -> Array:
    """(C + 1, G): prior times likelihood of each hypothesis, given each shared precision; none comes last."""
    log_likelihood = _log_likelihoods(candidates, extent, dimension)
    likelihood = np.exp(log_likelihood - log_likelihood.max())
    names = [c.name for c in candidates]
    tied = prior[:, None] * (likelihood @ _AROUND.T)
    free = PRIOR[NONE] * float(likelihood[names.index(ABSOLUTE)] @ _scatter(other, scatter))
    return np.vstack([tied, np.full(len(_GRID), free)])


def _dimension(end: Sequence[Candidate], extent: float) -> int:
    """Number of axes along which an end scatters at all, in the frame where it is largest; at least one.

    An axis that no frame lets vary, as the height over a table, tells no frame from another: counted, it would pass for
    a precision that every frame shares.
    """
    scatter = np.linalg.svd(np.stack([c.residual for c in end]), compute_uv=False)
    seen = np.sum(scatter > np.maximum(FLAT * scatter[:, :1], 1e-9 * extent), axis=1).max()
    dimension = max(int(min(seen, 3)), 1)
    if len(end[0].residual) - 1 < 3:
        dimension = max(dimension, int(np.sum(np.any([np.ptp(c.residual, 0) > 0 for c in end], axis=0))))
    return dimension


def weigh_frames(
    ends: Sequence[Sequence[Candidate]],
    extent: float,
    scatter: float = SCATTER,
    near: Sequence[Collection[str] | None] = (None, None),
) -> list[Evidence]:
    """Posterior of the frames at the ends of one motion, which share a precision.

    Parameters
    ----------
    ends : candidates of the start, then of the end
    extent : float
        Size of the motion, m; `TURN_EXTENT` rad for orientations.
    scatter : float
        Median standard deviation per axis of an end that nothing determines, in extents.
    near : for each end, the frames that hold the place there, where this is about orientation
    """
    dimensions = [_dimension(end, extent) for end in ends]
    before = [0.0] + [e[0].spread / np.sqrt(d) / extent for e, d in zip(ends[:-1], dimensions, strict=False)]
    priors = [_prior([c.name for c in end], held) for end, held in zip(ends, near, strict=True)]
    hypotheses = [
        _hypotheses(end, prior, extent, dimension, other, scatter)
        for end, prior, dimension, other in zip(ends, priors, dimensions, before, strict=True)
    ]
    found = []
    for index, end in enumerate(ends):
        others = np.prod([h.sum(axis=0) for i, h in enumerate(hypotheses) if i != index], axis=0)
        posterior = (hypotheses[index] * _SHARED * others).sum(axis=1)
        found.append(Evidence(end, posterior / posterior.sum()))
    return found


def choose_frame(evidence: Evidence, near: float) -> tuple[str, tuple[str, ...]]:
    """The frame an end is tied to, and every frame (or "") that the demonstrations do not rule out.

    Parameters
    ----------
    evidence : Evidence
    near : float
        An object closer than this to the end is what a person would take the motion to be about, m; 0 where
        distance says nothing.
    """
    by_name = evidence.by_name()
    best = max(by_name, key=lambda name: by_name[name])
    if by_name[best] >= DECISIVE or best == NONE:
        return best, (best, *(n for n, p in by_name.items() if n != best and p > 1.0 - DECISIVE))
    rivals = [n for n, p in by_name.items() if p > 0.1 * by_name[best]]
    distance = {c.name: float(np.linalg.norm(c.offset)) for c in evidence.candidates}
    close = [n for n in rivals if n not in (ABSOLUTE, START, NONE) and distance[n] < near]
    if close:
        best = min(close, key=lambda name: distance[name])
    else:
        best = next((name for name in (ABSOLUTE, START) if name in rivals), best)
    return best, (best, *(n for n in rivals if n != best))
