"""Checks of a robot or task that a user brings: what was looked at, whether it holds, and what to mend."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pft_exec.demonstration import Scene
from pft_exec.description import TaskDescription, draw_settings, load_robot_description, load_task, random_stream
from pft_exec.description.inertial import impossible_inertials
from pft_exec.exceptions import PFTError, SimulationError, UnknownNameError, UnknownRobotError, UnknownTaskError
from pft_exec.geometry import Array, Pose, geodesic_distance
from pft_exec.model import Arm, RobotModel, load_robot
from pft_exec.report.tables import Row
from pft_exec.simulation import World
from pft_exec.simulation.reading import ArmReading, read_arm

_SETTINGS = 5  # drawn for each motion of a task
_HOLD = 1.0  # s
_DRIFT = 0.01  # rad; friction of the joints keeps an arm with a right model far below
_SAME = 1e-6  # rad, N m, rad/s; limits that are the same
_SAME_PLACE, _SAME_TURN = 1e-6, 1e-6  # m, rad; the engine's own poses have single precision
_SAME_TORQUE = 1e-2  # N m; locking fingers leaves 1e-4, a link of unknown mass some N m
_FURNITURE = "tabletop"  # the task whose workspace and robot base the empty world borrows


def check_description(kind: str, name: str) -> list[Row]:
    """Check a robot or a task and everything that it names.

    Parameters
    ----------
    kind : str
        "robot" or "task".
    name : str
        Its name, or the path of its folder.

    Returns
    -------
    list of {"check", "ok", "detail"}
        A failed step ends the list: what follows needs it.

    Raises
    ------
    UnknownNameError
        If there is no such kind, or no robot or task of that name.
    """
    checkers: dict[str, Callable[[str], list[Row]]] = {"robot": _check_robot, "task": _check_task}
    if kind not in checkers:
        raise UnknownNameError("kind of description", kind, checkers)
    return checkers[kind](name)


def _tried(rows: list[Row], check: str, step: Callable[[], tuple[Any, str]]) -> Any:
    """Run a step, add its row, and return what it made; None where it failed."""
    try:
        made, detail = step()
    except (UnknownRobotError, UnknownTaskError):
        raise
    except PFTError as error:
        rows.append({"check": check, "ok": False, "detail": str(error)})
        return None
    rows.append({"check": check, "ok": True, "detail": detail})
    return made


def _check_task(name: str) -> list[Row]:
    rows: list[Row] = []
    task: TaskDescription | None = _tried(rows, "description", lambda: _described(load_task(name), "motions", "labels"))
    for label in () if task is None else task.labels:
        rows.append(_motion_row(task, label))
    return rows


def _motion_row(task: Any, label: str) -> Row:
    """Can settings be drawn in which that motion's path is free and stays in the workspace?"""
    try:
        draw_settings(task, label, _SETTINGS, random_stream(0, "evaluate", label))
    except PFTError as error:
        return _row(f"motion {label}", False, str(error))
    return _row(f"motion {label}", True, f"{_SETTINGS} settings drawn")


def _check_robot(name: str) -> list[Row]:
    rows: list[Row] = []
    if _tried(rows, "description", lambda: _described(load_robot_description(name), "arms", "arms")) is None:
        return rows
    robot: RobotModel | None = _tried(rows, "model", lambda: _described(load_robot(name), "arms", "arms"))
    if robot is None:
        return rows
    rows.append(_inertial_row(robot.description.urdf))
    for arm in robot.arms:
        rows += [_gravity_row(robot.arm(arm), q) for q in robot.arm(arm).configurations]
        rows += _engine_rows(robot, robot.arm(arm))
    _tried(rows, "gravity compensation for one simulated second", lambda: _held(robot))
    return rows


def _described(description: Any, what: str, attribute: str) -> tuple[Any, str]:
    names = tuple(getattr(description, attribute))
    return description, f"{len(names)} {what}: {', '.join(names)}"


def _inertial_row(urdf: Path) -> Row:
    """Has every link a mass and an inertia that a body can have?"""
    bad = [f"link {link!r}: {reason}" for link, reason in impossible_inertials(urdf).items()]
    return _row("inertials", not bad, "; ".join(bad) or "masses and principal moments are none below zero")


def _gravity_row(arm: Arm, configuration: str) -> Row:
    """Can the motors hold the arm still in a named configuration, within its joint limits?"""
    q = arm.configuration(configuration)
    inside = (q >= arm.limits.lower) & (q <= arm.limits.upper)
    share = np.abs(arm.gravity(q) - arm.counterbalance(q)) / arm.limits.torque
    worst = int(np.argmax(share))
    detail = f"{arm.joint_names[worst]} holds with {100.0 * share[worst]:.0f} % of its torque"
    if not inside.all():
        detail = f"{arm.joint_names[int(np.argmin(inside))]} stands beyond its limits"
    return _row(f"{arm.name} arm, {configuration!r}", bool(inside.all() and share[worst] <= 1.0), detail)


