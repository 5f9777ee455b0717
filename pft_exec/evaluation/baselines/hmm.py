r"""The paper's baseline: one tied-mixture hidden Markov model per motion.

All states share one pool of Gaussians and each has its own weights over it:
:math:`b_j(x) = \sum_m c_{jm} N(x; \mu_m, \Sigma_m)`. [Dong2012]_, section 6, found 3 states and 6 Gaussians to work
reasonably; features are the tool's coordinates in the world. Topology and score are not stated: both topologies exist
here, and a prefix is scored by its filtered likelihood (the forward variables), which needs no look-ahead. Forward and
backward passes are hmmlearn's.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from hmmlearn.base import BaseHMM, ConvergenceMonitor
from sklearn.cluster import KMeans  # type: ignore[import-untyped]
from threadpoolctl import threadpool_limits

from pft_exec.demonstration import Demonstration
from pft_exec.evaluation.trace import Trace, grouped, moving_axes, softmax
from pft_exec.geometry import Array

STATES = 3  # [Dong2012]_, section 6
GAUSSIANS = 6  # [Dong2012]_, section 6
STATE_CHOICES = (2, 3, 4, 5, 6, 8)  # among which BIC chooses
_FLOOR = 1e-3  # of the data's variance, added to each covariance so that few samples do not make a spike


class _QuietMonitor(ConvergenceMonitor):  # type: ignore[misc]
    """Stops like hmmlearn's own, but does not complain of the hair's breadth by which a floor lowers the likelihood."""

    def report(self, log_prob: float) -> None:
        """Take note of the likelihood after one round."""
        self.history.append(log_prob)
        self.iter += 1


class TiedMixtureHMM(BaseHMM):  # type: ignore[misc]
    """Hidden Markov model whose states share a pool of Gaussians, in hmmlearn's terms.

    Parameters
    ----------
    states, gaussians : int
    topology : "left_to_right" or "ergodic"
    seed : int
        Of the clustering that begins the pool.
    """

    def __init__(
        self, states: int = STATES, gaussians: int = GAUSSIANS, topology: str = "left_to_right", seed: int = 0
    ):
        super().__init__(
            n_components=states,
            n_iter=40,
            tol=1e-2,
            random_state=seed,
            params="stmcw",
            init_params="",
            implementation="log",
        )
        self.gaussians = gaussians
        self.topology = topology
        self.monitor_ = _QuietMonitor(self.tol, self.n_iter, self.verbose)

    def learn(self, sequences: Sequence[Array]) -> TiedMixtureHMM:
        """Begin the pool by clustering, the weights by cutting each sequence evenly, and run EM."""
        stacked = np.concatenate(sequences)
        self._floor = _FLOOR * np.diag(np.var(stacked, axis=0) + 1e-12)
        self._begin_pool(stacked)
        self._begin_chain()
        portions = [
            np.minimum(np.arange(len(s)) * self.n_components // len(s), self.n_components - 1) for s in sequences
        ]
        shares = np.exp(self._log_components(stacked))
        shares /= np.maximum(shares.sum(axis=1, keepdims=True), 1e-300)
        weights = np.stack([shares[np.concatenate(portions) == j].sum(axis=0) for j in range(self.n_components)])
        self.weights_ = (weights + 0.1) / (weights + 0.1).sum(axis=1, keepdims=True)
        self.fit(stacked, [len(s) for s in sequences])
        return self

    def _begin_pool(self, stacked: Array) -> None:
        with threadpool_limits(1):  # threads cost more than they give to a thousand points
            clusters = KMeans(self.gaussians, n_init=3, random_state=self.random_state).fit(stacked)
        self.means_ = clusters.cluster_centers_
        members = [stacked[clusters.labels_ == m] for m in range(self.gaussians)]
        self.covars_ = np.stack(
            [(part - part.mean(axis=0)).T @ (part - part.mean(axis=0)) / len(part) + self._floor for part in members]
        )

    def _begin_chain(self) -> None:
        count = self.n_components
        if self.topology == "left_to_right":
            self.startprob_ = np.eye(count)[0]
            self.transmat_ = 0.95 * np.eye(count) + 0.05 * np.eye(count, k=1)
            self.transmat_[-1, -1] = 1.0
        else:
            self.startprob_ = np.full(count, 1.0 / count)
            self.transmat_ = np.full((count, count), 0.1 / count) + 0.9 * np.eye(count)
        self.transmat_ /= self.transmat_.sum(axis=1, keepdims=True)

    def _log_components(self, points: Array) -> Array:
        """Log density (N, M) of each point under each Gaussian of the pool."""
        factor = np.linalg.cholesky(self.covars_)
        whitened = np.einsum("mij,nmj->nmi", np.linalg.inv(factor), points[:, None] - self.means_)
        log_scale = np.log(np.einsum("mii->mi", factor)).sum(axis=1) + 0.5 * points.shape[1] * np.log(2.0 * np.pi)
        scores: Array = -0.5 * np.sum(whitened**2, axis=2) - log_scale
        return scores

    def _compute_log_likelihood(self, X: Array) -> Array:
        joint = self._log_components(X)[:, None, :] + np.log(np.maximum(self.weights_, 1e-300))
        top = joint.max(axis=2)
        likelihood: Array = top + np.log(np.exp(joint - top[:, :, None]).sum(axis=2))
        return likelihood

    def _get_n_fit_scalars_per_param(self) -> dict[str, int]:
        count, size = self.n_components, self.means_.shape[1]
        moves = count - 1 if self.topology == "left_to_right" else count * (count - 1)
        return {
            "s": 0 if self.topology == "left_to_right" else count - 1,
            "t": moves,
            "m": self.gaussians * size,
            "c": self.gaussians * size * (size + 1) // 2,
            "w": count * (self.gaussians - 1),
        }

    def _initialize_sufficient_statistics(self) -> dict[str, Any]:
        stats: dict[str, Any] = super()._initialize_sufficient_statistics()
        size = self.means_.shape[1]
        stats["count"] = np.zeros((self.n_components, self.gaussians))
        stats["first"] = np.zeros((self.gaussians, size))
        stats["second"] = np.zeros((self.gaussians, size, size))
        return stats

    def _accumulate_sufficient_statistics(
        self, stats: Any, X: Array, lattice: Array, posteriors: Array, fwdlattice: Array, bwdlattice: Array
    ) -> None:
        super()._accumulate_sufficient_statistics(stats, X, lattice, posteriors, fwdlattice, bwdlattice)
        joint = self._log_components(X)[:, None, :] + np.log(np.maximum(self.weights_, 1e-300))
        share = posteriors[:, :, None] * np.exp(joint - lattice[:, :, None])
        stats["count"] += share.sum(axis=0)
        pooled = share.sum(axis=1)
        stats["first"] += pooled.T @ X
        stats["second"] += np.einsum("nm,ni,nj->mij", pooled, X, X)

    def _do_mstep(self, stats: Any) -> None:
        super()._do_mstep(stats)
        counts = np.maximum(stats["count"].sum(axis=0), 1e-9)
        self.weights_ = (stats["count"] + 1e-3) / (stats["count"] + 1e-3).sum(axis=1, keepdims=True)
        alive = counts > 1e-3
        means = stats["first"] / counts[:, None]
        covariances = stats["second"] / counts[:, None, None] - np.einsum("mi,mj->mij", means, means) + self._floor
        self.means_ = np.where(alive[:, None], means, self.means_)
        self.covars_ = np.where(alive[:, None, None], covariances, self.covars_)

    def prefix_log_likelihood(self, points: Array) -> Array:
        """Log density of ``points[:t + 1]`` for each t, (T,): the forward pass, which never looks ahead."""
        from hmmlearn import _hmmc

        emissions = self._compute_log_likelihood(points)
        _, forward = _hmmc.forward_log(self.startprob_, self.transmat_, emissions)
        top = forward.max(axis=1)
        likelihood: Array = top + np.log(np.exp(forward - top[:, None]).sum(axis=1))
        return likelihood


@dataclass(frozen=True, eq=False)
class HMMClassifier:
    """A model per label; the likelihood of the prefix decides."""

    models: dict[str, TiedMixtureHMM]
    axes: list[int]

    def recognize(self, demonstration: Demonstration) -> Trace:
        """Filtered likelihood of each prefix under each model."""
        points = demonstration.position[:, self.axes]
        begin = time.perf_counter()
        scores = np.stack([model.prefix_log_likelihood(points) for model in self.models.values()], axis=1)
        seconds = (time.perf_counter() - begin) / len(points)
        strangeness = -scores.max(axis=1) / np.arange(1, len(points) + 1)
        return Trace(tuple(self.models), scores, softmax(scores), strangeness, seconds)


def learn_hmm(
    demonstrations: Sequence[Demonstration],
    states: int | None = STATES,
    gaussians: int = GAUSSIANS,
    topology: str = "left_to_right",
    seed: int = 0,
) -> HMMClassifier:
    """Learn one tied-mixture model per label; `states` None lets the Bayesian information criterion choose."""
    axes = moving_axes(demonstrations)
    models = {}
    for label, group in grouped(demonstrations).items():
        sequences = [item.position[:, axes] for item in group]
        choices = STATE_CHOICES if states is None else (states,)
        candidates = [TiedMixtureHMM(count, gaussians, topology, seed).learn(sequences) for count in choices]
        stacked, lengths = np.concatenate(sequences), [len(s) for s in sequences]
        models[label] = (
            min(candidates, key=lambda model: model.bic(stacked, lengths)) if states is None else candidates[0]
        )
    return HMMClassifier(models, axes)
