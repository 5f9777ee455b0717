"""What a rehearsal measured, as plain lists, and the figures made of one or many of them.

Lists, not summaries: those of many seeds are joined before any median is taken.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from pft_exec.description import TaskDescription, load_task
from pft_exec.evaluation.figures import Figure, share, worst
from pft_exec.evaluation.rehearsal import OTHER, TASK, Rehearsal, Run
from pft_exec.execution.log import ExecutionLog, Stage
from pft_exec.learning import MotionLibrary
from pft_exec.model import JointLimits, load_robot

Measurements = dict[str, list[float]]
"""A list of numbers by name; names of runs begin with the arm."""

PLACED = ("reach", "put_on_table")
"""Motions that end at an object of the scene."""
ARMS = ("right", "left")


def measure(rehearsal: Rehearsal) -> Measurements:
    """All numbers of a rehearsal that figures are made of."""
    measured: Measurements = {
        "guiding_rms": [item.rms_error for item in rehearsal.guidance],
        "guiding_force": [item.peak_force for item in rehearsal.guidance],
        "guiding_swivel": [item.swivel_drift for item in rehearsal.guidance],
        "variables_right": relations_right(rehearsal.library, load_task(TASK)),
        "refused": [float(bool(rehearsal.refusal))],
    }
    robot = load_robot("pr2")
    for run in rehearsal.runs:
        for name, values in _measure_run(run, robot.arm(run.arm).limits).items():
            measured.setdefault(f"{run.arm}_{name}", []).extend(values)
    return measured


def relations_right(library: MotionLibrary, task: TaskDescription) -> list[float]:
    """1 for each motion whose motion variables are exactly the task's relations, none of them ambiguous; else 0."""
    return [float(found_relations(library, label) == task.relations(label)) for label in library.labels]


def found_relations(library: MotionLibrary, label: str) -> dict[str, str]:
    """Learned relations in the words of a task: ``{"end.position": "bottle", ...}``; "ambiguous" where undecided."""
    variables = library[label].variables
    found = {}
    for when in ("start", "end"):
        end = getattr(variables, when)
        for what in ("position", "orientation"):
            decision = getattr(end, what)
            word = "none" if decision is None or not decision.frame else decision.frame
            found[f"{when}.{what}"] = "ambiguous" if decision is not None and decision.ambiguous else word
    return found


def _measure_run(run: Run, limits: JointLimits) -> Measurements:
    log, details = run.log, run.log.details
    taken = bool(log.label)
    measured: Measurements = {
        "recognized": [float(log.label == run.truth)],
        "wrong": [float(taken and log.label != run.truth and details["asked"] == 0.0)],
        "asked": [float(details["asked"] > 0.0)],
        "success": [float(log.success)],
        "torque_beyond": [float(np.max(np.abs(log.torque) - limits.torque))],
        "real_time_factor": [details.get("real_time_factor", float("nan"))],
        "under_hand_beyond": [beyond(log, limits, guided=True)[0]],
        "under_hand_time": [longest_beyond(log, limits)],
    }
    if Stage.TRANSITION in log.stage:
        by_controller = beyond(log, limits, guided=False)
        measured |= {
            "take_over_share": [details["take_over_share"]],
            "position_beyond": [by_controller[0]],
            "velocity_beyond": [by_controller[1]],
            "tick": [float(tick) for tick in log.tick[log.stage >= Stage.TRANSITION]],
            "join_time": [details["join_time"]],
        }
        for quantity in ("position", "velocity", "acceleration"):
            measured[f"seam_{quantity}"] = [details[f"seam_{seam}_{quantity}"] for seam in (1, 2)]
        if run.truth in PLACED and log.label == run.truth:
            measured["end_position"] = [details["end_position_error"]]
            measured["end_rotation"] = [details["end_rotation_error"]]
            measured["tube_goal"] = [details["tube_goal_error"]]
    return measured


def beyond(log: ExecutionLog, limits: JointLimits, *, guided: bool) -> tuple[float, float]:
    """How far position (rad) and velocity (rad/s) were beyond the limits, under the hand or under the controller."""
    rows = (log.stage == Stage.GUIDED) if guided else (log.stage >= Stage.TRANSITION)
    q, v = log.configuration[rows], log.velocity[rows]
    outside = np.maximum(q - limits.upper, limits.lower - q)
    return float(np.max(outside)), float(np.max(np.abs(v) - limits.velocity))


