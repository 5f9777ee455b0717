"""Belief over time: one run with the moment of take-over, or many recordings by motion."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pft_exec.execution.log import BeliefHistory
from pft_exec.report.stream import StreamRecognition
from pft_exec.report.style import MARK, MUTED, color_of, line_of, picture

_COLUMNS = 3
_SINGLE = 6  # recordings that get a panel each; more are drawn by motion
_WRONG = "#C00000"


def plot_belief(
    history: BeliefHistory, path: str | Path, take_over: float | None = None, truth: str | None = None
) -> None:
    """Draw the posterior over the motions while one was under way.

    Parameters
    ----------
    history : BeliefHistory
    path : str or Path
    take_over : float or None, s
        When the robot took over.
    truth : str or None
        The motion that was under way; drawn thicker.

    Raises
    ------
    StorageError
        If the picture cannot be written.
    """
    with picture(path, 7.5, 3.6) as figure:
        axes = figure.add_subplot()
        _draw_history(axes, history, truth)
        if take_over is not None:
            axes.axvline(take_over, color=MARK, linewidth=1.2, linestyle="--")
            axes.annotate(
                f"take-over {take_over:.2f} s",
                (take_over, 0.5),
                xytext=(5, 0),
                textcoords="offset points",
                rotation=90,
                va="center",
                fontsize=8,
            )
        axes.set_title("Belief while the hand leads" + (f": {truth}" if truth else ""))
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))


def plot_beliefs(results: Sequence[StreamRecognition], path: str | Path) -> None:
    """Draw the recognition of recordings: a panel each for a few, else the right motion's probability by motion.

    Raises
    ------
    StorageError
        If the picture cannot be written.
    """
    if len(results) <= _SINGLE:
        panels: dict[str, list[StreamRecognition]] = {
            f"{place + 1}: {item.truth}": [item] for place, item in enumerate(results)
        }
    else:
        panels = {item.truth: [r for r in results if r.truth == item.truth] for item in results}
    columns = min(_COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    with picture(path, 4.0 * columns + 1.2, 0.6 + 2.4 * rows) as figure:
        for place, (title, group) in enumerate(panels.items()):
            axes = figure.add_subplot(rows, columns, place + 1)
            if len(results) <= _SINGLE:
                _draw_history(axes, group[0].history, group[0].truth)
            else:
                _draw_group(axes, group)
            axes.set_title(title)
        handles, names = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside right upper")
        figure.suptitle("Belief over time" if len(results) <= _SINGLE else "Probability of the right motion")


def _draw_history(axes: Any, history: BeliefHistory, truth: str | None) -> None:
    looks = line_of(history.labels)
    for column, label in enumerate(history.labels):
        width = 2.4 if label == truth else 1.3
        axes.plot(history.time, history.probability[:, column], **looks[label], linewidth=width, label=label)
    axes.plot(history.time, history.unknown, color=MUTED, linestyle=":", label="unknown")
    axes.set(xlabel="time (s)", ylabel="probability", ylim=(-0.03, 1.03))


def _draw_group(axes: Any, group: Sequence[StreamRecognition]) -> None:
    """The right label's probability over the share of the motion; recordings that ended wrong in red."""
    share = np.linspace(0.0, 100.0, 101)
    curves = []
    for item in group:
        elapsed = item.history.time - item.history.time[0]
        curve = np.interp(share, 100.0 * elapsed / elapsed[-1], item.probability_of_truth)
        curves.append(curve)
        axes.plot(share, curve, color=MUTED if item.is_right else _WRONG, linewidth=0.8, alpha=0.8)
    axes.plot(share, np.mean(curves, axis=0), color=color_of(["mean"])["mean"], linewidth=2.2, label="mean")
    axes.plot([], [], color=MUTED, linewidth=0.8, label="recording")
    axes.plot([], [], color=_WRONG, linewidth=0.8, label="recording taken for\nanother at the end")
    axes.set(xlabel="share of the motion (%)", ylabel="probability", ylim=(-0.03, 1.03))
