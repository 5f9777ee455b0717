"""Predicates of success: what must be so, physically, for a motion to have done what it is for.

Where a predicate needs a place, the place is of the scene before the motion; distances in m, angles in rad.
"""

from __future__ import annotations

from dataclasses import dataclass

from pft_exec.description.quantities import Range, Vector, check_range

_NAMING = ("frame", "object", "vessel", "into", "container")  # fields that hold the name of an object


@dataclass(frozen=True)
class ToolAtEnd:
    """The tool is within these tolerances, m and rad, of where the motion should end."""

    position: float
    rotation: float


@dataclass(frozen=True)
class Still:
    """No object was moved by more than this, m, or turned by more than that, rad, but those that are named or held."""

    position: float
    rotation: float
    but: tuple[str, ...] = ()


@dataclass(frozen=True)
class Held:
    """An object is in the gripper, and has slipped in it by at most this, m, since it was grasped."""

    object: str
    slip: float = 0.002


@dataclass(frozen=True)
class Placed:
    """An object stands upright where it should: at the origin of `frame` plus an offset along the world's axes.

    The frame "start" is the object's own place before the motion.
    """

    object: str
    frame: str
    offset: Vector
    position: float = 0.01
    tilt: float = 0.0524


@dataclass(frozen=True)
class Poured:
    """The liquid went from one vessel into another.

    Parameters
    ----------
    vessel, into : str
    share, left : float
        At least this share of the balls is in the one, at most that share left in the other.
    upright, moved : float, float m
        Cosine of the other's lean at least, and how far it was moved at most.
    """

    vessel: str
    into: str
    share: float = 0.8
    left: float = 0.1
    upright: float = 0.95
    moved: float = 0.02


@dataclass(frozen=True)
class Shaken:
    """The tool went to and fro along a direction, world axes, turning back so often.

    From one reversal to the next it goes at least `share` of twice the amplitude, m.
    """

    direction: Vector
    amplitude: float
    reversals: int
    share: float = 0.7


@dataclass(frozen=True)
class Stirred:
    """The tool went round so many turns in one sense about the origin of `frame` plus `center`, on a radius, m."""

    frame: str
    center: Vector
    radius: float
    turns: float
    radius_tolerance: float = 0.15
    center_tolerance: float = 0.02


@dataclass(frozen=True)
class Wound:
    """The tool's path winds about the vertical through the origin of `frame`: turns, + counterclockwise from above.

    Parameters
    ----------
    frame : str
    turns, tolerance : float
    radius : (2,), m
        Least and greatest distance from the vertical on the way.
    """

    frame: str
    turns: float
    radius: Range
    tolerance: float = 0.25

    def __post_init__(self) -> None:
        check_range("radius", self.radius, "m")


@dataclass(frozen=True)
class AnchorPassed:
    """Something at an offset, m, along the world's axes, and the side in x, 1 or -1, on which the path passes it."""

    offset: Vector
    side: float


@dataclass(frozen=True)
class Anchored:
    """The path passes anchors one after another, each on its side, at least a margin, m, away.

    An anchor is passed where the path crosses its y, world axes; offsets count from the origin of `frame`.
    """

    frame: str
    anchors: tuple[AnchorPassed, ...]
    margin: float = 0.02


@dataclass(frozen=True)
class RestsIn:
    """An object lies within the walls of a container, below its rim, slower than this, m/s."""

    object: str
    container: str
    speed: float = 0.05


@dataclass(frozen=True)
class SuccessDescription:
    """What makes a motion a success: every predicate that is given must hold."""

    tool_at_end: ToolAtEnd | None = None
    still: Still | None = None
    held: Held | None = None
    placed: Placed | None = None
    poured: Poured | None = None
    shaken: Shaken | None = None
    stirred: Stirred | None = None
    wound: Wound | None = None
    anchored: Anchored | None = None
    rests_in: RestsIn | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Frames and objects that predicates name."""
        given = [value for value in vars(self).values() if value is not None]
        words = [getattr(item, key) for item in given for key in _NAMING if hasattr(item, key)]
        return (*words, *(self.still.but if self.still is not None else ()))
