"""Continuous and discrete signals along a tube: a Gaussian, and probabilities with a Laplace prior."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array
from pft_exec.learning.alignment import AlignedSet, shared_names
from pft_exec.learning.smoothing import smoothed

WINDOW = 0.05  # of the motion, over which the variance of a signal is averaged
FLOOR = 0.02  # of a signal's range: smallest standard deviation


@dataclass(frozen=True, eq=False)
class SignalTubes:
    """Signals at N steps: names and shapes as in `FlowTube`."""

    continuous: Mapping[str, Array]
    continuous_deviation: Mapping[str, Array]
    discrete: Mapping[str, Array]
    discrete_values: Mapping[str, NDArray[np.int64]]


def _deviation(values: Array) -> Array:
    """Standard deviation (N,) of a signal (K, N), averaged over neighbouring steps, with a floor."""
    steps = values.shape[1]
    variance = smoothed(values.var(axis=0, ddof=1), WINDOW * steps)
    floor = FLOOR * max(float(np.ptp(values)), 1e-9)
    deviation: Array = np.sqrt(variance * (1.0 + 1.0 / len(values)) + floor**2)
    return deviation


def _probabilities(values: NDArray[np.int64], choices: NDArray[np.int64]) -> Array:
    """Probability (N, V) of each value, one imagined demonstration for each (Laplace)."""
    counts = (values[:, :, None] == choices).sum(axis=0) + 1.0
    probability: Array = counts / counts.sum(axis=1, keepdims=True)
    return probability


def signal_tubes(aligned: AlignedSet) -> SignalTubes:
    """Mean, deviation and probabilities of all signals that every demonstration has."""
    choices = {name: np.unique(values) for name, values in aligned.discrete.items()}
    return SignalTubes(
        {name: values.mean(axis=0) for name, values in aligned.continuous.items()},
        {name: _deviation(values) for name, values in aligned.continuous.items()},
        {name: _probabilities(values, choices[name]) for name, values in aligned.discrete.items()},
        choices,
    )


def _ends(values: Sequence[Array]) -> dict[str, float]:
    """Mean and standard deviation over demonstrations of a continuous signal (N_k,) at the two ends, and its range."""
    first, last = np.array([v[0] for v in values]), np.array([v[-1] for v in values])
    spread = [float(ends.std(ddof=1)) for ends in (first, last)]
    whole = float(np.median([np.ptp(v) for v in values]))
    named = {"start": float(first.mean()), "start_spread": spread[0], "end": float(last.mean())}
    return named | {"end_spread": spread[1], "range": whole}


def _modes(values: Sequence[NDArray[np.int64]]) -> dict[str, int]:
    """Most frequent value of a discrete signal at the two ends; the smaller one where two are equally frequent."""
    modes = {}
    for end, index in (("start", 0), ("end", -1)):
        shown, counts = np.unique([v[index] for v in values], return_counts=True)
        modes[end] = int(shown[counts.argmax()])
    return modes


def signal_ends(
    demonstrations: Sequence[Demonstration],
) -> tuple[dict[str, dict[str, float]], dict[str, dict[str, int]]]:
    """Continuous and discrete signals at the two ends of a motion, as `MotionVariables` holds them."""
    continuous = shared_names([d.continuous for d in demonstrations])
    discrete = shared_names([d.discrete for d in demonstrations])
    return (
        {name: _ends([d.continuous[name] for d in demonstrations]) for name in continuous},
        {name: _modes([d.discrete[name] for d in demonstrations]) for name in discrete},
    )
