"""Figures: one measured number each, beside the floor it is held against."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

Bound = Literal["at most", "at least"]


@dataclass(frozen=True)
class Figure:
    """A measured number and what it must reach.

    Parameters
    ----------
    value : float
        NaN where nothing could be measured; then the figure is not reached.
    floor : float
        Same unit.
    unit : str
    bound : "at most" or "at least"
    """

    value: float
    floor: float
    unit: str
    bound: Bound = "at most"

    @property
    def ok(self) -> bool:
        """Whether the floor is reached."""
        return bool(self.value <= self.floor if self.bound == "at most" else self.value >= self.floor)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON; None where nothing could be measured."""
        value = float(self.value) if np.isfinite(self.value) else None
        return {"value": value, "floor": self.floor, "unit": self.unit, "bound": self.bound, "ok": self.ok}


def figures_to_dict(figures: Mapping[str, Figure]) -> dict[str, Any]:
    """``{name: {value, floor, unit, bound, ok}}``."""
    return {name: figure.to_dict() for name, figure in figures.items()}


def worst(values: Sequence[float]) -> float:
    """Largest of some values; NaN where there is none."""
    return float(np.max(values)) if len(values) else float("nan")


def share(hits: Sequence[bool]) -> float:
    """Share of hits, percent; NaN where there is none."""
    return 100.0 * float(np.mean(hits)) if len(hits) else float("nan")


def wilson_interval(hits: int, count: int, z: float = 1.96) -> tuple[float, float]:
    """Wilson score interval of a share, percent; (0, 100) where nothing was tried.

    Notes
    -----
    [Wilson1927]_; z = 1.96 covers 95 %.
    """
    if count == 0:
        return 0.0, 100.0
    ratio, spread = hits / count, z**2 / count
    center = (ratio + 0.5 * spread) / (1.0 + spread)
    half = z / (1.0 + spread) * np.sqrt(ratio * (1.0 - ratio) / count + 0.25 * spread / count)
    return 100.0 * max(0.0, float(center - half)), 100.0 * min(1.0, float(center + half))
