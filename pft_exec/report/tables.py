"""Rows of the tables that the command line prints: plain mappings, a column per key."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.execution.log import ExecutionLog
from pft_exec.learning import MotionLibrary
from pft_exec.report.stream import StreamRecognition

Row = dict[str, Any]


def demonstration_rows(demonstrations: Iterable[Demonstration]) -> list[Row]:
    """A row per label: how many, how long, how far, what was recorded."""
    groups: dict[str, list[Demonstration]] = {}
    for item in demonstrations:
        groups.setdefault(item.label, []).append(item)
    return [_group_row(label, group) for label, group in groups.items()]


def _group_row(label: str, group: Sequence[Demonstration]) -> Row:
    lengths = [np.linalg.norm(np.diff(item.position, axis=0), axis=1).sum() for item in group]
    names = sorted({name for item in group for name in item.objects})
    return {
        "motion": label,
        "count": len(group),
        "samples": int(np.median([len(item) for item in group])),
        "duration (s)": float(np.median([item.duration for item in group])),
        "path (m)": float(np.median(lengths)),
        "orientation": all(item.quaternion is not None for item in group),
        "objects": ", ".join(names),
    }


def decision_rows(library: MotionLibrary) -> list[Row]:
    """A row per decision about a motion variable, in words, with the numbers that decided it."""
    return [
        {"motion": label, "decision": line.removeprefix(f"`{label}` ")}
        for label in library.labels
        for line in library[label].describe().splitlines()
    ]


def recognition_rows(results: Iterable[StreamRecognition]) -> list[Row]:
    """A row per recording: what it was taken for, how surely, from when on, and how long the right label led."""
    return [
        {
            "motion": item.truth,
            "recognized as": item.label,
            "right": item.is_right,
            "probability": item.probability,
            "unknown": item.unknown,
            "decided (s)": item.decision_time,
            "decided (%)": 100.0 * item.decision_share,
            "led (%)": 100.0 * item.share_right,
        }
        for item in results
    ]


def log_summary(log: ExecutionLog) -> Row:
    """Figures of a run by name, its own `details` among them, and its events."""
    return {
        "robot": log.robot,
        "task": log.task,
        "arm": log.arm,
        "motion": log.label,
        "success": bool(log.success),
        "reason": log.reason,
        "duration": float(np.ptp(log.time)) if len(log) else 0.0,
        "control_periods": len(log),
        "largest_torque": float(np.abs(log.torque).max(initial=0.0)),
        "largest_force_at_tool": float(log.hand_force.max(initial=0.0)),
        "median_tick": float(np.median(log.tick)) if log.tick.size else None,
        "details": {name: float(value) for name, value in log.details.items()},
        "events": [{"time": event.time, "name": event.name, "detail": event.detail} for event in log.events],
    }


_UNITS = {
    "duration": "s",
    "largest_torque": "N m",
    "largest_force_at_tool": "N",
    "median_tick": "s",
    "end_position_error": "m",
    "end_rotation_error": "rad",
    "tube_goal_error": "m",
    "tube_goal_rotation": "rad",
    "slip": "m",
    "join_time": "s",
    "take_over_time": "s",
    **{f"seam_{seam}_position": "rad" for seam in "12"},
    **{f"seam_{seam}_velocity": "rad/s" for seam in "12"},
    **{f"seam_{seam}_acceleration": "rad/s^2" for seam in "12"},
}


def log_rows(log: ExecutionLog) -> list[Row]:
    """The same, a row each."""
    summary = log_summary(log)
    details, events = summary.pop("details"), summary.pop("events")
    named = [*summary.items(), *details.items()]
    rows = [{"what": name.replace("_", " "), "value": v, "unit": _UNITS.get(name, "")} for name, v in named]
    return rows + [
        {"what": event["name"], "value": event["detail"], "unit": f"at {event['time']:.2f} s"} for event in events
    ]


def cell_text(value: Any) -> str:
    """A value of a row as words: yes and no, four digits, nothing for None."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else "" if value is None else str(value)
