"""A belief: what the recognizer thinks after the samples so far."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from pft_exec.geometry import Array


class LabelValues(Mapping[str, float]):
    """A read-only mapping from labels to floats over an array, so that a thousand labels cost one array a sample.

    Parameters
    ----------
    index : {label: int}
        Where each label stands in `values`; shared between beliefs.
    values : (M,)
    """

    __slots__ = ("_index", "_values")

    def __init__(self, index: Mapping[str, int], values: Array) -> None:
        self._index = index
        self._values = values

    def __getitem__(self, label: str) -> float:
        return float(self._values[self._index[label]])

    def __iter__(self) -> Iterator[str]:
        return iter(self._index)

    def __len__(self) -> int:
        return len(self._index)

    def __repr__(self) -> str:
        return repr(dict(self))

    def __reduce__(self) -> tuple[type[LabelValues], tuple[dict[str, int], Array]]:
        return LabelValues, (dict(self._index), self._values)


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
            values = getattr(self, name)
            if not isinstance(values, LabelValues):
                object.__setattr__(self, name, MappingProxyType(dict(values)))
