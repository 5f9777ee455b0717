"""The run of an arm over time, and its seam: what was commanded and measured around the handoff."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pft_exec.execution.log import ExecutionLog, Stage
from pft_exec.geometry import Array
from pft_exec.report.control_panels import draw_constraints, draw_costs, draw_pace, draw_timing, mark_events
from pft_exec.report.style import AXES, COLORS, MARK, picture

TITLE_WIDTH = 100
"""Characters of a line above a picture."""
BEFORE, AFTER = 0.3, 0.4  # s shown before the take-over and after the tube is joined
_SHADES = {Stage.GUIDED: "#fff3d6", Stage.TRANSITION: "#dcecf8", Stage.TUBE: "#e3f3e6", Stage.HOLD: "#f0f0f0"}
_NAMES = {
    Stage.GUIDED: "hand leads",
    Stage.TRANSITION: "transition",
    Stage.TUBE: "tube",
    Stage.HOLD: "hold",
    Stage.STOPPED: "stopped",
}


def plot_seam(log: ExecutionLog, path: str | Path) -> None:
    """Draw joint position, velocity, acceleration and torque around the handoff; the whole run where there was none.

    Raises
    ------
    StorageError
        If the picture cannot be written.
    """
    with picture(path, 9.0, 9.0) as figure:
        _draw_seam(figure, log)


def plot_run(log: ExecutionLog, path: str | Path) -> None:
    """Draw a whole run: tool, torque, force, phase; what the controller weighed, and what held it back, if logged.

    Raises
    ------
    StorageError
        If the picture cannot be written.
    """
    with picture(path, 9.0, 12.0 if len(log.control) else 8.0) as figure:
        _draw_run(figure, log)


def plot_log(log: ExecutionLog, path: str | Path) -> None:
    """Draw a run: as a whole, and beside it the handoff where a hand led first; that alone in logs of version 1.

    Raises
    ------
    StorageError
        If the picture cannot be written.
    """
    has_handoff = {Stage.GUIDED, Stage.TRANSITION} <= set(log.stage.tolist())
    if not (has_handoff and len(log.control)):
        (plot_seam if has_handoff else plot_run)(log, path)
        return
    with picture(path, 18.0, 12.0) as figure:
        halves: Any = figure.subfigures(1, 2)
        _draw_run(halves[0], log)
        _draw_seam(halves[1], log)


def _draw_seam(figure: Any, log: ExecutionLog) -> None:
    rows = _around_handoff(log)
    time = log.time[rows]
    measured = log.configuration[rows]
    origin = log.reference_position[rows][0]
    panels: list[tuple[str, Array, Array | None]] = [
        ("position from\nfirst shown (rad)", log.reference_position[rows] - origin, measured - origin),
        ("velocity (rad/s)", log.reference_velocity[rows], log.velocity[rows]),
        ("acceleration (rad/s²)", log.reference_acceleration[rows], None),
        ("motor torque (N m)", log.torque[rows], None),
    ]
    axes = figure.subplots(len(panels), 1, sharex=True)
    for panel, (name, commanded, seen) in zip(axes, panels, strict=True):
        _shade_stages(panel, time, log.stage[rows], named=panel is axes[0])
        _draw_joints(panel, time, commanded, seen)
        panel.set_ylabel(name)
    axes[-1].set_xlabel("time (s)")
    _joint_legend(axes[1], log.configuration.shape[1])
    title = f"Handoff of {log.label!r}, {log.arm} arm: commanded (solid) and measured (dotted)"
    figure.align_ylabels(axes)
    figure.suptitle(fill(title, TITLE_WIDTH), fontsize=9)


def _draw_run(figure: Any, log: ExecutionLog) -> None:
    axes = figure.subplots(7 if len(log.control) else 4, 1, sharex=True)
    for panel in axes:
        _shade_stages(panel, log.time, log.stage, named=panel is axes[0])
    _draw_motion(axes, log)
    draw_pace(axes[3], log)
    if len(log.control):
        draw_costs(axes[4], log)
        draw_constraints(axes[5], log)
        draw_timing(axes[6], log)
    mark_events(axes, log)
    axes[-1].set_xlabel("time (s)")
    figure.align_ylabels(axes)
    figure.suptitle(fill(f"{log.label}, {log.arm} arm: {log.reason}", TITLE_WIDTH), fontsize=9)


def _draw_motion(axes: Any, log: ExecutionLog) -> None:
    """Tool, torque and force in the first three panels."""
    for axis, name in enumerate(AXES):
        axes[0].plot(log.time, log.position[:, axis], color=COLORS[axis], label=name)
    axes[0].legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    _draw_joints(axes[1], log.time, log.torque, None)
    _joint_legend(axes[1], log.torque.shape[1])
    axes[2].plot(log.time, log.hand_force, color=MARK, linewidth=1.0)
    names = ("tool position,\nworld (m)", "motor torque (N m)", "force at the\ntool (N)")
    for panel, name in zip(axes[:3], names, strict=True):
        panel.set_ylabel(name)


def _around_handoff(log: ExecutionLog) -> slice:
    """Rows from shortly before the transition to shortly after it; all rows where there is none."""
    moving = np.flatnonzero(log.stage == Stage.TRANSITION)
    if not moving.size:
        return slice(0, len(log.time))
    first, last = np.searchsorted(log.time, (log.time[moving[0]] - BEFORE, log.time[moving[-1]] + AFTER))
    return slice(int(first), int(last))


def _draw_joints(axes: Any, time: Array, commanded: Array, measured: Array | None) -> None:
    for joint in range(commanded.shape[1]):
        color = COLORS[joint % len(COLORS)]
        axes.plot(time, commanded[:, joint], color=color, linewidth=1.3)
        if measured is not None:
            axes.plot(time, measured[:, joint], color=color, linewidth=1.0, linestyle=":")


def _joint_legend(axes: Any, count: int) -> None:
    handles = [axes.plot([], [], color=COLORS[joint % len(COLORS)])[0] for joint in range(count)]
    axes.legend(
        handles, [f"joint {joint + 1}" for joint in range(count)], loc="center left", bbox_to_anchor=(1.01, 0.5)
    )


def _shade_stages(axes: Any, time: Array, stage: NDArray[np.int64], named: bool) -> None:
    """A tinted span, with its name above, for each stretch of the same stage."""
    edges = np.flatnonzero(np.diff(stage)) + 1
    starts, stops = np.concatenate([[0], edges]), np.concatenate([edges, [len(stage) - 1]])
    for start, stop in zip(starts, stops, strict=True):
        kind = Stage(int(stage[start]))
        axes.axvspan(time[start], time[stop], color=_SHADES.get(kind, "#f8dcdc"), linewidth=0)
        if start:
            axes.axvline(time[start], color=MARK, linewidth=0.8, linestyle="--")
        if named:
            middle = 0.5 * (time[start] + time[stop])
            axes.text(middle, 1.02, _NAMES[kind], transform=axes.get_xaxis_transform(), ha="center", fontsize=8)
    axes.set_xlim(time[0], time[-1])
