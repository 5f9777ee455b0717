"""How rough the demonstrations' paths are: what noise the direction of motion has to be taken through.

In the flow: sets the window over which the direction is taken (see `evidence`). A displacement over a window w of a
path with noise s tells the direction up to s / w; what the direction was at the other end of the window, and no longer
is, grows as w. The sum is least where w grows as the square root of s: a window that suits clean recordings (2 % of a
motion) is too short for those of a jittering tracker, and one that suits those tells of every turn late. A stream is
taken to be as noisy as the demonstrations.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pft_exec.geometry import Array
from pft_exec.learning.flow_tube import FlowTube

_POINTS = 4  # neighbors through which a smooth path is a parabola
_MOMENT = 1e-9  # of a demonstration's duration: places nearer in time are the same


def measure_noise(tubes: Sequence[FlowTube]) -> float:
    """Median over tubes of how far demonstrations' places scatter about smooth paths, m; 0 where none are kept."""
    found = [roughness(tube.aligned.time, tube.aligned.position) for tube in tubes if tube.aligned is not None]
    return float(np.median(found)) if found else 0.0


def roughness(time: Array, position: Array) -> float:
    """Scatter of K paths about parabolas through neighbors: the median of divided differences of third order.

    Parameters
    ----------
    time : (K, N), s
        Not decreasing; places at the same time are left out.
    position : (K, N, 3), m

    Returns
    -------
    float, m
        Median length of the differences, each scaled so that it scatters as single places do.
    """
    count = time.shape[1] - _POINTS + 1
    if count < 1:
        return 0.0
    times = np.stack([time[:, i : i + count] for i in range(_POINTS)])
    apart = np.diff(times, axis=0).min(axis=0) > _MOMENT * np.ptp(time, axis=1)[:, None]
    times = times[:, apart]
    if times.size == 0:
        return 0.0
    gaps = times[:, None] - times[None] + np.eye(_POINTS)[:, :, None]
    weights = 1.0 / gaps.prod(axis=1)
    weights /= np.sqrt((weights**2).sum(axis=0))
    places = np.stack([position[:, i : i + count][apart] for i in range(_POINTS)])
    return float(np.median(np.linalg.norm((weights[..., None] * places).sum(axis=0), axis=1)))
