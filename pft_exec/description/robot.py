"""A robot as data: ``robot.toml`` beside a URDF becomes a `RobotDescription`.

The URDF holds kinematics, inertials, limits and shapes; the TOML what a URDF cannot say. An arm that
``mirrors`` another states only what differs: limits, friction, springs and configurations are the other's, mirrored.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

from pft_exec.assets import robot_file
from pft_exec.description.arm import ArmDescription
from pft_exec.description.arm_tables import ArmTable, ToolTable, arms_from_tables, attach_tool
from pft_exec.description.strict import Place, read_strictly, suggestion
from pft_exec.description.urdf import UrdfStructure, read_urdf
from pft_exec.exceptions import UnknownNameError


@dataclass(frozen=True)
class Provenance:
    """Where a robot's figures are from."""

    upstream: str
    commit: str
    license: str


@dataclass(frozen=True)
class RobotDescription:
    """A robot as its folder describes it.

    Parameters
    ----------
    folder, urdf : Path
        Where it lies; its URDF (with the tool attached, if one was asked for).
    base_frame : str
        Root link of the URDF, the frame that tool poses are given in.
    arms : mapping of name to ArmDescription
    tools : tuple of str
        Names of the optional attachments.
    tool : str or None
        The attachment that this description carries.
    """

    name: str
    title: str
    folder: Path
    urdf: Path
    base_frame: str
    provenance: Provenance
    arms: Mapping[str, ArmDescription]
    tools: tuple[str, ...] = ()
    tool: str | None = None


@dataclass(frozen=True)
class _RobotTable:
    name: str
    title: str
    urdf: str
    base_frame: str
    provenance: Provenance
    arms: dict[str, ArmTable]
    tools: dict[str, ToolTable] = field(default_factory=dict)


def load_robot_description(name_or_path: str | Path, tool: str | None = None) -> RobotDescription:
    """Read a robot's folder.

    Parameters
    ----------
    name_or_path : str or Path
        Name of a robot that ships with the package, or a folder with a ``robot.toml``.
    tool : str or None
        An optional attachment that the robot offers; None is the bare robot.

    Raises
    ------
    UnknownRobotError
        If there is no such robot.
    UnknownNameError
        If the robot offers no such tool.
    DescriptionError
        If ``robot.toml`` is not one, or names a joint or link that the URDF lacks.
    """
    file = robot_file(name_or_path)
    table = read_strictly(file, _RobotTable)
    place, urdf = Place(file), table.urdf
    arms = arms_from_tables(place / "arms", table.arms)
    if tool is not None:
        if tool not in table.tools:
            raise UnknownNameError("tool", tool, table.tools, f"The robot is {table.name!r}.")
        arms = attach_tool(place / "tools" / tool, table.tools[tool], arms)
        urdf = table.tools[tool].urdf
    description = RobotDescription(
        name=table.name,
        title=table.title,
        folder=file.parent,
        urdf=file.parent / urdf,
        base_frame=table.base_frame,
        provenance=table.provenance,
        arms=MappingProxyType(arms),
        tools=tuple(table.tools),
        tool=tool,
    )
    _check_urdf(place, description)
    return description


def _check_urdf(place: Place, description: RobotDescription) -> None:
    """Refuse a description whose joints, frames or configurations the URDF does not have."""
    urdf = read_urdf(description.urdf)
    if description.base_frame != urdf.root:
        (place / "base_frame").refuse(
            f"expected the root link of the URDF, {urdf.root!r}, got {description.base_frame!r}."
        )
    for name, arm in description.arms.items():
        here = place / "arms" / name
        _check_link(here / "tool_frame", arm.tool_frame, urdf)
        _check_chain(here / "joints", arm, urdf)
    for name, arm in description.arms.items():
        here = place / "arms" / name
        _check_configurations(here / "configurations", arm, urdf)
        if arm.gripper is not None:
            _check_link(here / "gripper.palm_link", arm.gripper.palm_link, urdf)
            _check_known(here / "gripper.joints", arm.gripper.joints, urdf)


def _check_link(place: Place, link: str, urdf: UrdfStructure) -> None:
    if link not in urdf.links:
        place.refuse(f"the URDF has no link {link!r}.{suggestion(link, urdf.links)}")


def _check_known(place: Place, joints: tuple[str, ...], urdf: UrdfStructure) -> None:
    for joint in joints:
        if joint not in urdf.joints:
            place.refuse(f"the URDF has no joint {joint!r}.{suggestion(joint, tuple(urdf.joints))}")


def _check_chain(place: Place, arm: ArmDescription, urdf: UrdfStructure) -> None:
    """Refuse joints that are not those which move the tool, base to tool, each of one number and with limits."""
    _check_known(place, arm.joints, urdf)
    moving = tuple(joint.name for joint in urdf.chain(arm.tool_frame) if joint.kind != "fixed")
    if moving != arm.joints:
        place.refuse(f"expected the joints from base to {arm.tool_frame!r} in order: {', '.join(moving)}.")
    for joint in (urdf.joints[name] for name in moving):
        if joint.kind not in ("revolute", "prismatic"):
            place.refuse(f"{joint.name!r} is {joint.kind!r}; write it as 'revolute' with limits, such as +-1000 rad.")
        if not joint.lower <= joint.soft_lower < joint.soft_upper <= joint.upper:
            place.refuse(f"{joint.name!r} needs limits in the URDF, lower below upper and soft ones inside the hard.")
        if not joint.velocity > 0.0 or not joint.effort > 0.0:
            place.refuse(f"{joint.name!r} needs a velocity and an effort above 0 in the URDF.")


def _check_configurations(place: Place, arm: ArmDescription, urdf: UrdfStructure) -> None:
    for name, values in arm.configurations.items():
        for joint, value in zip((urdf.joints[name] for name in arm.joints), values, strict=True):
            if not joint.soft_lower <= value <= joint.soft_upper:
                limits = f"[{joint.soft_lower:.4g}, {joint.soft_upper:.4g}]"
                (place / name / joint.name).refuse(
                    f"expected a value within its soft limits, {limits} rad, got {value:.4g}."
                )
