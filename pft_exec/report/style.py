"""One look for every picture: fonts, colors and the way a figure is made and saved.

Figures are made without pyplot: no window, no state, and any number of them in one process.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from pft_exec.exceptions import StorageError
from pft_exec.geometry import Array

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7A5C3E", "#666666")
"""Palette of Okabe and Ito, readable by color-blind people, with brown and gray in place of yellow and black."""
MUTED = "#8a8a8a"
MARK = "#222222"
AXES = ("x", "y", "z")

_STYLE: Any = {
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.labelsize": 9.0,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "lines.linewidth": 1.6,
    "figure.facecolor": "white",
    "savefig.dpi": 130,
}


def color_of(labels: Iterable[str]) -> dict[str, str]:
    """A color for each label, the same in every picture of the same set."""
    return {label: COLORS[place % len(COLORS)] for place, label in enumerate(sorted(set(labels)))}


def line_of(labels: Iterable[str]) -> dict[str, dict[str, str]]:
    """Color and line style of each label: solid lines in all colors of the palette, then dashed, then dotted ones."""
    names, styles = sorted(set(labels)), ("-", "--", "-.")
    return {
        name: {"color": COLORS[place % len(COLORS)], "linestyle": styles[place // len(COLORS) % len(styles)]}
        for place, name in enumerate(names)
    }


def frame_in_space(axes: Any, points: Array) -> None:
    """Label 3-D axes and fit them as a cube, one scale on all three, around points (M, 3), m."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), 0.53 * max(float((high - low).max()), 1e-3)
    axes.set(
        xlim=(middle[0] - half, middle[0] + half),
        ylim=(middle[1] - half, middle[1] + half),
        zlim=(middle[2] - half, middle[2] + half),
    )
    axes.set_box_aspect((1.0, 1.0, 1.0), zoom=1.0)
    for name in AXES:
        getattr(axes, f"set_{name}label")(f"{name} (m)", labelpad=-1, fontsize=8)
        getattr(axes, f"{name}axis").set_major_locator(MaxNLocator(4))
    axes.zaxis.set_rotate_label(False)  # else it stands on its head
    axes.zaxis.label.set_rotation(90.0)
    axes.tick_params(labelsize=7, pad=-2)
    axes.view_init(elev=24.0, azim=-128.0)  # from behind the robot's right shoulder: x away, y to the left


@contextmanager
def picture(path: str | Path, width: float, height: float) -> Iterator[Figure]:
    """A figure, inches, that is written to `path` when the block ends without an error.

    Raises
    ------
    StorageError
        If the folder does not exist, the suffix names no kind of picture, or nothing can be written there.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise StorageError(f"cannot write {path}: the folder {path.parent} does not exist.")
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        canvas = FigureCanvasAgg(figure)
        kinds = canvas.get_supported_filetypes()
        if path.suffix.lstrip(".").lower() not in kinds:
            raise StorageError(f"cannot write {path}: a picture ends in .png, .pdf or .svg; got {path.suffix!r}.")
        yield figure
        try:
            figure.savefig(path)
        except OSError as error:
            raise StorageError(f"cannot write {path}: {error}.") from error
