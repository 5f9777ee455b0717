"""Relevance per direction: an end may follow an object over the table and keep an absolute height.

In the flow: asked after the competition of whole frames, about positions in the world's axes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import fdtrc

from pft_exec.geometry import Array
from pft_exec.learning.frames import Candidate

SIGNIFICANCE = 0.01  # of the F test by which another frame takes over one axis
GAIN = 1000.0  # likelihood ratio that a split needs over one frame for all axes
NARROW = 0.06  # of the extent: standard deviation per axis above which a frame holds nothing


def _replaced(own: Array, squares: Array, degrees: int) -> list[int]:
    """For each axis the candidate that explains it, -1 for the one at hand; squares (3,) and (C, 3)."""
    chosen = []
    for axis in range(3):
        best = int(np.argmin(squares[:, axis]))
        ratio = own[axis] / max(squares[best, axis], 1e-300)
        chosen.append(best if fdtrc(degrees, degrees, ratio) < SIGNIFICANCE else -1)
    return chosen


def split_directions(
    chosen: Candidate, candidates: Sequence[Candidate], extent: float, floor: float
) -> tuple[str, ...]:
    """Frame that decides each of the world's axes, or () where `chosen` explains all three.

    Parameters
    ----------
    chosen : Candidate
        Of the whole competition; the absolute one where nothing won.
    candidates : all of this end
    extent, floor : float
        Size of the motion, and the standard deviation that is as good as none, m.
    """
    degrees = len(chosen.residual) - 1
    if chosen.axes != "world" or degrees < 2:
        return ()
    level = [c for c in candidates if c.axes == "world"]
    squares = np.array([np.sum(c.residual**2, axis=0) for c in level]) + degrees * floor**2
    own = np.sum(chosen.residual**2, axis=0) + degrees * floor**2
    picks = _replaced(own, squares, degrees)
    mixed = np.array([own[a] if pick < 0 else squares[pick, a] for a, pick in enumerate(picks)])
    gain = 0.5 * degrees * float(np.sum(np.log(own) - np.log(mixed)))
    if gain < np.log(GAIN) or np.any(np.sqrt(mixed / degrees) > NARROW * extent):
        return ()
    return tuple(chosen.name if pick < 0 else level[pick].name for pick in picks)
