"""From the tables of a ``robot.toml`` to arms: what an arm does not state is that of the arm it mirrors."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from pft_exec.description.arm import ArmDescription, CounterbalanceDescription, Graded, GripperDescription
from pft_exec.description.strict import Place, suggestion


@dataclass(frozen=True)
class GripperTable:
    palm_link: str
    joints: tuple[str, ...]
    closed_width: float | None = None
    open_width: float | None = None
    force: Graded | None = None


@dataclass(frozen=True)
class ArmTable:
    tool_frame: str
    joints: tuple[str, ...]
    mirrors: str | None = None
    mirror_signs: tuple[float, ...] | None = None
    acceleration: Graded | None = None
    jerk: Graded | None = None
    coulomb: Graded | None = None
    viscous: Graded | None = None
    counterbalance: CounterbalanceDescription | None = None
    gripper: GripperTable | None = None
    configurations: dict[str, dict[str, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class AttachmentTable:
    tool_frame: str
    gripper: GripperTable | None = None


@dataclass(frozen=True)
class ToolTable:
    urdf: str
    arms: dict[str, AttachmentTable]


def arms_from_tables(place: Place, tables: Mapping[str, ArmTable]) -> dict[str, ArmDescription]:
    """Complete every arm, checked; arms that mirror one another know of each other."""
    if not tables:
        place.refuse("expected at least one arm.")
    arms: dict[str, ArmDescription] = {}
    for name, table in sorted(tables.items(), key=lambda item: item[1].mirrors is not None):
        if table.mirrors is None:
            arms[name] = _arm(place / name, name, table)
            continue
        other = _mirrored(place / name, name, table, arms)
        arm = _arm(place / name, name, _filled(table, other))
        arms[name] = dataclasses.replace(arm, mirror_arm=other.name, mirror_signs=table.mirror_signs)
        arms[other.name] = dataclasses.replace(other, mirror_arm=name, mirror_signs=table.mirror_signs)
    return {name: arms[name] for name in tables}


def attach_tool(place: Place, tool: ToolTable, arms: Mapping[str, ArmDescription]) -> dict[str, ArmDescription]:
    """Give arms the tool frame and gripper of an attachment."""
    attached = dict(arms)
    for name, table in tool.arms.items():
        here = place / "arms" / name
        if name not in arms:
            here.refuse(f"no arm is named {name!r}.{suggestion(name, tuple(arms))}")
        gripper = _gripper(here / "gripper", table.gripper)
        attached[name] = dataclasses.replace(arms[name], tool_frame=table.tool_frame, gripper=gripper)
    return attached


def _arm(place: Place, name: str, table: ArmTable) -> ArmDescription:
    if not table.joints:
        (place / "joints").refuse("expected at least one joint.")
    if table.mirror_signs is not None and table.mirrors is None:
        (place / "mirror_signs").refuse("an arm has signs only where it says which arm it `mirrors`.")
    return ArmDescription(
        name=name,
        tool_frame=table.tool_frame,
        joints=table.joints,
        acceleration=_one_a_joint(place / "acceleration", table.acceleration, table.joints),
        jerk=_one_a_joint(place / "jerk", table.jerk, table.joints),
        coulomb=_one_a_joint(place / "coulomb", table.coulomb, table.joints),
        viscous=_one_a_joint(place / "viscous", table.viscous, table.joints),
        configurations=MappingProxyType(_configurations(place / "configurations", table)),
        counterbalance=_counterbalance(place / "counterbalance", table),
        gripper=_gripper(place / "gripper", table.gripper),
    )


def _one_a_joint(place: Place, numbers: Graded | None, joints: tuple[str, ...]) -> Graded:
    if numbers is None:
        place.refuse("missing key; an arm that mirrors no other must state it.")
    if len(numbers.values) != len(joints):
        (place / "values").refuse(f"expected {len(joints)} numbers, one a joint, got {len(numbers.values)}.")
    if min(numbers.values) < 0.0:
        (place / "values").refuse(f"expected numbers of at least 0, got {min(numbers.values)}.")
    return numbers


def _configurations(place: Place, table: ArmTable) -> dict[str, tuple[float, ...]]:
    configurations = {}
    for name, by_joint in table.configurations.items():
        _check_joints(place / name, by_joint, table.joints)
        missing = [joint for joint in table.joints if joint not in by_joint]
        if missing:
            (place / name / missing[0]).refuse("missing key; a configuration names every joint of the arm.")
        configurations[name] = tuple(by_joint[joint] for joint in table.joints)
    return configurations


def _check_joints(place: Place, named: Any, joints: tuple[str, ...]) -> None:
    for joint in named:
        if joint not in joints:
            place.refuse(f"no joint of this arm is named {joint!r}.{suggestion(joint, joints)}")


def _counterbalance(place: Place, table: ArmTable) -> CounterbalanceDescription | None:
    springs = table.counterbalance
    if springs is None:
        return None
    _check_joints(place / "joints", springs.joints, table.joints)
    _check_joints(place / "frozen", springs.frozen, table.joints)
    return dataclasses.replace(springs, frozen=MappingProxyType(dict(springs.frozen)))


def _gripper(place: Place, table: GripperTable | None) -> GripperDescription | None:
    if table is None:
        return None
    if table.closed_width is None or table.open_width is None or table.force is None:
        place.refuse("missing key; expected `closed_width`, `open_width` and `force`.")
    if not 0.0 <= table.closed_width < table.open_width:
        (place / "open_width").refuse(
            f"expected more than the closed width, {table.closed_width} m, got {table.open_width}."
        )
    _one_a_joint(place / "force", table.force, ("each finger",))
    return GripperDescription(table.palm_link, table.joints, table.closed_width, table.open_width, table.force)


def _mirrored(place: Place, name: str, table: ArmTable, arms: Mapping[str, ArmDescription]) -> ArmDescription:
    """The arm that an arm mirrors, checked to fit."""
    free = tuple(other for other, arm in arms.items() if arm.mirror_arm is None)
    if table.mirrors not in free:
        (place / "mirrors").refuse(
            f"no arm to mirror is named {table.mirrors!r}.{suggestion(str(table.mirrors), free)}"
        )
    other = arms[table.mirrors]
    signs, count = table.mirror_signs or (), len(other.joints)
    if len(table.joints) != count:
        (place / "joints").refuse(
            f"arm {name!r} mirrors {other.name!r}, which has {count} joints; got {len(table.joints)}."
        )
    if len(signs) != count or set(signs) - {-1.0, 1.0}:
        (place / "mirror_signs").refuse(f"expected {count} signs, each 1 or -1, one a joint; got {list(signs)}.")
    return other


def _filled(table: ArmTable, other: ArmDescription) -> ArmTable:
    """The table of an arm with what it does not state taken from `other` and mirrored."""
    signs = table.mirror_signs or ()
    configurations = {
        name: {joint: sign * value for joint, sign, value in zip(table.joints, signs, values, strict=True)}
        for name, values in other.configurations.items()
    }
    return dataclasses.replace(
        table,
        acceleration=table.acceleration or other.acceleration,
        jerk=table.jerk or other.jerk,
        coulomb=table.coulomb or other.coulomb,
        viscous=table.viscous or other.viscous,
        configurations=configurations | table.configurations,
        counterbalance=table.counterbalance or _mirrored_springs(table, other),
        gripper=_filled_gripper(table.gripper, other.gripper),
    )


def _mirrored_springs(table: ArmTable, other: ArmDescription) -> CounterbalanceDescription | None:
    springs = other.counterbalance
    if springs is None:
        return None
    twin = dict(zip(other.joints, table.joints, strict=True))
    sign = dict(zip(other.joints, table.mirror_signs or (), strict=True))
    frozen = {twin[joint]: sign[joint] * value for joint, value in springs.frozen.items()}
    return dataclasses.replace(springs, joints=tuple(twin[joint] for joint in springs.joints), frozen=frozen)


def _filled_gripper(table: GripperTable | None, other: GripperDescription | None) -> GripperTable | None:
    if table is None or other is None:
        return table
    return GripperTable(
        table.palm_link,
        table.joints,
        other.closed_width if table.closed_width is None else table.closed_width,
        other.open_width if table.open_width is None else table.open_width,
        table.force or other.force,
    )
