"""Objects of a task: furniture, placements, and the free space that they keep."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pft_exec.description.quantities import FixedPose, Range, Vector, check_positive, check_range
from pft_exec.description.shape import (
    BoxShape,
    CompoundShape,
    CylinderShape,
    SphereShape,
    TrayShape,
    VesselShape,
)


@dataclass(frozen=True)
class Placement:
    """Where an object may stand: on top of a fixed one, x, y, m, and yaw, rad, drawn from these ranges, world frame."""

    on: str
    x: Range
    y: Range
    yaw: Range = (0.0, 0.0)

    def __post_init__(self) -> None:
        check_range("x", self.x, "m")
        check_range("y", self.y, "m")
        check_range("yaw", self.yaw, "rad")


@dataclass(frozen=True)
class ObjectDescription:
    """One object.

    Parameters
    ----------
    shape : one of `pft_exec.description.shape`
        Its frame stands in the middle of it.
    mass : float, kg
        Of an object that is placed; a fixed one has none.
    friction : float
        Lateral friction coefficient.
    color : (3,)
        Red, green, blue in [0, 1].
    symmetry : "none" or "z"
        "z": turned about its own z axis it is the same.
    immovable : bool
        Bolted down where it is placed: part of the scene, but nothing moves it.
    fixed, placement : FixedPose or Placement
        One of the two: furniture, which is no part of a scene, or an object whose pose is drawn.

    Raises
    ------
    DescriptionError
        If it has both or neither of `fixed` and `placement`, or a placed object has no mass.
    """

    shape: BoxShape | CylinderShape | SphereShape | VesselShape | TrayShape | CompoundShape
    mass: float = 0.0
    friction: float = 1.0
    color: Vector = (0.6, 0.6, 0.6)
    symmetry: Literal["none", "z"] = "none"
    immovable: bool = False
    fixed: FixedPose | None = None
    placement: Placement | None = None

    def __post_init__(self) -> None:
        if (self.fixed is None) == (self.placement is None):
            raise ValueError("an object is either fixed (a pose) or has a placement (ranges); give exactly one.")
        if self.placement is not None and not self.immovable:
            check_positive("mass of an object that is placed", self.mass)


@dataclass(frozen=True)
class LiquidDescription:
    """What is poured: so many balls of a radius, m, a mass, kg, and a friction coefficient among one another."""

    count: int = 20
    radius: float = 0.008
    mass: float = 0.0021
    friction: float = 0.3
    color: Vector = (0.35, 0.55, 0.90)

    def __post_init__(self) -> None:
        check_positive("count, radius and mass", self.count, self.radius, self.mass)


@dataclass(frozen=True)
class HandEnvelope:
    """Room of a hand: a capsule on an axis of the tool from `behind` to `ahead` of it, m, and a `gap` around it."""

    behind: float
    ahead: float
    radius: float
    gap: float = 0.0
    axis: Literal["x", "z"] = "x"


@dataclass(frozen=True)
class Clearance:
    """Free space that drawn scenes and paths keep: between outlines of objects, m, and around the hand."""

    objects: float
    hand: HandEnvelope
