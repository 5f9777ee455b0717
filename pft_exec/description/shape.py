"""Shapes of objects: solid ones, hollow ones that something fits into, and several fixed to one another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pft_exec.description.quantities import Vector, check_positive


@dataclass(frozen=True)
class BoxShape:
    """A box: full lengths along its own x, y, z, m."""

    kind: Literal["box"]
    size: Vector

    def __post_init__(self) -> None:
        check_positive("size", *self.size)

    @property
    def height(self) -> float:
        """Extent along z, m."""
        return self.size[2]

    @property
    def outline(self) -> float:
        """Radius of the upright cylinder around it, m."""
        return 0.5 * float((self.size[0] ** 2 + self.size[1] ** 2) ** 0.5)


@dataclass(frozen=True)
class CylinderShape:
    """An upright cylinder: radius and height, m; its axis is z."""

    kind: Literal["cylinder"]
    radius: float
    height: float

    def __post_init__(self) -> None:
        check_positive("radius and height", self.radius, self.height)

    @property
    def outline(self) -> float:
        """Radius of the upright cylinder around it, m."""
        return self.radius


@dataclass(frozen=True)
class SphereShape:
    """A ball of a radius, m."""

    kind: Literal["sphere"]
    radius: float

    def __post_init__(self) -> None:
        check_positive("radius", self.radius)

    @property
    def height(self) -> float:
        """Extent along z, m."""
        return 2.0 * self.radius

    @property
    def outline(self) -> float:
        """Radius of the upright cylinder around it, m."""
        return self.radius


@dataclass(frozen=True)
class VesselShape:
    """A round vessel, open at the top: outer radius, height and wall, m; its axis is z.

    Its shell is made of `sides` flat walls. In a run without liquid it is as solid as a cylinder, which costs less.
    """

    kind: Literal["vessel"]
    radius: float
    height: float
    wall: float = 0.006
    sides: int = 8

    def __post_init__(self) -> None:
        check_positive("radius, height and wall", self.radius, self.height, self.wall)
        if not 3 <= self.sides <= 15:
            raise ValueError(f"a vessel has 3 to 15 sides; got {self.sides}.")
        if self.wall >= min(self.radius, self.height):
            raise ValueError(f"a wall of {self.wall} m leaves nothing of the inside.")

    @property
    def outline(self) -> float:
        """Radius of the upright cylinder around it, m."""
        return self.radius


@dataclass(frozen=True)
class TrayShape:
    """A box that is open at the top: outer lengths along its own x, y, z and wall, m."""

    kind: Literal["tray"]
    size: Vector
    wall: float = 0.006

    def __post_init__(self) -> None:
        check_positive("size and wall", *self.size, self.wall)
        if 2.0 * self.wall >= min(self.size[:2]) or self.wall >= self.size[2]:
            raise ValueError(f"a wall of {self.wall} m leaves nothing of the inside.")

    @property
    def height(self) -> float:
        """Extent along z, m."""
        return self.size[2]

    @property
    def outline(self) -> float:
        """Radius of the upright cylinder around it, m."""
        return 0.5 * float((self.size[0] ** 2 + self.size[1] ** 2) ** 0.5)


@dataclass(frozen=True)
class Part:
    """One shape of a compound and where its middle is, m, in the compound's frame."""

    shape: BoxShape | CylinderShape | SphereShape
    position: Vector


@dataclass(frozen=True)
class CompoundShape:
    """Several shapes fixed to one another, such as two posts; `outline` and `height`, m, of all, centered."""

    kind: Literal["compound"]
    parts: tuple[Part, ...]
    outline: float
    height: float

    def __post_init__(self) -> None:
        check_positive("outline and height", self.outline, self.height)
        if not self.parts:
            raise ValueError("a compound needs at least one part.")


Shape = BoxShape | CylinderShape | SphereShape | VesselShape | TrayShape | CompoundShape
