"""Motions of a task: a demonstrator's waypoints, the relations that they obey, and what makes one a success."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from pft_exec.description.quantities import Range, Vector, check_positive, check_range, quaternion_from_rpy
from pft_exec.geometry import Array

WORLD, START = "world", "start"  # frames that every task has, besides its objects
ABSOLUTE, NONE = "absolute", "none"  # what a relation may say, besides "start" and an object's name


@dataclass(frozen=True)
class StartDescription:
    """Where the tool stands before a motion: ranges of x, y, z, m; nominal roll, pitch, yaw, rad, and turns at most."""

    x: Range
    y: Range
    z: Range
    rpy: Vector
    turned: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("x", "y", "z"):
            check_range(name, getattr(self, name), "m")

    @cached_property
    def quaternion(self) -> Array:
        """Nominal orientation (4,), (x, y, z, w), world frame."""
        return quaternion_from_rpy(self.rpy)


@dataclass(frozen=True)
class PositionIn:
    """A position, m: the origin of `frame` plus an offset along the world's axes or the frame's own."""

    frame: str
    offset: Vector
    axes: Literal["world", "own"] = "world"


@dataclass(frozen=True)
class OrientationIn:
    """An orientation in the axes of `frame`: roll, pitch, yaw, rad."""

    frame: str
    rpy: Vector

    @cached_property
    def quaternion(self) -> Array:
        """The same, (4,), (x, y, z, w)."""
        return quaternion_from_rpy(self.rpy)


@dataclass(frozen=True)
class Waypoint:
    """A tool pose on the demonstrator's path and the time, s, an average person takes to it from the one before."""

    position: PositionIn
    orientation: OrientationIn
    duration: float

    def __post_init__(self) -> None:
        check_positive("duration", self.duration)

    @property
    def frames(self) -> tuple[str, str]:
        """The frames it refers to."""
        return self.position.frame, self.orientation.frame


@dataclass(frozen=True)
class EndRelations:
    """To what one end of a motion keeps its relation: "absolute", "start", an object's name, or "none"."""

    position: str
    orientation: str


@dataclass(frozen=True)
class Relations:
    """The relations that a demonstrator obeys: the truth that learned motion variables are judged by."""

    start: EndRelations
    end: EndRelations


@dataclass(frozen=True)
class ToolAtEnd:
    """The tool is within these tolerances, m and rad, of where the last waypoint lies."""

    position: float
    rotation: float


@dataclass(frozen=True)
class Still:
    """No object was moved by more than this, m, or turned by more than that, rad."""

    position: float
    rotation: float


@dataclass(frozen=True)
class SuccessDescription:
    """What makes a motion a success: every predicate that is given must hold."""

    tool_at_end: ToolAtEnd | None = None
    still: Still | None = None


@dataclass(frozen=True)
class MotionDescription:
    """One motion: waypoints after the start, the relations they express, success, and a start of its own, if any."""

    waypoints: tuple[Waypoint, ...]
    relations: Relations
    success: SuccessDescription
    title: str = ""
    start: StartDescription | None = None

    def __post_init__(self) -> None:
        if not self.waypoints:
            raise ValueError("a motion needs at least one waypoint.")

    @property
    def duration(self) -> float:
        """Time an average person takes, s."""
        return sum(waypoint.duration for waypoint in self.waypoints)

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the objects that waypoints refer to, sorted."""
        frames = {frame for waypoint in self.waypoints for frame in waypoint.frames}
        return tuple(sorted(frames - {WORLD, START}))
