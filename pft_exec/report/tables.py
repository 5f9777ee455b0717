"""Rows of the tables that the command line prints: plain mappings, a column per key."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.execution.log import ExecutionLog
from pft_exec.learning import FrameDecision, MotionLibrary
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
    """A row per decision about a motion variable, with the numbers that decided it; mm and degrees."""
    return [_decision_row(*entry) for entry in _decisions(library)]


def _decisions(library: MotionLibrary) -> Iterator[tuple[str, str, str, FrameDecision]]:
    for label in library.labels:
        variables = library[label].variables
        for end, decision in (("start", variables.start), ("end", variables.end)):
            yield label, end, "position", decision.position
            if decision.orientation is not None:
                yield label, end, "orientation", decision.orientation


def _decision_row(label: str, end: str, channel: str, decision: FrameDecision) -> Row:
    scale, unit = (1000.0, "mm") if channel == "position" else (180.0 / np.pi, "deg")
    rivals = sorted((spread, name) for name, spread in decision.candidates.items() if name != decision.frame)
    return {
        "motion": label,
        "end": end,
        "of": channel,
        "relevant": decision.frame or "-",
        "spread": f"{scale * decision.spread:.1f} {unit}",
        "next": ", ".join(f"{name} {scale * spread:.1f} {unit}" for spread, name in rivals[:2]),
        "p": float(decision.p_value),
        "ambiguous": decision.ambiguous,
    }


def recognition_rows(results: Iterable[StreamRecognition]) -> list[Row]:
    """A row per recording: what it was taken for, how surely, and from when on."""
    return [
        {
            "recording": place,
            "motion": item.truth,
            "recognized as": item.label,
            "right": item.is_right,
            "probability": item.probability,
            "unknown": item.unknown,
            "decided (s)": item.decision_time,
            "decided (%)": 100.0 * item.decision_share,
            "time right (%)": 100.0 * item.share_right,
        }
        for place, item in enumerate(results)
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
}


def log_rows(log: ExecutionLog) -> list[Row]:
    """The same, a row each."""
    summary = log_summary(log)
    details, events = summary.pop("details"), summary.pop("events")
    rows = [{"what": name.replace("_", " "), "value": v, "unit": _UNITS.get(name, "")} for name, v in summary.items()]
    rows += [{"what": name.replace("_", " "), "value": value, "unit": ""} for name, value in details.items()]
    return rows + [
        {"what": event["name"], "value": event["detail"], "unit": f"at {event['time']:.2f} s"} for event in events
    ]
