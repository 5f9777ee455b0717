"""What every method of recognition answers, sample by sample, so that all are judged by one protocol."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array


@dataclass(frozen=True, eq=False)
class Trace:
    """Answers of one method along one recording of T samples; row t knows samples 0 to t only.

    Parameters
    ----------
    labels : (L,)
    log_likelihood : (T, L)
        Score of each label, up to a constant per row.
    probability : (T, L)
        Posterior over the labels; rows sum to 1.
    unknown : (T,)
        How little any label fits; greater is stranger, on the method's own scale.
    seconds : float, s
        Mean computing time of a sample.
    """

    labels: tuple[str, ...]
    log_likelihood: Array
    probability: Array
    unknown: Array
    seconds: float = 0.0

    @property
    def leading(self) -> tuple[str, ...]:
        """(T,): the most probable label after each sample."""
        return tuple(self.labels[index] for index in np.argmax(self.probability, axis=1))


class Classifier(Protocol):
    """Something learned from labelled demonstrations that answers along a recording."""

    def recognize(self, demonstration: Demonstration) -> Trace:
        """Answers after each sample; the label of the recording is not looked at."""


Learn = Callable[[Sequence[Demonstration]], Classifier]


def softmax(scores: Array) -> Array:
    """Posterior (..., L) of log scores (..., L) under equal priors."""
    weights: Array = np.exp(scores - np.max(scores, axis=-1, keepdims=True))
    posterior: Array = weights / weights.sum(axis=-1, keepdims=True)
    return posterior


def grouped(demonstrations: Sequence[Demonstration]) -> dict[str, list[Demonstration]]:
    """Demonstrations by label, in order of appearance."""
    groups: dict[str, list[Demonstration]] = {}
    for demonstration in demonstrations:
        groups.setdefault(demonstration.label, []).append(demonstration)
    return groups


def moving_axes(demonstrations: Sequence[Demonstration]) -> list[int]:
    """Axes along which anything moves; planar data leave z out."""
    spans = np.max([np.ptp(item.position, axis=0) for item in demonstrations], axis=0)
    axes = np.flatnonzero(spans > 1e-9 * max(float(spans.max()), 1e-300))
    return [int(axis) for axis in axes] or [0]
