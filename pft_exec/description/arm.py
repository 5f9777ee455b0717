"""An arm as data: joint names, and what a URDF cannot say of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Grade = Literal["A", "B", "C"]


@dataclass(frozen=True)
class Graded:
    """Numbers with their grade (A measured, B derived, C placeholder) and where they are from."""

    values: tuple[float, ...]
    grade: Grade
    source: str


@dataclass(frozen=True)
class GripperDescription:
    """A parallel gripper: finger joints whose positions (m) sum to the opening between the pads.

    Parameters
    ----------
    palm_link : str
        The link that the fingers slide on.
    joints : tuple of str
        Prismatic finger joints; 0 is closed.
    closed_width, open_width : float, m
        Openings commanded as "closed" and "open".
    force : Graded, (1,), N
        Grip force at each finger.
    """

    palm_link: str
    joints: tuple[str, ...]
    closed_width: float
    open_width: float
    force: Graded


@dataclass(frozen=True)
class CounterbalanceDescription:
    """Springs that carry an arm: the gradient of its gravity potential with the `frozen` joints held.

    Parameters
    ----------
    joints : tuple of str
        Joints that the springs act on.
    frozen : mapping of joint name to rad
        Posture of the joints that the springs cannot know of.
    fraction : float
        Share of the potential that the springs carry.
    """

    joints: tuple[str, ...]
    frozen: Mapping[str, float]
    fraction: float
    grade: Grade
    source: str


@dataclass(frozen=True)
class ArmDescription:
    """One arm: joint names from base to tool, and what the URDF cannot say about them.

    Parameters
    ----------
    acceleration, jerk : Graded, (n,), rad/s^2 and rad/s^3
    coulomb, viscous : Graded, (n,), N m and N m s/rad
        Friction of the simulated joints.
    configurations : mapping of name to (n,) rad, in the order of `joints`
    counterbalance : CounterbalanceDescription or None
        Springs of the real arm, which the effort limits count on.
    gripper : GripperDescription or None
    mirror_arm : str or None
        The arm on the other side.
    mirror_signs : (n,)
        Configuration of the other arm = signs times configuration of this one.
    """

    name: str
    tool_frame: str
    joints: tuple[str, ...]
    acceleration: Graded
    jerk: Graded
    coulomb: Graded
    viscous: Graded
    configurations: Mapping[str, tuple[float, ...]]
    counterbalance: CounterbalanceDescription | None
    gripper: GripperDescription | None
    mirror_arm: str | None = None
    mirror_signs: tuple[float, ...] | None = None
