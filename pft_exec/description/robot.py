"""A robot as data: ``robot.toml`` beside a URDF becomes a `RobotDescription`.

The URDF holds kinematics, inertials, limits and shapes; the TOML what a URDF cannot say. An arm that
``mirrors`` another states only what differs: limits, friction, springs and configurations are the other's, mirrored.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Literal, NoReturn

from pft_exec.assets import robot_file
from pft_exec.description.strict import read_strictly, suggestion
from pft_exec.exceptions import DescriptionError, UnknownNameError

Grade = Literal["A", "B", "C"]


@dataclass(frozen=True)
class Graded:
    """Numbers with their grade (A measured, B derived, C placeholder) and where they are from."""

    values: tuple[float, ...]
    grade: Grade
    source: str


@dataclass(frozen=True)
class Provenance:
    """Where a robot's figures are from."""

    upstream: str
    commit: str
    license: str


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
class _GripperTable:
    palm_link: str
    joints: tuple[str, ...]
    closed_width: float | None = None
    open_width: float | None = None
    force: Graded | None = None


@dataclass(frozen=True)
class _ArmTable:
    tool_frame: str
    joints: tuple[str, ...]
    mirrors: str | None = None
    mirror_signs: tuple[float, ...] | None = None
    acceleration: Graded | None = None
    jerk: Graded | None = None
    coulomb: Graded | None = None
    viscous: Graded | None = None
    counterbalance: CounterbalanceDescription | None = None
    gripper: _GripperTable | None = None
    configurations: dict[str, dict[str, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class _AttachmentTable:
    tool_frame: str
    gripper: _GripperTable | None = None


@dataclass(frozen=True)
class _ToolTable:
    urdf: str
    arms: dict[str, _AttachmentTable]


@dataclass(frozen=True)
class _RobotTable:
    name: str
    title: str
    urdf: str
    base_frame: str
    provenance: Provenance
    arms: dict[str, _ArmTable]
    tools: dict[str, _ToolTable] = field(default_factory=dict)


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
    if tool is not None and tool not in table.tools:
        raise UnknownNameError("tool", tool, table.tools, f"The robot is {table.name!r}.")
    arms = _arms(file, table)
    urdf = table.urdf
    if tool is not None:
        urdf = table.tools[tool].urdf
        arms = _attached(file, arms, table.tools[tool], f"tools.{tool}")
    return RobotDescription(
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


def _refuse(file: Path, key: str, message: str) -> NoReturn:
    raise DescriptionError(f"{file}: {key}: {message}")


def _arms(file: Path, table: _RobotTable) -> dict[str, ArmDescription]:
    if not table.arms:
        _refuse(file, "arms", "expected at least one arm.")
    complete = {name: _complete_arm(file, name, arm) for name, arm in table.arms.items() if arm.mirrors is None}
    arms = {}
    for name, arm in table.arms.items():
        arms[name] = complete[name] if arm.mirrors is None else _mirrored_arm(file, name, arm, complete)
    for name, arm in table.arms.items():
        if arm.mirrors is not None:
            signs = arms[name].mirror_signs
            arms[arm.mirrors] = dataclasses.replace(arms[arm.mirrors], mirror_arm=name, mirror_signs=signs)
    return arms


def _complete_arm(file: Path, name: str, table: _ArmTable) -> ArmDescription:
    key = f"arms.{name}"
    graded = {word: getattr(table, word) for word in ("acceleration", "jerk", "coulomb", "viscous")}
    for word, numbers in graded.items():
        if numbers is None:
            _refuse(file, f"{key}.{word}", "missing key; an arm that mirrors no other must state it.")
        _check_length(file, f"{key}.{word}.values", numbers.values, table.joints)
    return ArmDescription(
        name=name,
        tool_frame=table.tool_frame,
        joints=table.joints,
        **graded,
        configurations=MappingProxyType(_configurations(file, key, table)),
        counterbalance=_counterbalance(file, key, table),
        gripper=_gripper(file, f"{key}.gripper", table.gripper),
    )


def _check_length(file: Path, key: str, values: tuple[float, ...], joints: tuple[str, ...]) -> None:
    if len(values) != len(joints):
        _refuse(file, key, f"expected {len(joints)} numbers, one a joint, got {len(values)}.")
    if min(values) < 0.0:
        _refuse(file, key, f"expected numbers of at least 0, got {min(values)}.")


def _check_joint(file: Path, key: str, joint: str, joints: tuple[str, ...]) -> None:
    if joint not in joints:
        _refuse(file, key, f"no joint of this arm is named {joint!r}.{suggestion(joint, joints)}")


def _configurations(file: Path, key: str, table: _ArmTable) -> dict[str, tuple[float, ...]]:
    configurations = {}
    for name, by_joint in table.configurations.items():
        here = f"{key}.configurations.{name}"
        for joint in by_joint:
            _check_joint(file, here, joint, table.joints)
        missing = [joint for joint in table.joints if joint not in by_joint]
        if missing:
            _refuse(file, here, f"missing key {missing[0]!r}; a configuration names every joint of the arm.")
        configurations[name] = tuple(by_joint[joint] for joint in table.joints)
    return configurations


def _counterbalance(file: Path, key: str, table: _ArmTable) -> CounterbalanceDescription | None:
    springs = table.counterbalance
    if springs is None:
        return None
    for joint in springs.joints:
        _check_joint(file, f"{key}.counterbalance.joints", joint, table.joints)
    for joint in springs.frozen:
        _check_joint(file, f"{key}.counterbalance.frozen", joint, table.joints)
    return dataclasses.replace(springs, frozen=MappingProxyType(dict(springs.frozen)))


def _gripper(
    file: Path, key: str, table: _GripperTable | None, other: GripperDescription | None = None
) -> GripperDescription | None:
    if table is None:
        return None
    stated = {word: getattr(table, word) for word in ("closed_width", "open_width", "force")}
    for word, value in stated.items():
        if value is None and other is None:
            _refuse(file, f"{key}.{word}", "missing key.")
        stated[word] = getattr(other, word) if value is None else value
    return GripperDescription(palm_link=table.palm_link, joints=table.joints, **stated)


def _mirrored_arm(file: Path, name: str, table: _ArmTable, complete: Mapping[str, ArmDescription]) -> ArmDescription:
    key = f"arms.{name}"
    if table.mirrors is None or table.mirrors not in complete:
        choices = suggestion(str(table.mirrors), tuple(complete))
        _refuse(file, f"{key}.mirrors", f"no arm that stands for itself is named {table.mirrors!r}.{choices}")
    other = complete[table.mirrors]
    signs = table.mirror_signs or ()
    if len(table.joints) != len(other.joints) or len(signs) != len(other.joints) or set(signs) - {-1.0, 1.0}:
        message = (
            f"expected {len(other.joints)} joints and as many signs, each 1 or -1, as arm {other.name!r} has joints"
        )
        _refuse(file, f"{key}.mirror_signs", f"{message}; got {len(table.joints)} joints and signs {list(signs)}.")
    own = _configurations(file, key, table)
    configurations = {word: _signed(signs, values) for word, values in other.configurations.items()} | own
    return ArmDescription(
        name=name,
        tool_frame=table.tool_frame,
        joints=table.joints,
        **{
            word: getattr(table, word) or getattr(other, word)
            for word in ("acceleration", "jerk", "coulomb", "viscous")
        },
        configurations=MappingProxyType(configurations),
        counterbalance=_counterbalance(file, key, table) or _mirrored_springs(other, table.joints, signs),
        gripper=_gripper(file, f"{key}.gripper", table.gripper, other.gripper),
        mirror_arm=other.name,
        mirror_signs=signs,
    )


def _signed(signs: tuple[float, ...], values: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(sign * value for sign, value in zip(signs, values, strict=True))


def _mirrored_springs(
    other: ArmDescription, joints: tuple[str, ...], signs: tuple[float, ...]
) -> CounterbalanceDescription | None:
    springs = other.counterbalance
    if springs is None:
        return None
    place = {joint: index for index, joint in enumerate(other.joints)}
    frozen = {joints[place[joint]]: signs[place[joint]] * value for joint, value in springs.frozen.items()}
    acting = tuple(joints[place[joint]] for joint in springs.joints)
    return dataclasses.replace(springs, joints=acting, frozen=MappingProxyType(frozen))


def _attached(file: Path, arms: Mapping[str, ArmDescription], tool: _ToolTable, key: str) -> dict[str, ArmDescription]:
    attached = dict(arms)
    for name, table in tool.arms.items():
        if name not in arms:
            _refuse(file, f"{key}.arms.{name}", f"no arm is named {name!r}.{suggestion(name, tuple(arms))}")
        gripper = _gripper(file, f"{key}.arms.{name}.gripper", table.gripper, arms[name].gripper)
        attached[name] = dataclasses.replace(arms[name], tool_frame=table.tool_frame, gripper=gripper)
    return attached
