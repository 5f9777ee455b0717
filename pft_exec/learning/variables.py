"""Motion variables: which relations the demonstrations of a motion preserve at its two ends, and why.

In the flow: `pft_exec.learning.relevance` decides, this module holds and prints the decisions, the generalization to a
new scene obeys them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from pft_exec.geometry import Array, read_only

ENDS = ("start", "end")
CHANNELS = ("position", "orientation")
ABSOLUTE = "absolute"
START = "start"
NONE = ""
WAY = "way"  # between the ends, where a user names objects that are passed


@dataclass(frozen=True, eq=False)
class FrameDecision:
    """Which frame one end of a motion is tied to, for position or for orientation.

    Parameters
    ----------
    frame : str
        "absolute", "start" (the pose in which the motion began), the name of an object, or "" for none.
    axes : str
        "world" where the offset keeps the world's axes, "object" where it turns with the frame.
    offset : (3,)
        Mean place of the tool in that frame, m; for orientation the rotation vector of the mean orientation, rad.
    spread : float
        Root mean square distance from `offset` over the demonstrations, m or rad.
    candidates : {name: float}
        Spread in each candidate frame; the narrower of its two kinds of axes for an object.
    probability : {name: float}
        Posterior of each candidate and of "" (none); sums to 1.
    variance_ratio, p_value : float
        Variance in the second narrowest frame over that in the chosen one, and how often chance alone gives that
        much (F test); 1 and 1 where there is nothing to compare.
    ambiguous : bool
        The demonstrations do not tell this frame from another; `reason` says which.
    reason : str
        One sentence for a reader.
    relevant : tuple of str
        Every frame that counts at this end; the chosen one first.
    rivals : tuple of str
        Frames that the demonstrations do not tell from the chosen one; heard as long as they do not contradict it.
    directions : tuple of str
        Frame that decides each of the world's axes x, y, z, where one frame does not explain all three; else empty.
    kinds : {name: "world" or "object"}
        Axes in which each candidate was narrower.
    overruled : bool
        The user named the frame.
    """

    frame: str
    axes: str
    offset: Array
    spread: float
    candidates: Mapping[str, float]
    probability: Mapping[str, float] = field(default_factory=dict)
    variance_ratio: float = 1.0
    p_value: float = 1.0
    ambiguous: bool = False
    reason: str = ""
    relevant: tuple[str, ...] = ()
    rivals: tuple[str, ...] = ()
    overruled: bool = False
    directions: tuple[str, ...] = ()
    kinds: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "offset", read_only(self.offset))
        object.__setattr__(self, "candidates", MappingProxyType(dict(self.candidates)))
        object.__setattr__(self, "probability", MappingProxyType(dict(self.probability)))
        object.__setattr__(self, "kinds", MappingProxyType(dict(self.kinds)))

    def axes_of(self, name: str) -> str:
        """Axes in which a frame that counts here is meant: "world" or "object"."""
        return self.axes if name == self.frame else self.kinds.get(name, "world")

    def changed(self, **fields: Any) -> FrameDecision:
        """A copy with other values in some fields."""
        return replace(self, **fields)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and words, for JSON."""
        plain: dict[str, Any] = {name: getattr(self, name) for name in self.__dataclass_fields__}
        plain |= {name: dict(plain[name]) for name in ("candidates", "probability", "kinds")}
        plain |= {"offset": [float(x) for x in self.offset]}
        plain |= {name: list(plain[name]) for name in ("relevant", "rivals", "directions")}
        return plain


@dataclass(frozen=True)
class EndDecision:
    """Decisions at one end of a motion; `orientation` is None where the demonstrations have none."""

    position: FrameDecision
    orientation: FrameDecision | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and words, for JSON."""
        return {
            "position": self.position.to_dict(),
            "orientation": None if self.orientation is None else self.orientation.to_dict(),
        }


@dataclass(frozen=True, eq=False)
class Passage:
    """A place between the ends that an object holds, such as the one over a bowl that is poured over on the way.

    Parameters
    ----------
    name : str
    phase : float
        Share of the time, in [0, 1], at which the object says most.
    axes : "world" or "object"
        As of `FrameDecision`.
    offset : (3,), m
        Mean place of the tool there, seen from the object.
    spread, spread_without : float, m
        Standard deviation per axis of that place from what the other demonstrations say: seen from the object, and by
        all that is known without it.
    rivals : tuple of str
        Objects that explain the place as well.
    """

    name: str
    phase: float
    axes: str
    offset: Array
    spread: float
    spread_without: float
    rivals: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "offset", read_only(self.offset))

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and words, for JSON."""
        plain: dict[str, Any] = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return plain | {"offset": [float(x) for x in self.offset], "rivals": list(self.rivals)}


@dataclass(frozen=True)
class MotionVariables:
    """The motion variables of one motion.

    Parameters
    ----------
    start, end : EndDecision
    carried : tuple of str
        Objects that moved with the tool: where they end says nothing about a new scene.
    continuous : {name: {"start", "start_spread", "end", "end_spread", "range": float}}
        Mean and standard deviation of each continuous signal at the two ends, and its range along the motion.
    discrete : {name: {"start": int, "end": int}}
        Most frequent value of each discrete signal at the two ends.
    passed : tuple of Passage
        Objects that hold the way between the ends.
    """

    start: EndDecision
    end: EndDecision
    carried: tuple[str, ...] = ()
    continuous: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    discrete: Mapping[str, Mapping[str, int]] = field(default_factory=dict)
    passed: tuple[Passage, ...] = ()

    def relations(self) -> dict[str, dict[str, str]]:
        """Chosen frame per end and channel, "" where none: ``{"end": {"position": "bottle", ...}, ...}``."""
        return {
            end: {
                channel: "" if decision is None else decision.frame
                for channel in CHANNELS
                for decision in (getattr(getattr(self, end), channel),)
            }
            for end in ENDS
        }

    @property
    def ambiguous(self) -> bool:
        """Whether any decision is ambiguous."""
        decisions = (getattr(getattr(self, end), channel) for end in ENDS for channel in CHANNELS)
        return any(decision is not None and decision.ambiguous for decision in decisions) or any(
            passage.rivals for passage in self.passed
        )

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the objects that some decision refers to, or that are passed."""
        names: list[str] = []
        for end in (self.start, self.end):
            for decision in (end.position, end.orientation):
                if decision is not None:
                    names += [name for name in decision.relevant if name not in (ABSOLUTE, START)]
        return tuple(dict.fromkeys([*names, *(passage.name for passage in self.passed)]))

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and words, for JSON."""
        return {
            "start": self.start.to_dict(),
            "end": self.end.to_dict(),
            "carried": list(self.carried),
            "continuous": {name: dict(values) for name, values in self.continuous.items()},
            "discrete": {name: dict(values) for name, values in self.discrete.items()},
            "passed": [passage.to_dict() for passage in self.passed],
        }
