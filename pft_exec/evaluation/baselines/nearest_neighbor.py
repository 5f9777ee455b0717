r"""Open-end dynamic time warping to the nearest demonstration, with and without the direction of motion.

The prefix seen so far is aligned as a whole to the best-fitting prefix of each demonstration; the mean squared
distance along the way is the score of that demonstration, and the best one of a label is the label's. One new column
of the dynamic program per sample: nothing is recomputed. The honest neighbour has direction features: the unit
direction of motion, causal, weighed against position.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.evaluation.trace import Trace, grouped, moving_axes, softmax
from pft_exec.geometry import Array

DIRECTION_WINDOW = 0.03  # of the median duration
DIRECTION_WEIGHT = 0.4  # of the median extent: how far apart opposite directions lie, halved
DIRECTION_SOFTENING = 0.01  # of the median extent: below such a step the direction fades to none


@numba.njit(cache=True)
def open_end_costs(reference: Array, points: Array) -> Array:
    """Least summed squared distance (T,) of each prefix of points (T, d) to any prefix of reference (N, d)."""
    length, count, size = len(reference), len(points), reference.shape[1]
    column = np.full(length + 1, np.inf)
    column[0] = 0.0
    costs = np.empty(count)
    for t in range(count):
        diagonal = column[0]
        column[0] = np.inf
        best = np.inf
        for n in range(length):
            distance = 0.0
            for i in range(size):
                distance += (points[t, i] - reference[n, i]) ** 2
            before = column[n + 1]
            column[n + 1] = distance + min(diagonal, min(before, column[n]))
            diagonal = before
            best = min(best, column[n + 1])
        costs[t] = best
    return costs


@dataclass(frozen=True)
class Features:
    """How a recording becomes points: its moving axes, and its direction of motion where `weight` is above 0.

    Parameters
    ----------
    axes : moving axes of the training set
    window : float, s
        Over which the direction is measured, backwards from each sample.
    weight, softening : float, m
    """

    axes: tuple[int, ...]
    window: float
    weight: float
    softening: float

    def points(self, demonstration: Demonstration) -> Array:
        """Points (T, d); row t depends on samples 0 to t only."""
        position = np.ascontiguousarray(demonstration.position[:, self.axes])
        if self.weight == 0.0:
            return position
        clock = demonstration.time
        before = np.maximum(np.searchsorted(clock, clock - self.window, side="right") - 1, 0)
        step = position - position[before]
        length = np.sqrt(np.sum(step**2, axis=1, keepdims=True) + self.softening**2)
        return np.concatenate([position, self.weight * step / length], axis=1)


@dataclass(frozen=True, eq=False)
class NearestNeighbor:
    """Demonstrations as points, by label; `scale` (m^2) is the squared distance that is usual within a label."""

    references: dict[str, list[Array]]
    features: Features
    scale: float

    def recognize(self, demonstration: Demonstration) -> Trace:
        """The nearest demonstration of each label to each prefix."""
        begin = time.perf_counter()
        points = self.features.points(demonstration)
        costs = np.stack(
            [np.min([open_end_costs(r, points) for r in group], axis=0) for group in self.references.values()], axis=1
        )
        seconds = (time.perf_counter() - begin) / len(points)
        mean = costs / np.arange(1, len(points) + 1)[:, None]
        scores = -mean / self.scale
        return Trace(tuple(self.references), scores, softmax(scores), mean.min(axis=1) / self.scale, seconds)


def learn_nearest_neighbor(demonstrations: Sequence[Demonstration], direction: bool = False) -> NearestNeighbor:
    """Keep every demonstration; with `direction`, the direction of motion counts too."""
    axes = tuple(moving_axes(demonstrations))
    extent = float(np.median([np.linalg.norm(np.ptp(item.position, axis=0)) for item in demonstrations]))
    duration = float(np.median([item.duration for item in demonstrations]))
    weight = DIRECTION_WEIGHT * extent if direction else 0.0
    features = Features(axes, DIRECTION_WINDOW * duration, weight, DIRECTION_SOFTENING * extent)
    references = {label: [features.points(item) for item in group] for label, group in grouped(demonstrations).items()}
    return NearestNeighbor(references, features, _usual_distance(references, extent))


def _usual_distance(references: dict[str, list[Array]], extent: float) -> float:
    """Median over demonstrations of the mean squared distance to the nearest other of the same label, m^2."""
    distances = [
        min(open_end_costs(other, item)[-1] / len(item) for other in group if other is not item)
        for group in references.values()
        for item in group
        if len(group) > 1
    ]
    return max(float(np.median(distances)) if distances else 0.0, 1e-6 * extent**2)


@numba.njit(cache=True)
def warped_distance(first: Array, second: Array) -> float:
    """Mean distance along the best alignment of two paths (N, d), (M, d); steps (1, 0), (0, 1), (1, 1)."""
    length, count = len(first), len(second)
    cost = np.full((length + 1, count + 1), np.inf)
    steps = np.zeros((length + 1, count + 1))
    cost[0, 0] = 0.0
    for i in range(length):
        for j in range(count):
            distance = np.sqrt(np.sum((first[i] - second[j]) ** 2))
            best, taken = cost[i, j], steps[i, j]
            if cost[i, j + 1] < best:
                best, taken = cost[i, j + 1], steps[i, j + 1]
            if cost[i + 1, j] < best:
                best, taken = cost[i + 1, j], steps[i + 1, j]
            cost[i + 1, j + 1] = best + distance
            steps[i + 1, j + 1] = taken + 1.0
    return float(cost[length, count] / steps[length, count])
