"""Motions of a task: a demonstrator's waypoints and curve, the relations that they obey, and what the hand holds."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from pft_exec.description.curve import Circle, SCurve, Swing
from pft_exec.description.object import Placement
from pft_exec.description.predicates import SuccessDescription
from pft_exec.description.quantities import Range, Vector, check_positive, check_range, quaternion_from_rpy
from pft_exec.geometry import Array, Pose

WORLD, START = "world", "start"  # frames that every task has, besides its objects
ABSOLUTE, NONE = "absolute", "none"  # what a relation may say, besides "start" and an object's name


@dataclass(frozen=True)
class StartDescription:
    """Where the tool stands before a motion: ranges of x, y, z, m; nominal roll, pitch, yaw, rad, and turns at most.

    The ranges are along the world's axes, from the origin of `frame`: the world, or an object.
    """

    x: Range
    y: Range
    z: Range
    rpy: Vector
    turned: Vector = (0.0, 0.0, 0.0)
    frame: str = WORLD

    def __post_init__(self) -> None:
        for name in ("x", "y", "z"):
            check_range(name, getattr(self, name), "m")

    @cached_property
    def quaternion(self) -> Array:
        """Nominal orientation (4,), (x, y, z, w), world frame."""
        return quaternion_from_rpy(self.rpy)


@dataclass(frozen=True)
class PositionIn:
    """A position, m: the origin of `frame` plus an offset along the world's axes or the frame's own.

    `aim` is the point of the tool, in its own frame, that is brought there: its origin, or the lip of what it holds.
    """

    frame: str
    offset: Vector
    axes: Literal["world", "own"] = "world"
    aim: Vector = (0.0, 0.0, 0.0)


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
    """A tool pose on the demonstrator's path and the time, s, an average person takes to it from the one before.

    Where the gripper closes or opens, the hand stops and rests for `dwell` s.
    """

    position: PositionIn
    orientation: OrientationIn
    duration: float
    gripper: Literal["close", "open"] | None = None
    dwell: float = 0.6

    def __post_init__(self) -> None:
        check_positive("duration and dwell", self.duration, self.dwell)

    @property
    def rest(self) -> float:
        """Time for which the hand rests here, s."""
        return 0.0 if self.gripper is None else self.dwell

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
class HeldObject:
    """An object in the gripper, and its pose in the tool's frame: position, m, and roll, pitch, yaw, rad."""

    object: str
    position: Vector
    rpy: Vector = (0.0, 0.0, 0.0)

    @cached_property
    def grip(self) -> Pose:
        """The same as a `Pose`, tool frame."""
        return Pose(np.array(self.position), quaternion_from_rpy(self.rpy))


@dataclass(frozen=True)
class MotionDescription:
    """One motion.

    Parameters
    ----------
    waypoints : tuple of Waypoint
        After the start; none where there is a curve.
    relations : Relations
        That the demonstrator obeys.
    success : SuccessDescription
    curve : Circle, Swing or SCurve, optional
        After the waypoints.
    start : StartDescription, optional
        Of its own.
    placements : mapping of object to Placement
        Of this motion, in place of the objects' own.
    holds : HeldObject, optional
        What is in the gripper when the motion begins. It is put there, unless the start is relative to it: then the
        tool is put to it.
    follows : str, optional
        The motion that is made before this one, which goes on from there.
    liquid : str, optional
        The vessel that the task's liquid is in when the motion begins (when the one that it follows begins).
    touches : tuple of str
        Objects that the hand may touch on its way, besides what it holds.
    """

    waypoints: tuple[Waypoint, ...]
    relations: Relations
    success: SuccessDescription
    title: str = ""
    start: StartDescription | None = None
    curve: Circle | Swing | SCurve | None = None
    placements: dict[str, Placement] = field(default_factory=dict)
    holds: HeldObject | None = None
    follows: str | None = None
    liquid: str | None = None
    touches: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.waypoints and self.curve is None:
            raise ValueError("a motion needs at least one waypoint, or a curve.")

    @property
    def duration(self) -> float:
        """Time an average person takes, s; with the rests while the gripper moves."""
        curve = 0.0 if self.curve is None else self.curve.duration
        return sum(waypoint.duration + waypoint.rest for waypoint in self.waypoints) + curve

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the objects that waypoints refer to, sorted."""
        frames = {frame for waypoint in self.waypoints for frame in waypoint.frames}
        return tuple(sorted(frames - {WORLD, START}))

    @property
    def moves_gripper(self) -> bool:
        """Whether the gripper opens or closes on the way, or holds something."""
        return self.holds is not None or any(waypoint.gripper is not None for waypoint in self.waypoints)

    @property
    def begins_open(self) -> bool:
        """Whether the gripper is open when the motion begins: it is, where the first thing it does is to close."""
        moves = [waypoint.gripper for waypoint in self.waypoints if waypoint.gripper is not None]
        return self.holds is None and bool(moves) and moves[0] == "close"

    @property
    def exempt(self) -> frozenset[str]:
        """Objects that the hand may touch: what it holds, and what it takes on the last piece of its way."""
        return frozenset(self.touches) | self.held

    @property
    def held(self) -> frozenset[str]:
        """Objects that are in the gripper when the motion begins."""
        return frozenset() if self.holds is None else frozenset({self.holds.object})
