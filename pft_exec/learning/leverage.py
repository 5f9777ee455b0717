r"""Leverage: how uncertain a blend is in a scene that takes the experts farther apart than the demonstrations did.

Derivation (ours). The blend of E experts is a regression of the demonstrations on what the experts say, with weights
that add up to 1. In an orthonormal basis of such weights, with :math:`Z` the experts' differences in it (axes x E - 1)
and :math:`\sigma^2` the variance that the blend leaves, K demonstrations leave the weights the covariance

.. math:: V = (\sum_k Z_k^T Z_k / \sigma^2 + E (E + 1) I)^{-1},

its prior being that of weights of which nothing is known (uniform where they are positive: variance 1 / E (E + 1) along
the basis). In a new scene the blend is then uncertain by :math:`Z V Z^T`. What the demonstrations show of that, each
left out in turn, is part of the residual already; only what exceeds it is added. Where the objects stand about as far
apart as in the demonstrations this is nothing; where objects that hardly moved in any demonstration stand elsewhere, it
is most of the covariance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pft_exec.geometry import Array
from pft_exec.learning.smoothing import smoothed

WINDOW = 0.025  # of the motion, over which neighbouring steps are averaged


@dataclass(frozen=True, eq=False)
class Leverage:
    """What is not known of the weights of E experts.

    Parameters
    ----------
    covariance : (N, E - 1, E - 1), m^2 / m^2
        Of the weights at each step, in the basis of `_differences`.
    shown : (N,), m^2
        How much of it the demonstrations show: mean trace over those left out.
    """

    covariance: Array
    shown: Array

    def beyond(self, said: Array) -> Array:
        """Covariance (N, 3, 3), m^2, beyond what the demonstrations show, where experts say `said` (E, N, 3), m."""
        apart = _differences(said[:, None])[:, 0]
        added = _smoothed(apart @ self.covariance @ apart.swapaxes(1, 2))
        size = np.trace(added, axis1=1, axis2=2)
        share = np.where(size > self.shown, 1.0 - self.shown / np.maximum(size, 1e-300), 0.0)
        beyond: Array = share[:, None, None] * 0.5 * (added + added.swapaxes(1, 2))
        return beyond


def _smoothed(values: Array) -> Array:
    return smoothed(values, WINDOW * len(values))


def _differences(said: Array) -> Array:
    """(N, K, 3, E - 1): what experts (E, K, N, 3) say, in an orthonormal basis of weights that add up to 0."""
    count = len(said)
    basis = np.linalg.qr(np.hstack([np.ones((count, 1)), np.eye(count)[:, 1:]]))[0][:, 1:]
    centered = said - said.mean(axis=0)
    differences: Array = np.moveaxis(np.tensordot(basis, centered, axes=(0, 0)), (0, 2), (3, 0))
    return differences


def find_leverage(said: Array, residual: Array, floor: float) -> Leverage:
    """What K demonstrations leave open about the weights.

    Parameters
    ----------
    said : (E, K, N, 3), m
        By the experts of each demonstration from the others, its ends being where they have to be.
    residual : (K, N, 3), m
        What the blend leaves of the demonstrations.
    floor : float
        Standard deviation below which places count as equal, m.
    """
    experts, count = said.shape[:2]
    axes = max(int(np.sum(np.ptp(said, axis=(0, 1, 2)) > floor)), 1)
    left = _smoothed(np.sum(residual**2, axis=(0, 2)) / (count * axes)) + floor**2
    apart = _differences(said)
    shown = _smoothed(apart.swapaxes(2, 3) @ apart) / left[:, None, None, None]
    total = shown.sum(axis=1) + experts * (experts + 1) * np.eye(experts - 1)
    others = np.linalg.inv(total[:, None] - shown)
    traces = np.sum((apart @ others) * apart, axis=(2, 3))
    return Leverage(np.linalg.inv(total), _smoothed(traces.mean(axis=1)))
