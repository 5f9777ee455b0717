"""Demonstrations as they were recorded, each in its own scene."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mpl_toolkits.mplot3d  # noqa: F401 - registers the projection "3d"
import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array
from pft_exec.report.style import MARK, color_of, frame_in_space, picture
from pft_exec.report.tubes import objects_near

_COLUMNS = 4


def plot_demonstrations(demonstrations: Sequence[Demonstration], path: str | Path) -> None:
    """Draw the tool paths of each motion in space, with the objects of every scene that stand near.

    Raises
    ------
    StorageError
        If the picture cannot be written.
    """
    labels = list(dict.fromkeys(item.label for item in demonstrations))
    colors = color_of(labels)
    columns = min(_COLUMNS, max(len(labels), 1))
    rows = -(-len(labels) // columns) or 1
    with picture(path, 3.8 * columns, 0.6 + 3.4 * rows) as figure:
        for place, label in enumerate(labels):
            axes = figure.add_subplot(rows, columns, place + 1, projection="3d")
            _draw_motion(axes, [item for item in demonstrations if item.label == label], colors[label])
        figure.suptitle("Demonstrations (circle: start, square: end, triangle: object at the start, where near)")


def _draw_motion(axes: Any, group: Sequence[Demonstration], color: str) -> None:
    """Paths of one motion, and objects near them; each object is named once."""
    points = np.vstack([item.position for item in group])
    shown: dict[str, list[Array]] = {}
    for item in group:
        axes.plot(*item.position.T, color=color, linewidth=1.0)
        axes.scatter(*item.position[0], color=color, marker="o", s=14)
        axes.scatter(*item.position[-1], color=color, marker="s", s=14)
        for name, position in objects_near(points, item.scene).items():
            shown.setdefault(name, []).append(position)
    for name, positions in shown.items():
        axes.scatter(*np.transpose(positions), color=MARK, marker="^", s=10)
        axes.text(*positions[0], f"  {name}", fontsize=7, color=MARK)
    axes.set_title(f"{group[0].label}: {len(group)} demonstrations")
    frame_in_space(axes, np.vstack([points, *(position for each in shown.values() for position in each)]))
