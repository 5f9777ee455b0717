"""Profiles over phase that a library has in common, on one grid of phases."""

from __future__ import annotations

import numpy as np

from pft_exec.geometry import Array

GRID = 100  # phases at which profiles are pooled
_SMOOTHING = 0.045  # of the motion, over which a profile is averaged


def phases(count: int) -> Array:
    """(count,): even phases from 0 to 1."""
    return np.linspace(0.0, 1.0, count)


def on_grid(profile: Array) -> Array:
    """A profile (N,) at the `GRID` phases."""
    return np.asarray(np.interp(phases(GRID), phases(len(profile)), profile), dtype=float)


def from_grid(profile: Array, count: int) -> Array:
    """A profile at the `GRID` phases (GRID,) at `count` even phases."""
    return np.asarray(np.interp(phases(count), phases(GRID), profile), dtype=float)


def smoothed(profile: Array) -> Array:
    """A profile (GRID,) averaged over a short while."""
    width = max(round(_SMOOTHING * len(profile)), 1) // 2 * 2 + 1
    padded = np.pad(profile, width // 2, mode="edge")
    return np.convolve(padded, np.full(width, 1.0 / width), "valid")