def _engine_rows(robot: RobotModel, arm: Arm) -> list[Row]:
    """Do model and simulator have the same arm: joints, limits, tool pose, gravity?"""
    rows: list[Row] = []
    q = _inside(arm)
    gravity = arm.gravity(q)
    reading: ArmReading | None = _tried(
        rows,
        f"{arm.name} arm in the simulator",
        lambda: (read_arm(robot, arm.name, q, gravity), f"{len(arm.joint_names)} joints"),
    )
    if reading is None:
        return rows
    if reading.missing:
        detail = f"joint {reading.missing[0]!r} does not move in the simulator; give it a type that moves, and limits"
        return [_row(f"{arm.name} arm in the simulator", False, detail)]
    return [
        *rows,
        _limits_row(arm, reading),
        _tool_row(arm, arm.forward(q), reading),
        _agreement_row(arm, arm.mass_matrix(q) @ reading.acceleration),
    ]


def _inside(arm: Arm) -> Array:
    """Joints (n,), rad, in the first named configuration, else in the middle of the limits."""
    for name in arm.configurations:
        return arm.configuration(name)
    limits = arm.limits
    middle: Array = 0.5 * (np.maximum(limits.lower, -np.pi) + np.minimum(limits.upper, np.pi))
    return middle


def _limits_row(arm: Arm, reading: ArmReading) -> Row:
    """The model may keep to less than the simulator allows, never to more."""
    limits = arm.limits
    beyond = {
        "lower limit": reading.lower - limits.lower,
        "upper limit": limits.upper - reading.upper,
        "torque limit": limits.torque - reading.torque,
        "velocity limit": limits.velocity - reading.velocity,
    }
    for name, values in beyond.items():
        worst = int(np.argmax(values))
        if values[worst] > _SAME:
            detail = (
                f"{arm.joint_names[worst]}: its {name} is {values[worst]:.3g} beyond the simulator's; mend the URDF"
            )
            return _row(f"{arm.name} arm, limits", False, detail)
    return _row(f"{arm.name} arm, limits", True, "within the simulator's")


def _tool_row(arm: Arm, tool: Pose, reading: ArmReading) -> Row:
    distance = float(np.linalg.norm(tool.position - reading.tool.position))
    turned = float(geodesic_distance(tool.quaternion, reading.tool.quaternion))
    ok = distance <= _SAME_PLACE and turned <= _SAME_TURN
    mend = "" if ok else "; joint origins or axes are read differently: give each joint an axis and an origin"
    return _row(f"{arm.name} arm, tool pose", ok, f"{1e3 * distance:.1e} mm and {turned:.1e} rad apart{mend}")


def _agreement_row(arm: Arm, missing: Array) -> Row:
    """`missing` (n,), N m: what the model's gravity torque lacks to hold the simulated arm, friction apart."""
    worst = int(np.argmax(np.abs(missing)))
    ok = abs(float(missing[worst])) <= _SAME_TORQUE
    mend = "" if ok else "; give every link an <inertial>: without one the simulator takes 1 kg, the model none"
    detail = f"{arm.joint_names[worst]} lacks {abs(float(missing[worst])):.1e} N m{mend}"
    return _row(f"{arm.name} arm, gravity held without friction", ok, detail)


def _held(robot: RobotModel) -> tuple[float, str]:
    """Hold every arm against gravity in an empty world; how far the joints drift, rad."""
    empty = replace(load_task(_FURNITURE), objects={}, motions={})
    with World(robot, empty, Scene({})) as world:
        before = {arm: world.state(arm)[0] for arm in robot.arms}
        while world.time < _HOLD:
            for arm in robot.arms:
                q = world.state(arm)[0]
                world.command(arm, robot.arm(arm).gravity(q) - robot.arm(arm).counterbalance(q))
            world.step()
        drift = max(float(np.abs(world.state(arm)[0] - before[arm]).max()) for arm in robot.arms)
    if drift > _DRIFT:
        raise SimulationError(
            f"an arm drifts by {drift:.3g} rad in {_HOLD:g} s; at most {_DRIFT} rad are expected. "
            f"Masses, centers of mass or the counterbalance differ between model and simulator."
        )
    return drift, f"the joints drift by {drift:.1e} rad"


def _row(check: str, ok: bool, detail: str) -> Row:
    return {"check": check, "ok": ok, "detail": detail}
