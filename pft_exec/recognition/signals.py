"""Continuous and discrete signals in recognition: those that all tubes have, each by its own pooled scale."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pft_exec.geometry import Array
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.recognition.settings import PhaseSettings

_NOTHING = np.zeros(0), np.zeros(0, dtype=bool)


@dataclass(frozen=True, eq=False)
class SignalModel:
    """Signals of all components, packed as the steps are.

    Parameters
    ----------
    names : tuple of str
        Continuous signals, C of them.
    mean, scale : (C, S)
        Mean, and inverse standard deviation.
    tables : {name: {value: (S,)}}
        Log probability of each value of each discrete signal.
    unseen : {name: (S,)}
        Log probability of a value that no demonstration had.
    """

    names: tuple[str, ...]
    mean: Array
    scale: Array
    tables: Mapping[str, Mapping[int, Array]] = field(default_factory=dict)
    unseen: Mapping[str, Array] = field(default_factory=dict)

    def read(self, continuous: Mapping[str, float] | None) -> tuple[Array, NDArray[np.bool_]]:
        """Values (C,) and whether each was given and is finite."""
        if not self.names:
            return _NOTHING
        given = continuous or {}
        values = np.array([float(given.get(name, np.nan)) for name in self.names])
        heard = np.isfinite(values)
        return np.where(heard, values, 0.0), heard

    def log_discrete(self, discrete: Mapping[str, int] | None, zeros: Array) -> Array:
        """(S,): log probability of the discrete values that came; zeros where none did."""
        if not discrete or not self.tables:
            return zeros
        rows = [
            self.tables[name].get(int(value), self.unseen[name])
            for name, value in discrete.items()
            if name in self.tables
        ]
        return zeros if not rows else np.sum(rows, axis=0)


def shared_signals(tubes: Sequence[FlowTube]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the continuous and discrete signals that every tube has; others would favor labels."""
    continuous = set.intersection(*(set(t.continuous) & set(t.continuous_deviation) for t in tubes))
    discrete = set.intersection(*(set(t.discrete) & set(t.discrete_values) for t in tubes))
    return tuple(sorted(continuous)), tuple(sorted(discrete))


def learn_signals(
    tubes: Sequence[FlowTube],
    continuous: Sequence[str],
    discrete: Sequence[str],
    which: Sequence[int],
    settings: PhaseSettings,
) -> SignalModel:
    """Densities of the signals; one that never varies anywhere in the library is left out."""
    names, means, scales = [], [], []
    for name in continuous:
        values = np.concatenate([tube.continuous[name] for tube in tubes])
        deviations = [tube.continuous_deviation[name] for tube in tubes]
        spread = max(float(np.ptp(values)), float(np.concatenate(deviations).max()))
        if spread <= 0.0:
            continue
        pooled = float(np.mean([np.mean(d**2) for d in deviations])) + (settings.signal_floor * spread) ** 2
        names.append(name)
        means.append(np.concatenate([tubes[m].continuous[name] for m in which]))
        scales.append(np.concatenate([_inverse_deviation(tubes[m], deviations[m], pooled, settings) for m in which]))
    size = sum(len(tubes[m]) for m in which)
    tables = {name: _table(tubes, name, which) for name in discrete}
    return SignalModel(
        tuple(names),
        np.array(means).reshape(len(names), size),
        np.array(scales).reshape(len(names), size),
        tables,
        {name: np.concatenate([_unseen(tubes[m]) for m in which]) for name in discrete},
    )


def _inverse_deviation(tube: FlowTube, deviation: Array, pooled: float, settings: PhaseSettings) -> Array:
    count = max(tube.count, 2)
    strength = settings.prior_strength
    variance = (strength * pooled + (count - 1) * deviation**2) / (strength + count - 1) * (1.0 + 1.0 / count)
    inverse: Array = 1.0 / np.sqrt(variance)
    return inverse


def _unseen(tube: FlowTube) -> Array:
    return np.full(len(tube), -np.log(tube.count + 2.0))


def _table(tubes: Sequence[FlowTube], name: str, which: Sequence[int]) -> dict[int, Array]:
    values = sorted({int(v) for tube in tubes for v in tube.discrete_values[name]})
    return {value: np.concatenate([_log_probability(tubes[m], name, value) for m in which]) for value in values}


def _log_probability(tube: FlowTube, name: str, value: int) -> Array:
    column = np.flatnonzero(np.asarray(tube.discrete_values[name]) == value)
    if len(column) == 0:
        return _unseen(tube)
    floor = 1.0 / (tube.count + 2.0) ** 2
    return np.log(np.maximum(tube.discrete[name][:, column[0]], floor))
