"""Demonstrations as they were recorded, each in its own scene."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import mpl_toolkits.mplot3d  # noqa: F401 - registers the projection "3d"
import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.report.style import MARK, color_of, frame_in_space, picture

_COLUMNS = 4


def plot_demonstrations(demonstrations: Sequence[Demonstration], path: str | Path) -> None:
    """Draw the tool paths of each motion in space, with the objects of every scene.

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
            group = [item for item in demonstrations if item.label == label]
            points = [item.position for item in group]
            for item in group:
                axes.plot(*item.position.T, color=colors[label], linewidth=1.0)
                axes.scatter(*item.position[0], color=colors[label], s=14)
                for pose in item.scene.objects.values():
                    axes.scatter(*pose.position, color=MARK, marker="^", s=10)
                    points.append(pose.position[None])
            axes.set_title(f"{label}: {len(group)} demonstrations")
            frame_in_space(axes, np.vstack(points))
        figure.suptitle("Demonstrations (circle: start; triangle: object at the start)")
