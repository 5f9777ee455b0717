"""Timing: how many steps of a tube a motion goes on in one step's time, for each pace.

In the flow: the transition of the phase filter, learned from the times at which the demonstrations passed the steps.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pft_exec.geometry import Array
from pft_exec.recognition.evidence import TubeEvidence
from pft_exec.recognition.phase_kernel import REACH
from pft_exec.recognition.settings import PhaseSettings

SIZES = REACH + 1  # steps 0 .. 5
_PLAIN_STEPS = np.array([4.0, 12.0, 3.0, 0.7, 0.2, 0.1])  # counts where no tube has demonstrations
_LEAST = 1e-4  # of any step's probability


def step_counts(evidence: TubeEvidence, tick: float) -> Array:
    """How often each of 0 .. 5 steps was made in one tick (s) of the demonstrations: (6,)."""
    counts = np.zeros(SIZES)
    steps = evidence.clocks.shape[1]
    for clock in evidence.clocks:
        ticks = np.arange(0.0, clock[-1] + 0.5 * tick, tick)
        ramp = clock + 1e-9 * tick * np.arange(steps)
        places = np.floor(np.interp(ticks, ramp, np.arange(steps)) + 0.5).astype(int)
        counts += np.bincount(np.clip(np.diff(places), 0, SIZES - 1), minlength=SIZES)
    return counts


def step_probabilities(evidence: Sequence[TubeEvidence], ticks: Array, settings: PhaseSettings) -> Array:
    """(M, R, 6): probability of each number of steps in one tick, for each tube and pace."""
    counts = np.array([step_counts(e, float(tick)) for e, tick in zip(evidence, ticks, strict=True)])
    pooled = counts.sum(axis=0) + _PLAIN_STEPS
    own = counts + settings.step_pseudo_count * pooled / pooled.sum()
    own = np.maximum(own / own.sum(axis=1, keepdims=True), _LEAST)
    return tilt(own[:, None, :], np.array(settings.rates)[None, :])


def tilt(probabilities: Array, rates: Array) -> Array:
    """Distributions (..., 6) tilted exponentially until the mean step is the rate (...)."""
    sizes = np.arange(probabilities.shape[-1])
    shape = np.broadcast_shapes(probabilities.shape[:-1], rates.shape)
    low, high = np.full(shape, -30.0), np.full(shape, 30.0)
    for _ in range(60):
        middle = 0.5 * (low + high)
        tilted = probabilities * np.exp(middle[..., None] * (sizes - rates[..., None]))
        tilted = tilted / tilted.sum(axis=-1, keepdims=True)
        slow = tilted @ sizes < rates
        low, high = np.where(slow, middle, low), np.where(slow, high, middle)
    result: Array = tilted
    return result


def rate_prior(settings: PhaseSettings) -> Array:
    """(R,): how often people keep each pace."""
    weight = np.exp(-0.5 * (np.log(settings.rates) / settings.rate_deviation) ** 2) + settings.rate_tail
    prior: Array = weight / weight.sum()
    return prior


def rate_changes(settings: PhaseSettings, switch: Array) -> Array:
    """(J, R, 3): probabilities by which each pace is reached from the next slower one, itself, and the next faster one.

    People change to a neighboring pace, as often as leaves `rate_prior` as it is (Metropolis).
    """
    prior = rate_prior(settings)
    up = 0.5 * np.minimum(1.0, prior[1:] / prior[:-1])  # from each but the last
    down = 0.5 * np.minimum(1.0, prior[:-1] / prior[1:])
    leave = np.append(up, 0.0) + np.insert(down, 0, 0.0)
    reached = np.stack([np.insert(up, 0, 0.0), -leave, np.append(down, 0.0)], axis=1)
    changes: Array = switch[:, None, None] * reached
    changes[:, :, 1] += 1.0
    return changes