def longest_beyond(log: ExecutionLog, limits: JointLimits) -> float:
    """Longest time, s, that a joint stayed beyond its position limits without a break."""
    outside = np.any((log.configuration > limits.upper) | (log.configuration < limits.lower), axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], outside.astype(int), [0]])))
    spans = edges[1::2] - edges[::2]
    period = float(log.time[1] - log.time[0]) if len(log) > 1 else 0.0
    return float(np.max(spans, initial=0)) * period


def joined_measurements(parts: Iterable[Mapping[str, list[float]]]) -> Measurements:
    """The measurements of several rehearsals as one."""
    joined: Measurements = {}
    for part in parts:
        for name, values in part.items():
            joined.setdefault(name, []).extend(values)
    return joined


def figures(measured: Measurements) -> dict[str, Figure]:
    """Every figure that the demo is held to."""
    found = {
        "hand guiding: rms distance to the hand": Figure(1e3 * worst(measured["guiding_rms"]), 10.0, "mm"),
        "hand guiding: peak force": Figure(worst(measured["guiding_force"]), 15.0, "N"),
        "hand guiding: elbow swivel drift": Figure(worst(measured["guiding_swivel"]), 0.1, "rad"),
        "motion variables exactly right": Figure(share(_hits(measured["variables_right"])), 100.0, "%", "at least"),
        f"out-of-reach placement refused ({OTHER})": Figure(share(_hits(measured["refused"])), 100.0, "%", "at least"),
    }
    for arm in ARMS:
        found |= {f"{arm}: {name}": figure for name, figure in _arm_figures(measured, f"{arm}_").items()}
    return found


def _arm_figures(measured: Measurements, prefix: str) -> dict[str, Figure]:
    def of(name: str) -> list[float]:
        return measured.get(prefix + name, [])

    ticks = np.array(of("tick")) if of("tick") else np.array([np.nan])
    acceleration = worst(of("seam_acceleration"))
    return {
        "recognized by the take-over": Figure(share(_hits(of("recognized"))), 95.0, "%", "at least"),
        "share of the motion at the take-over, mean": Figure(100.0 * _mean(of("take_over_share")), 60.0, "%"),
        "wrong motion taken over unasked": Figure(share(_hits(of("wrong"))), 0.0, "%"),
        "asked": Figure(share(_hits(of("asked"))), 10.0, "%"),
        "motions finished as the task asks": Figure(share(_hits(of("success"))), 95.0, "%", "at least"),
        "seam: jump of position": Figure(worst(of("seam_position")), 1e-6, "rad"),
        "seam: jump of velocity": Figure(worst(of("seam_velocity")), 1e-6, "rad/s"),
        "seam: jump of acceleration": Figure(acceleration, seam_acceleration_floor(prefix[:-1]), "rad/s^2"),
        "torque beyond its limit": Figure(worst(of("torque_beyond")), 1e-9, "N m"),
        "position beyond its limit, by the controller": Figure(worst(of("position_beyond")), 0.0, "rad"),
        "velocity beyond its limit, by the controller": Figure(worst(of("velocity_beyond")), 0.0, "rad/s"),
        "position beyond its limit, under the hand": Figure(worst(of("under_hand_beyond")), 0.01, "rad"),
        "time beyond a limit, under the hand": Figure(worst(of("under_hand_time")), 0.2, "s"),
        "end of reach and put_on_table: tracking": Figure(1e3 * worst(of("end_position")), 5.0, "mm"),
        "end of reach and put_on_table: turning": Figure(np.rad2deg(worst(of("end_rotation"))), 2.0, "deg"),
        "tube's end to the task's goal, median": Figure(1e3 * _median(of("tube_goal")), 8.0, "mm"),
        "control tick, median": Figure(1e6 * float(np.median(ticks)), 300.0, "us"),
        "control tick, p99": Figure(1e6 * float(np.percentile(ticks, 99)), 800.0, "us"),
        "simulated time per computing time, median": Figure(
            _median(of("real_time_factor")), 1.0, "x real time", "at least"
        ),
    }


def seam_acceleration_floor(arm: str, control_period: float = 1e-3) -> float:
    """Smallest jerk limit of an arm times the control period, rad/s^2."""
    return float(np.min(load_robot("pr2").arm(arm).limits.jerk) * control_period)


def _hits(values: list[float]) -> list[bool]:
    return [value > 0.5 for value in values]


def _mean(values: list[float]) -> float:
    return float(np.mean(values)) if values else float("nan")


def _median(values: list[float]) -> float:
    clean = [value for value in values if np.isfinite(value)]
    return float(np.median(clean)) if clean else float("nan")
