"""The speed now: how well it suits the phase, without being counted twice.

In the flow: beside the filter's evidence, which adds up, stands what the present speed says of each phase. It is one
observation, together with the present place, that each sample makes anew: a hand that rests where a motion ends speaks
for that motion, against one that only passes there, for as long as it rests; when it goes on, nothing of that is left.
The N* / N of [Dong2012]_ does something like it.

Demonstrations are cut where the hand no longer goes on, so that a tube's last step still has some speed, and a hand at
rest would be strange even there. So at the last step, and at those that lie as a motion's own ends do (see `ending`),
rest and all speeds on the way to it are usual.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from pft_exec.geometry import Array
from pft_exec.recognition.evidence import TubeEvidence
from pft_exec.recognition.settings import PhaseSettings

LEVELS = 32
_LEAST_RANGE = 1.0  # of the logarithms of speeds


@dataclass(frozen=True, eq=False)
class SpeedModel:
    """Densities of the logarithm of speed at S steps, at even levels of it.

    Parameters
    ----------
    density : (L, S)
    lowest, gap : float
        First level, and between levels.
    softness, leash : float
        Of the direction of motion and of the clock, in extents.
    """

    density: Array
    lowest: float
    gap: float
    softness: float
    leash: float

    def at(self, direction: Array) -> Array:
        """(S,): density of the present speed, known by the length of the softened direction (3,)."""
        length = np.sqrt((direction**2).sum())
        level = (float(log_speed(length, self.softness, self.leash)) - self.lowest) / self.gap
        row: Array = self.density[min(max(round(level), 0), LEVELS - 1)]
        return row


def log_speed(length: Array, softness: float, leash: float) -> Array:
    """Logarithm of the displacement over the direction's window, in extents, raised by the leash.

    Parameters
    ----------
    length : array
        Of the direction, which is the displacement d over ``|d| + softness``.
    softness, leash : float
        In extents.
    """
    length = np.minimum(length, 1.0 - 1e-9)
    result: Array = np.log(softness * length / (1.0 - length) + leash)
    return result


def learn_speed(
    evidence: Sequence[TubeEvidence], endings: Sequence[Array], which: NDArray[np.int64], settings: PhaseSettings
) -> SpeedModel:
    """Densities for components that belong to the motions `which`, each of which may end where `endings` (N,) say."""
    softness, leash = settings.direction_softness, settings.leash
    logs = [log_speed(e.lengths, softness, leash) for e in evidence]
    highest = max(float(values.max()) for values in logs)
    levels = np.linspace(np.log(leash), max(highest, np.log(leash) + _LEAST_RANGE), LEVELS)
    scatters = [((values - values.mean(axis=0)) ** 2).sum(axis=0) for values in logs]
    spread = [float(s.mean()) / max(len(values) - 1, 1) for s, values in zip(scatters, logs, strict=True)]
    pooled = float(np.mean(spread)) + settings.speed_deviation**2
    tables = [
        _densities(levels, values.mean(axis=0), scatter, pooled, e.count, settings.rest * ending, settings)
        for values, scatter, e, ending in zip(logs, scatters, evidence, endings, strict=True)
    ]
    density = np.ascontiguousarray(np.hstack([tables[m] for m in which]))
    return SpeedModel(density, float(levels[0]), float(levels[1] - levels[0]), softness, leash)


def _densities(
    levels: Array, mean: Array, scatter: Array, pooled: float, count: int, rest: Array, settings: PhaseSettings
) -> Array:
    """(L, N): predictive Student t at each level; with probability `rest` (N,) that of a hand which comes to rest.

    Both are mixed with speeds that may come at any phase.
    """
    count = max(count, 1)
    freedom = settings.prior_strength + count - 1
    variance = (settings.prior_strength * pooled + scatter) / freedom * (1.0 + 1.0 / count)
    square = (levels[:, None] - mean) ** 2 / (freedom * variance)
    constant = gammaln(0.5 * freedom + 0.5) - gammaln(0.5 * freedom) - 0.5 * np.log(np.pi * freedom * variance)
    usual = np.exp(constant - 0.5 * (freedom + 1.0) * np.log1p(square))
    usual += rest * (_coming_to_rest(levels, mean) - usual)
    anywhere = 1.0 / (levels[-1] - levels[0])
    result: Array = (1.0 - settings.pause) * usual + settings.pause * anywhere
    return result


def _coming_to_rest(levels: Array, speed: Array) -> Array:
    """(L, N): even density of the logarithm of speed between rest and that of the demonstrations at each step (N,)."""
    passed = levels[:, None] <= np.maximum(speed, levels[0])
    density: Array = passed / (passed.sum(axis=0) * (levels[1] - levels[0]))
    return density
