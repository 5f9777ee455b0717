"""A sheet of one motion: what was taught, and what each method learned from it, in space and per axis."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.geometry import Array
from pft_exec.learning import FlowTube
from pft_exec.report.style import AXES, COLORS, MARK, frame_in_space, picture
from pft_exec.report.tubes import SIGMAS, draw_axis, draw_in_space, objects_near, outline


def plot_motion(
    demonstrations: Sequence[Demonstration],
    tubes: Mapping[str, FlowTube],
    path: str | Path,
    shown: Demonstration | None = None,
    objects: Collection[str] = (),
) -> None:
    """Draw a motion on one sheet.

    Above, in space: the demonstrations as they were recorded, then the tube of each method in a new scene, all on one
    scale. Below, each axis over time: the first method's tube, the means of the others, and what a person did there.

    Parameters
    ----------
    demonstrations : sequence of Demonstration
        Taught.
    tubes : {method: FlowTube}
        At least one, all of one scene.
    path : str or Path
    shown : Demonstration or None
        The same motion as a person made it in the tubes' scene; it was not learned from.
    objects : names
        Of that scene, to be in the picture however far they are; others are where they are near.

    Raises
    ------
    StorageError
        If the picture cannot be written.
    """
    scene = Scene() if shown is None else shown.scene
    with picture(path, 4.3 * (1 + len(tubes)), 7.2) as figure:
        figure.set_layout_engine("constrained", w_pad=0.12)
        parts: Any = figure.subfigures(2, 1, height_ratios=(1.25, 1.0))
        above, below = parts
        axes = [above.add_subplot(1, 1 + len(tubes), 1 + place, projection="3d") for place in range(1 + len(tubes))]
        _draw_taught(axes[0], demonstrations)
        _draw_learned(axes[1:], tubes, scene, objects)
        for axis, panel in enumerate(below.subplots(1, 3)):
            _draw_time(panel, tubes, shown, axis)
        handles, names = panel.get_legend_handles_labels()
        below.legend(handles, names, loc="outside lower center", ncols=len(names))


def _draw_learned(axes: Sequence[Any], tubes: Mapping[str, FlowTube], scene: Scene, objects: Collection[str]) -> None:
    points = np.vstack([outline(tube, _carried(tube)) for tube in tubes.values()])
    near = objects_near(points, scene, objects)
    for place, (method, tube) in enumerate(tubes.items()):
        draw_in_space(axes[place], tube, _carried(tube), COLORS[place], near)
        frame_in_space(axes[place], np.vstack([points, *near.values()]))
        axes[place].set_title(f"learned, {method}: new scene, {SIGMAS:g} sigma", fontsize=9)


def _draw_taught(axes: Any, demonstrations: Sequence[Demonstration]) -> None:
    for place, item in enumerate(demonstrations):
        color = COLORS[place % len(COLORS)]
        axes.plot(*item.position.T, color=color, linewidth=1.0)
        axes.scatter(*item.position[0], color=color, marker="o", s=14)
        axes.scatter(*item.position[-1], color=color, marker="s", s=16)
    title = f"{demonstrations[0].label}: {len(demonstrations)} demonstrations (circle: start, square: end)"
    axes.set_title(title, fontsize=9)
    frame_in_space(axes, np.vstack([item.position for item in demonstrations]))


def _draw_time(axes: Any, tubes: Mapping[str, FlowTube], shown: Demonstration | None, axis: int) -> None:
    for place, (method, tube) in enumerate(tubes.items()):
        if place == 0:
            draw_axis(axes, tube, _carried(tube), axis, COLORS[0])
            axes.lines[-1].set_label(f"mean, {method}")
        else:
            axes.plot(tube.time, tube.position[:, axis], color=COLORS[place], linestyle="--", label=f"mean, {method}")
    if shown is not None:
        time = shown.time - shown.time[0]
        axes.plot(time, shown.position[:, axis], color=MARK, linestyle=":", label="a person in this scene")
    axes.set_title(f"{AXES[axis]}, new scene", fontsize=9)


def _carried(tube: FlowTube) -> list[tuple[Array, Array]]:
    """Times (N,), s, and positions (N, 3), m, of the demonstrations as carried into the tube's scene."""
    if tube.aligned is None:
        return []
    return list(zip(tube.aligned.time, tube.aligned.position, strict=True))
