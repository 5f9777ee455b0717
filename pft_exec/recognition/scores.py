"""What goes into a method of recognition and what comes out: one sample, and scores of all labels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pft_exec.geometry import Array


@dataclass(frozen=True, eq=False)
class Sample:
    """One instant of a stream.

    Parameters
    ----------
    time : float, s
    position : (3,), m, world frame
    quaternion : (4,), (x, y, z, w), unit, or None
    continuous, discrete : {name: value} or None
    """

    time: float
    position: Array
    quaternion: Array | None
    continuous: Mapping[str, float] | None
    discrete: Mapping[str, int] | None


@dataclass(frozen=True, eq=False)
class Scores:
    """Scores of all labels after a sample.

    Parameters
    ----------
    log_likelihood : (M,)
    phase : (M,)
        In [0, 1].
    time_to_completion : (M,), s
    strangeness : (M,)
        Probability that the motion is unknown, were it nearest to each label.
    """

    log_likelihood: Array
    phase: Array
    time_to_completion: Array
    strangeness: Array
