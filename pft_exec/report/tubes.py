"""Flow tubes with their demonstrations: in space, and each axis over time."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import mpl_toolkits.mplot3d  # noqa: F401 - registers the projection "3d"
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.geometry import Array
from pft_exec.learning import FlowTube
from pft_exec.report.style import AXES, MARK, MUTED, color_of, frame_in_space, picture
from pft_exec.report.timing import band_over_time

SIGMAS = 2.0  # half width of a drawn tube, standard deviations
_RING = 25  # points of a cross-section
_SECTIONS = 120  # cross-sections of a drawn tube
_NEAR = 0.5  # of a path's extent; an object farther from it would shrink the picture
_TIMED, _AT_PLACE = 0.13, 0.28  # opacity of the bands over time
_OPACITY = 0.3  # of a tube that covers itself nowhere


def _section_steps(path: Array, sections: int) -> NDArray[np.int64]:
    """Steps of a path (N, 3) at even distances along it: where the tool rests its direction is noise."""
    passed = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    steps: NDArray[np.int64] = np.unique(np.searchsorted(passed, np.linspace(0.0, passed[-1], sections)))
    return steps if len(steps) > 1 else np.array([0, len(path) - 1])


def tube_surface(flow_tube: FlowTube, sigmas: float = SIGMAS, sections: int = _SECTIONS) -> Array:
    """Cross-sections (S, R, 3), m, of a tube: ellipses of the covariance normal to the path, without twist."""
    index = _section_steps(flow_tube.position, sections)
    center, covariance = flow_tube.position[index], flow_tube.covariance[index, :3, :3]
    angle = np.linspace(0.0, 2.0 * np.pi, _RING)
    circle = sigmas * np.stack([np.cos(angle), np.sin(angle)])
    rings = []
    for place, plane in enumerate(_normal_planes(center)):
        root: Array = np.linalg.cholesky(plane.T @ covariance[place] @ plane)
        rings.append(center[place] + (plane @ root @ circle).T)
    return np.array(rings)


def _normal_planes(path: Array) -> list[Array]:
    """Bases (3, 2) of the planes normal to a path, each turned as little as possible from the one before."""
    tangents: Array = np.gradient(path, axis=0)
    plane = np.eye(3)[:, :2]
    planes = []
    for tangent in tangents:
        length = float(np.linalg.norm(tangent))
        if length > 1e-12:
            direction = tangent / length
            flattened = plane - np.outer(direction, direction @ plane)
            left, values, right = np.linalg.svd(flattened, full_matrices=False)
            if values[-1] < 1e-6:  # the old plane stands on the new direction
                complete, _, _ = np.linalg.svd(direction[:, None])
                left, right = complete[:, 1:], np.eye(2)
            plane = left @ right
        planes.append(plane)
    return planes


def plot_tubes(
    tubes: Mapping[str, FlowTube],
    demonstrations: Iterable[Demonstration],
    path: str | Path,
    scene: Scene | Mapping[str, Scene] | None = None,
) -> None:
    """Draw each tube of a scene with the demonstrations it came from: a row per motion, in 3-D and per axis.

    Parameters
    ----------
    tubes : {label: FlowTube}
    demonstrations : iterable of Demonstration
        Drawn where a tube does not carry its own aligned ones.
    path : str or Path
    scene : Scene, {label: Scene} or None
        Objects to mark in space, those near the path: of one scene for all tubes, or of each tube's own.

    Raises
    ------
    StorageError
        If the picture cannot be written.
    """
    taught = list(demonstrations)
    colors = color_of(tubes)
    with picture(path, 13.0, 0.5 + 3.2 * len(tubes)) as figure:
        grid = figure.add_gridspec(len(tubes), 4, width_ratios=(1.3, 1.0, 1.0, 1.0))
        for row, (label, tube) in enumerate(tubes.items()):
            lines = _demonstrated(tube, taught)
            around = scene if isinstance(scene, Scene) else (scene or {}).get(label, Scene())
            space = figure.add_subplot(grid[row, 0], projection="3d")
            points = outline(tube, lines)
            near = objects_near(points, around)
            draw_in_space(space, tube, lines, colors[label], near)
            frame_in_space(space, np.vstack([points, *near.values()]))
            space.set_title(f"{label}   (circle: start, square: end)", fontsize=9)
            for axis in range(3):
                axes = figure.add_subplot(grid[row, axis + 1])
                draw_axis(axes, tube, lines, axis, colors[label])
                axes.set_title(f"{label}: {AXES[axis]}", fontsize=9)
        figure.legend(handles=_legend(), loc="outside lower center", ncols=4)
        figure.suptitle(f"Flow tubes: mean, {SIGMAS:g} standard deviations, and the demonstrations in this scene")


def _legend() -> list[Any]:
    """What the marks mean, in no motion's color."""
    return [
        Patch(color=MARK, linewidth=0, alpha=_TIMED, label="tube and its timing"),
        Patch(color=MARK, linewidth=0, alpha=_TIMED + _AT_PLACE, label="tube"),
        Line2D([], [], color=MUTED, linewidth=0.7, label="demonstrations"),
        Line2D([], [], color=MARK, label="mean"),
    ]


