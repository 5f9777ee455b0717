"""Events: when a discrete signal changes along a tube, such as the gripper that closes.

In the flow: read off the probabilities of a flow tube; execution replays them at their phases.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pft_exec.geometry import Array

MARGIN = 1e-9  # by which another value must be more probable than the present one; a tie changes nothing


class TubeEvent(NamedTuple):
    """A discrete signal takes another value.

    Parameters
    ----------
    phase : float
        Where along the tube, in (0, 1].
    name : str
        The signal.
    value : int
        What it is from there on.
    """

    phase: float
    name: str
    value: int


def find_events(name: str, phase: Array, probability: Array, values: NDArray[np.int64]) -> list[TubeEvent]:
    """Changes of the most probable value of one signal.

    Parameters
    ----------
    name : str
    phase : (N,)
        Of the steps, increasing.
    probability : (N, V)
    values : (V,)

    Notes
    -----
    Between two steps the probabilities are taken as linear: the event lies where they cross.
    """
    found = []
    present = int(np.argmax(probability[0]))
    for n in range(1, len(phase)):
        best = int(np.argmax(probability[n]))
        if probability[n, best] <= probability[n, present] + MARGIN:
            continue
        before = max(probability[n - 1, present] - probability[n - 1, best], 0.0)
        after = probability[n, best] - probability[n, present]
        ratio = before / (before + after)
        found.append(TubeEvent(float(phase[n - 1] + ratio * (phase[n] - phase[n - 1])), name, int(values[best])))
        present = best
    return found
