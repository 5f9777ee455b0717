"""A belief: what the recognizer thinks after the samples so far."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True)
class Belief:
    """Posterior over the motions after the samples so far.

    Parameters
    ----------
    label : str
        The most probable motion.
    probability : {label: float}
        Posterior given that the motion is a known one; sums to 1.
    unknown : float
        Probability, apart from the others, that the motion is none of the library.
    log_likelihood : {label: float}
    phase : {label: float}
        Where along each tube the motion is, in [0, 1].
    time_to_completion : {label: float}
        s.
    time : float
        Time of the sample that this belief follows, s since the first sample.
    flagged : str
        Why the last sample was left out ("late", "repeated", "not finite"); empty where it was used.
    """

    label: str
    probability: Mapping[str, float]
    unknown: float
    log_likelihood: Mapping[str, float]
    phase: Mapping[str, float]
    time_to_completion: Mapping[str, float]
    time: float = 0.0
    flagged: str = ""

    def __post_init__(self) -> None:
        for name in ("probability", "log_likelihood", "phase", "time_to_completion"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
