"""Pictures of the comparisons: the paper's figures 7 and 8 with our people, and confusion matrices."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.evaluation.methods import method_named
from pft_exec.evaluation.planar import SIZE, VARYING_MOTIONS, X, draw_scene, perform, varying_trials
from pft_exec.evaluation.protocol import Summary
from pft_exec.learning import FlowTube, MotionLibrary, learn_library
from pft_exec.report.style import color_of, picture

if TYPE_CHECKING:
    from pft_exec.evaluation.tables import TableResult

LIKELIHOOD_METHODS = ("robust, phase", "dong2012", "HMM, left to right")
_TAUGHT = 30


def draw_table(result: TableResult, folder: Path) -> None:
    """Confusion matrices of all methods; for table 1 also the tubes of figure 7 and the likelihoods of figure 8."""
    draw_confusions(tuple(result.summaries.values()), folder / f"{result.name}_confusion.png")
    if result.name == "table1":
        train = [trial for place, trial in enumerate(varying_trials(0)) if place % 50 < _TAUGHT]
        rng = np.random.default_rng([0, 7])
        scenes = [draw_scene(rng) for _ in range(3)]
        draw_tubes(learn_library(train), scenes, folder / "figure7_tubes.png")
        tests = [perform(label, draw_scene(rng), rng) for label in VARYING_MOTIONS]
        draw_likelihoods(train, tests, folder / "figure8_likelihood.png")


def draw_confusions(summaries: Sequence[Summary], path: Path) -> None:
    """Rows are the motions shown, columns what was recognized at the end."""
    with picture(path, 3.4 * len(summaries), 3.6) as figure:
        for axes, summary in zip(np.atleast_1d(figure.subplots(1, len(summaries))), summaries, strict=True):
            shares = summary.confusion / np.maximum(summary.confusion.sum(axis=1, keepdims=True), 1)
            axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.0)
            labels = summary.scores[0].labels
            axes.set_xticks(range(len(labels)), labels, rotation=60, ha="right")
            axes.set_yticks(range(len(labels)), labels)
            axes.set_title(summary.method)
            axes.grid(False)
            for (row, column), value in np.ndenumerate(shares):
                if value >= 0.005:
                    color = "white" if value > 0.5 else "black"
                    axes.text(column, row, f"{100 * value:.0f}", ha="center", va="center", color=color, fontsize=7)


def draw_tubes(library: MotionLibrary, scenes: Sequence[Scene], path: Path) -> None:
    """Tubes of all motions in several scenes, from above: the mean, and two standard deviations about it."""
    colors = color_of(library.labels)
    with picture(path, 3.6 * len(scenes), 3.8) as figure:
        for axes, scene in zip(np.atleast_1d(figure.subplots(1, len(scenes))), scenes, strict=True):
            for label, tube in library.flow_tubes(scene, scene["box"]).items():
                _draw_tube(axes, tube, colors[label])
            for name, color in (("box", "red"), ("bin", "green")):
                axes.plot(*scene[name].position[:2], "s", color=color, markersize=9, zorder=4)
            axes.text(*X, "x", ha="center", va="center", fontsize=13, zorder=4)
            axes.set(xlim=(0.0, SIZE), ylim=(0.0, SIZE), aspect="equal")
        axes.legend(loc="upper right")


def _draw_tube(axes: Any, tube: FlowTube, color: str) -> None:
    from matplotlib.patches import Ellipse

    for n in range(0, len(tube), 4):
        values, vectors = np.linalg.eigh(tube.covariance[n, :2, :2])
        width, height = 4.0 * np.sqrt(values)
        angle = np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0]))
        axes.add_patch(
            Ellipse(
                (tube.position[n, 0], tube.position[n, 1]), width, height, angle=angle, color=color, alpha=0.08, lw=0
            )
        )
    axes.plot(tube.position[:, 0], tube.position[:, 1], color=color, label=tube.label)


def draw_likelihoods(train: Sequence[Demonstration], tests: Sequence[Demonstration], path: Path) -> None:
    """Log likelihood of each label over time: a row per method, a column per recording."""
    methods = LIKELIHOOD_METHODS
    classifiers = {method: method_named(method)(train) for method in methods}
    colors = color_of([item.label for item in train])
    with picture(path, 3.4 * len(tests), 2.4 * len(methods)) as figure:
        grid = figure.subplots(len(methods), len(tests), sharex="col", squeeze=False)
        for row, (method, classifier) in enumerate(classifiers.items()):
            for column, test in enumerate(tests):
                trace, axes = classifier.recognize(test), grid[row][column]
                for index, label in enumerate(trace.labels):
                    scores = np.maximum(trace.log_likelihood[:, index], trace.log_likelihood.max() - 100.0)
                    axes.plot(test.time, scores, color=colors[label], label=label)
                if row == 0:
                    axes.set_title(f"shown: {test.label}")
            grid[row][0].set_ylabel(f"log likelihood\n{method}")
        for axes in grid[-1]:
            axes.set_xlabel("time (s)")
        grid[0][0].legend()
