"""Where a motion may end: at the last step, and wherever its place is as good as the last one.

In the flow: a hand comes to rest at its own end, and ends are scattered. The last steps of a tube, where the hand
slowed down, lie nearer together than that: the place of a hand which has arrived does not tell which of them it is at,
and a filter that followed a quick person late still believes it some steps before the last. At each of those steps the
hand may be at its own end.
"""

from __future__ import annotations

import numpy as np

from pft_exec.geometry import Array, conjugate, multiply
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.recognition.emission import Emission

_ROWS, _COLUMNS = (0, 1, 1, 2, 2, 2), (0, 0, 1, 0, 1, 2)  # of the six that `Emission.white` keeps of each factor


def may_end(tube: FlowTube, emission: Emission) -> Array:
    """How usual it is, beside the last step, that a motion ends at the place of each of its steps.

    Parameters
    ----------
    tube : N steps
    emission : Emission
        Its densities; those of position and orientation at the last step say how its ends are scattered.

    Returns
    -------
    Array
        (N,), in [0, 1]: density of ends at the step over that at the last step; never more than at a later step, so
        that a closed motion does not end where it begins. 1 at the last.
    """
    square, size = _distances(tube.position - tube.position[-1], emission.white[:6, -1])
    if tube.quaternion is not None:
        turned = 2.0 * multiply(conjugate(tube.quaternion[-1:]), tube.quaternion)
        square_turned, size_turned = _distances(turned[:, :3], emission.white[12:, -1])
        square, size = square + square_turned, size + size_turned
    density = (1.0 + square / emission.freedom) ** (-0.5 * (emission.freedom + size))
    ending: Array = np.minimum.accumulate(density[::-1])[::-1]
    return ending


def _distances(offset: Array, white: Array) -> tuple[Array, int]:
    """Squared Mahalanobis lengths (N,) of offsets (N, 3), and number of axes that count in a Cholesky factor (6,)."""
    factor = np.zeros((3, 3))
    factor[_ROWS, _COLUMNS] = white
    square: Array = ((offset @ factor.T) ** 2).sum(axis=1)
    return square, int(np.count_nonzero(np.diagonal(factor)))