def _demonstrated(tube: FlowTube, taught: Iterable[Demonstration]) -> list[tuple[Array, Array]]:
    """Times (N,), s, and positions (N, 3), m, of the demonstrations of a tube."""
    if tube.aligned is not None:
        return list(zip(tube.aligned.time, tube.aligned.position, strict=True))
    return [(item.time - item.time[0], item.position) for item in taught if item.label == tube.label]


def outline(tube: FlowTube, lines: Sequence[tuple[Array, Array]]) -> Array:
    """Points (M, 3), m, that a picture of a tube and of the paths it came from has to hold."""
    return np.vstack([tube_surface(tube).reshape(-1, 3), *(position for _, position in lines)])


def objects_near(points: Array, scene: Scene, always: Collection[str] = ()) -> dict[str, Array]:
    """Positions of objects: those near some point (M, 3), as others would shrink the picture, and those of `always`."""
    reach = _NEAR * float(np.linalg.norm(np.ptp(points, axis=0)))
    positions = {name: pose.position for name, pose in scene.objects.items()}
    return {
        name: p for name, p in positions.items() if name in always or np.linalg.norm(points - p, axis=1).min() < reach
    }


def draw_in_space(
    axes: Any, tube: FlowTube, lines: Sequence[tuple[Array, Array]], color: str, objects: Mapping[str, Array]
) -> None:
    """Draw a tube, the paths (times (N,), s, and positions (N, 3), m) it came from, and objects into 3-D axes."""
    axes.computed_zorder = False  # else a tube hides its mean, and objects
    # every face a quadrangle: matplotlib pads faces of unequal size with whatever its memory held
    look: dict[str, Any] = {"rstride": 1, "cstride": 1, "linewidth": 0, "shade": False, "zorder": 1}
    axes.plot_surface(*np.moveaxis(tube_surface(tube), 2, 0), **look, color=color, alpha=_opacity(tube.position))
    for _, position in lines:
        axes.plot(*position.T, color=MUTED, linewidth=0.6, zorder=2)
    axes.plot(*tube.position.T, color=color, linewidth=2.0, zorder=3)
    axes.scatter(*tube.position[0], color=color, marker="o", s=22, edgecolors="white", linewidths=0.6, zorder=4)
    axes.scatter(*tube.position[-1], color=color, marker="s", s=26, edgecolors="white", linewidths=0.6, zorder=4)
    for name, position in objects.items():
        axes.scatter(*position, color=MARK, marker="^", s=26, zorder=5)
        axes.text(*position, f"  {name}", fontsize=8, color=MARK, zorder=6)


def _opacity(path: Array) -> float:
    """Of a tube's surface: as often as its path (N, 3) goes to and fro, it lies over itself."""
    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    layers = max(0.5 * length / max(float(np.linalg.norm(np.ptp(path, axis=0))), 1e-9), 1.0)
    return float(1.0 - (1.0 - _OPACITY) ** (1.0 / layers))


def draw_axis(axes: Any, tube: FlowTube, lines: Iterable[tuple[Array, Array]], axis: int, color: str) -> None:
    """Draw one axis of a tube and of the paths it came from over time.

    Two bands: the tube at a place of the motion, and wider where it moves, what is to be expected at a time.
    """
    mean, spread = tube.position[:, axis], SIGMAS * np.sqrt(tube.covariance[:, axis, axis])
    fill: dict[str, Any] = {"color": color, "linewidth": 0}
    axes.fill_between(*band_over_time(tube, axis, SIGMAS), **fill, alpha=_TIMED, label="tube and its timing")
    axes.fill_between(tube.time, mean - spread, mean + spread, **fill, alpha=_AT_PLACE, label="tube")
    for place, (time, position) in enumerate(lines):
        axes.plot(time, position[:, axis], color=MUTED, linewidth=0.7, label=None if place else "demonstrations")
    axes.plot(tube.time, mean, color=color, label="mean")
    axes.set(xlabel="time (s)", ylabel=f"{AXES[axis]} (m)")
