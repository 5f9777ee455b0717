"""Passed objects: what a motion goes by between its ends, such as a bowl that a hand pours over on its way.

In the flow: `robust` asks it what the frames of the two ends, and of what was handled, leave unexplained. A place on
the way is held by an object where, seen from it, the demonstrations lie closer together than what the other frames
predict of each from the rest. Both are sums of squares of the same places with as many degrees of freedom, so that
their ratio is the F test of two variances; it is asked of every object, both kinds of axes and every stretch of the
way, and has to be significant in spite of that number (Bonferroni). Where no object is passed, one is found in less
than `SIGNIFICANCE` of all motions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from pft_exec.geometry import Array
from pft_exec.learning.endpoint import local_positions
from pft_exec.learning.smoothing import smoothed
from pft_exec.learning.variables import Passage

SIGNIFICANCE = 0.01  # of the F test, over all that is asked about one motion
STRETCHES = 10  # that a way is counted as: places nearer to one another in time than that depend on one another
WINDOW = 0.025  # of the motion over which squares are averaged
ALIKE = 0.05  # p value from which another object explains a place as well as the best one


@dataclass(frozen=True, eq=False)
class _Seen:
    """The way seen from one object: sums of squares (N,), m^2, and mean offset (N, 3), m."""

    name: str
    axes: str
    squares: Array
    offset: Array


def _squares(residual: Array, degrees: int, floor: float) -> Array:
    """(N,): sums of squares of residuals (K, N, 3), averaged over neighbouring steps."""
    total = np.sum(residual**2, axis=(0, 2))
    squares: Array = smoothed(total, WINDOW * len(total)) + degrees * floor**2
    return squares


def _seen_from(name: str, axes: str, position: Array, pose: Array, degrees: int, floor: float) -> _Seen:
    """Each demonstration's residual is from the mean of the others, as that of a prediction is."""
    local = local_positions(position, pose, axes)
    mean = local.mean(axis=0)
    count = len(local)
    return _Seen(name, axes, _squares((local - mean) * count / (count - 1), degrees, floor), mean)


def find_passage(
    position: Array, predicted: Array, poses: Mapping[str, Array], floor: float, named: bool = False
) -> Passage | None:
    """The object that explains a place on the way far better than what is known so far; None where there is none.

    Parameters
    ----------
    position, predicted : (K, N, 3), m
        Demonstrations, and what is known of each from the others.
    poses : {name: (K, 7)}
        Objects not yet among the frames, world frame, m and (x, y, z, w).
    floor : float
        Standard deviation that is as good as none, m.
    named : bool
        The user named these objects: the one that explains most is taken, significant or not.
    """
    if not poses:
        return None
    count, axes = len(position), int(np.sum(np.ptp(position, axis=(0, 1)) > floor))
    degrees = max(axes, 1) * (count - 1)
    known = _squares(position - predicted, degrees, floor)
    seen = [
        _seen_from(name, kind, position, pose, degrees, floor)
        for name, pose in sorted(poses.items())
        for kind in ("world", "object")
    ]
    chance = np.array([fdtrc(degrees, degrees, known / item.squares) for item in seen])
    best, step = np.unravel_index(int(np.argmin(chance)), chance.shape)
    if not named and chance[best, step] * len(seen) * STRETCHES >= SIGNIFICANCE:
        return None
    return _passage([seen[int(best)]] if named else seen, seen[int(best)], int(step), known, degrees)


def _passage(seen: Sequence[_Seen], best: _Seen, step: int, known: Array, degrees: int) -> Passage:
    """What is said of a place: of the objects that explain it alike, the one that is passed closest."""
    least = best.squares[step]
    alike = [item for item in seen if fdtrc(degrees, degrees, item.squares[step] / least) > ALIKE]
    chosen = min(alike, key=lambda item: (float(np.linalg.norm(item.offset[step])), item.name))
    chosen = best if chosen.name == best.name else chosen
    per_axis = np.sqrt(np.array([chosen.squares[step], known[step]]) / degrees)
    return Passage(
        chosen.name,
        step / (len(known) - 1),
        chosen.axes,
        chosen.offset[step],
        spread=float(per_axis[0]),
        spread_without=float(per_axis[1]),
        rivals=tuple(sorted({item.name for item in alike} - {chosen.name})),
    )
