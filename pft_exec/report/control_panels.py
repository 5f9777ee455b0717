"""Panels of a run that say what the controller did: costs, what held it back, the clock's rate, timing, events."""

from __future__ import annotations

from typing import Any

import numpy as np

from pft_exec.execution.log import Event, ExecutionLog
from pft_exec.geometry import Array
from pft_exec.report.style import COLORS, MARK, MUTED

QUIET_EVENTS = ("joined",)
"""Events that the stages show already."""
_LEAST_COST = 1e-9


def draw_costs(axes: Any, log: ExecutionLog) -> None:
    """What each objective of the quadratic program costs, on a logarithmic scale."""
    for color, (name, cost) in zip(COLORS, log.control.costs.items(), strict=False):
        axes.plot(log.time, np.maximum(cost, _LEAST_COST), color=color, linewidth=1.0, label=name)
    axes.set_yscale("log")
    axes.set_ylabel("cost")
    if log.control.costs:
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))


def draw_constraints(axes: Any, log: ExecutionLog) -> None:
    """When a torque limit, a bound, a distance or a fallback held the motion back: a line each that ever did."""
    history = log.control
    rows: list[tuple[str, Any]] = [("fallback", history.fallback)]
    rows += [(f"torque {joint + 1}", active) for joint, active in enumerate(history.torque_active.T)]
    rows += [(f"bound {joint + 1}", active) for joint, active in enumerate(history.bound_active.T)]
    rows += list(history.apart.items())
    shown = [(name, active) for name, active in rows if active.any()]
    for place, (_, active) in enumerate(shown):
        times = log.time[active]
        axes.plot(times, np.full(len(times), place), "|", color=COLORS[place % len(COLORS)], markersize=5)
    axes.set_yticks(range(len(shown)), [name for name, _ in shown], fontsize=6)
    axes.set_ylim(-0.7, max(len(shown), 1) - 0.3)
    axes.set_ylabel("held back by")
    if not shown:
        axes.text(0.5, 0.5, "nothing", transform=axes.transAxes, ha="center", va="center", color=MUTED)


def draw_pace(axes: Any, log: ExecutionLog) -> None:
    """Phase along the tube, and the rate of its clock."""
    axes.plot(log.time, log.phase, color=MARK, label="phase")
    if len(log.control):
        axes.plot(log.time, log.control.rate, color=COLORS[1], linewidth=1.0, label="rate")
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    axes.set_ylabel("phase along\nthe tube")


def draw_timing(axes: Any, log: ExecutionLog) -> None:
    """Computing time of each control period, and of the solver in it."""
    axes.plot(log.time, _microseconds(log.tick), color=MUTED, linewidth=0.6, label="period")
    axes.plot(log.time, _microseconds(log.control.solve_time), color=COLORS[0], linewidth=0.6, label="solver")
    axes.set_yscale("log")
    axes.set_ylabel("computing\ntime (µs)")
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))


def _microseconds(seconds: Array) -> Array:
    """Of what took any time; NaN elsewhere."""
    micro: Array = np.where(seconds > 0.0, 1e6 * seconds, np.nan)
    return micro


def mark_events(panels: Any, log: ExecutionLog) -> None:
    """A line at each event through all panels, named at the foot of one."""
    shown = [event for event in log.events if event.name not in QUIET_EVENTS]
    for place, event in enumerate(shown):
        for axes in panels:
            axes.axvline(event.time, color=COLORS[1], linewidth=0.6, alpha=0.7)
        named = panels[place % len(panels)]  # neighbors stand in different panels
        named.text(
            event.time,
            0.03,
            f" {_title(event)}",
            transform=named.get_xaxis_transform(),
            fontsize=7,
            color=COLORS[1],
            bbox={"facecolor": "white", "alpha": 0.6, "linewidth": 0.0, "pad": 0.5},
        )


def _title(event: Event) -> str:
    """What an event is called in a picture; a fault by its kind."""
    return event.detail.split(":")[0] if event.name == "fault" else event.name.replace("_", " ")
