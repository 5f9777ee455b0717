"""The unknown motion: how strange a stream looks beside what each motion's own demonstrations look like.

In the flow: built with the phase filter. The largest posterior says nothing about motions outside the library; the mean
squared Mahalanobis distance along the filter's phase does, once divided by the motion's own leave-one-out value.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pft_exec.geometry import Array
from pft_exec.recognition.emission import Prior, coupled, covariances, predictive, tail_freedom
from pft_exec.recognition.evidence import TubeEvidence
from pft_exec.recognition.settings import PhaseSettings

_POOLED = 2.0  # demonstrations that the library's mean counts for in a motion's own value
_LEAST_DEVIATION = 0.25  # of the logarithm of a known motion's strangeness
_USUAL = (
    0.43  # logarithm of how much stranger a new motion is than one that the tube was aligned to; people: 0.3 to 0.7
)
_MARGIN = 1.5  # of those deviations from a usual motion to the threshold
_STEEPNESS = 0.5  # of them, over which known turns to unknown
_PRESENT = 0.2  # that the present sample is worth; with more, the last sample of a known hand looks strange
_HELD = 0.7  # independent observations of a usual motion that each stream begins with


@dataclass(frozen=True, eq=False)
class Strangeness:
    """What is usual: reference (M,) mean squared distances an axis, and the threshold of their ratio.

    Parameters
    ----------
    reference : (M,)
    log_threshold, log_width : float
        Of the logarithm of the ratio.
    """

    reference: Array
    log_threshold: float
    log_width: float

    def probability(self, distance: Array, weight: float, present: Array) -> Array:
        """(M,): probability that the stream is none of the library, were it nearest to each motion.

        Parameters
        ----------
        distance : (M,)
            Weighted sum of squared distances an axis along the filter's phase.
        weight : float
            Sum of the weights, in independent observations.
        present : (M,)
            Squared distance an axis of the present sample.
        """
        worth = _PRESENT * weight / (_PRESENT + weight) if weight > 0.0 else 0.0
        ratio = ((distance + worth * present) / self.reference + _HELD) / (weight + worth + _HELD)
        result: Array = 1.0 / (1.0 + np.exp(-(np.log(ratio) - self.log_threshold) / self.log_width))
        return result


def left_out_distances(evidence: TubeEvidence, prior: Prior, tube: int, settings: PhaseSettings) -> Array:
    """(K,): mean squared Mahalanobis distance an axis of each demonstration from the others of its motion."""
    count, kept, strength = len(evidence.position), prior.kept, settings.prior_strength
    if count < 2:
        return np.zeros(0)
    residuals = np.stack([evidence.conditioned, evidence.direction, evidence.rotation])
    cross, distances, size = evidence.cross, np.empty(count), kept.sum()
    for k in range(count):
        left = residuals[:, k] * (count / (count - 1.0))  # from the mean of the others
        share = (count - 1.0) / count
        without = evidence.scatter - left[..., :, None] * left[..., None, :] * share
        together = cross - left[1][:, :, None] * left[0][:, None, :] * share
        covariance = covariances(without, count - 1, prior.variance[tube], kept, strength)
        white, _, gain = coupled(covariance, predictive(together, count - 1, prior.cross[tube], strength), kept)
        left[1] -= np.einsum("ijn,nj->ni", gain.reshape(3, 3, -1), left[0])
        freedom = tail_freedom(count - 1, settings)
        distances[k] = (0.5 * (freedom + size) * np.log1p(_square(white, left) / freedom)).mean() / size
    return distances


def _square(white: Array, residual: Array) -> Array:
    """(N,): squared Mahalanobis distances of residuals (3, N, 3)."""
    rows = white.reshape(3, 6, -1)
    x, y, z = np.moveaxis(residual, -1, 0)
    a = rows[:, 0] * x
    b = rows[:, 1] * x + rows[:, 2] * y
    c = rows[:, 3] * x + rows[:, 4] * y + rows[:, 5] * z
    total: Array = (a**2 + b**2 + c**2).sum(axis=0)
    return total


def learn_strangeness(evidence: Sequence[TubeEvidence], prior: Prior, settings: PhaseSettings) -> Strangeness:
    """What is usual for each motion: its demonstrations left out in turn, and what the floor expects besides.

    Demonstrations that agree better than the floor, such as those of a machine, say nothing of how far a person will
    be: the floor does, and as half a squared distance an axis for the share of the variance that it makes up.
    """
    own = [left_out_distances(e, prior, m, settings) for m, e in enumerate(evidence)]
    logs = [np.log(np.maximum(values, 1e-6)) for values in own]
    known = np.concatenate(logs) if any(len(v) for v in logs) else np.zeros(1)
    pooled = float(known.mean())
    reference = np.array([(values.sum() + _POOLED * pooled) / (len(values) + _POOLED) for values in logs])
    spread = np.concatenate([values - center for values, center in zip(logs, reference, strict=True)] + [np.zeros(1)])
    deviation = max(float(np.sqrt(np.mean(spread**2))), _LEAST_DEVIATION)
    shares = [prior.floor_share(e, m, settings.prior_strength) if own[m].size else 0.0 for m, e in enumerate(evidence)]
    return Strangeness(np.exp(reference) + 0.5 * np.array(shares), _USUAL + _MARGIN * deviation, _STEEPNESS * deviation)
