"""Figure 5 of [Dong2012]_: motions taught to a PR2 five times each, and what was learned of them.

The published figure shows, per motion, the demonstrations beside the motion learned for one arbitrary scene. Here both
methods learn from the same demonstrations, and a person makes each motion once more in that scene, for comparison.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.description import TaskDescription, load_task
from pft_exec.evaluation.benchmarks.stopwatch import milliseconds
from pft_exec.evaluation.lessons import Lesson, give_lessons
from pft_exec.evaluation.measurements import found_relations
from pft_exec.evaluation.methods import expected_conflicts, published_options
from pft_exec.evaluation.protocol import Progress, silent
from pft_exec.geometry import Array
from pft_exec.learning import FlowTube, Motion, MotionLibrary, learn_library, learn_motion
from pft_exec.report import page
from pft_exec.report.motion_sheet import plot_motion

SAMPLES = 100  # of a demonstration, about as many as the paper's
SHOWN_SEED = 1_000_003  # added to a seed: of the demonstration that nobody learns from

# What [Dong2012]_, section 4.3, says of its motions; it lists neither all variables nor any success rate.
PUBLISHED_LEARNING = "0.9 to 1.3 s"
PUBLISHED = {
    "move_left": "failed: the displacement varied too much to be found relevant; it still looked like the lessons",
    "go_home": "found: absolute position and orientation at the end",
    "pour_into": "found: the effector over the object at the end",
    "pour_done": "found: the effector over the object at the start",
    "reach": "found: an object at the end",
    "stir": "failed: a relation of start and end that nobody meant; the motion shrank to a small vibration",
    "shake": "shown: up, down, up, down",
}
UNMENTIONED = "not spoken of"


@dataclass(frozen=True, eq=False)
class LearnedMotion:
    """One motion of the figure.

    Parameters
    ----------
    label : str
    demonstrations : (K,) Demonstration
    shown : Demonstration
        The motion in a new scene; not learned from.
    tubes : {method: FlowTube}
        In that scene.
    meant, found : {"start.position", ...: frame}, and the same by method
        Relations that the task's author meant, and those that each method found.
    numbers : {method: str}
        The decisions in words, with what decided them.
    learning : {method: float}, ms
        From K demonstrations of `SAMPLES` samples.
    """

    label: str
    demonstrations: tuple[Demonstration, ...]
    shown: Demonstration
    tubes: Mapping[str, FlowTube]
    meant: Mapping[str, str]
    found: Mapping[str, Mapping[str, str]]
    numbers: Mapping[str, str]
    learning: Mapping[str, float]

    def right(self, method: str) -> str:
        """How many of the relations, position and orientation at either end, are as they were meant: "4 of 4"."""
        hits = sum(self.found[method].get(end) == meant for end, meant in self.meant.items())
        return f"{hits} of {len(self.meant)}"

    @property
    def objects(self) -> set[str]:
        """Objects that some relation is meant to be to."""
        return {*self.meant.values()} & {*self.shown.scene.objects}

    def size(self, method: str) -> float:
        """Extent of the learned motion as a share of a person's in the same scene; a collapsed one has little."""
        return _extent(self.tubes[method].position) / _extent(self.shown.position)

    def row(self) -> dict[str, Any]:
        """For a table."""
        row: dict[str, Any] = {"motion": self.label}
        for method in self.tubes:
            row |= {
                f"{method}: variables right": self.right(method),
                f"{method}: size, % of a person's": 100.0 * self.size(method),
                f"{method}: learned in ms": self.learning[method],
            }
        return row | {"paper": PUBLISHED.get(self.label, UNMENTIONED)}

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            **self.row(),
            "meant": dict(self.meant),
            "found": {method: dict(found) for method, found in self.found.items()},
            "numbers": dict(self.numbers),
        }


def figure5(
    task: str = "bottle",
    robot: str = "pr2",
    seed: int = 0,
    *,
    count: int = 5,
    folder: Path | None = None,
    jobs: int = 1,
    progress: Progress = silent,
) -> list[LearnedMotion]:
    """Teach every motion of a task, and learn it with both methods.

    Parameters
    ----------
    task, robot : str
        Names or paths.
    seed : int
    count : int
        Demonstrations of each motion.
    folder : Path or None
        Of lessons that are kept.
    jobs : int
        Processes that teach.
    progress : callable
    """
    description = load_task(task)
    lessons = [Lesson(robot, task, label, seed, count) for label in description.labels]
    unseen = [Lesson(robot, task, label, seed + SHOWN_SEED, 1) for label in description.labels]
    taught = give_lessons(lessons + unseen, folder, jobs, progress)
    everything = [item for lesson in lessons for item in taught[lesson]]
    libraries = _learned(everything)
    return [
        _motion(description, libraries, taught[lesson], taught[other][0])
        for lesson, other in zip(lessons, unseen, strict=True)
    ]


def _learned(demonstrations: Sequence[Demonstration]) -> dict[str, MotionLibrary]:
    with expected_conflicts():
        return {
            "robust": learn_library(demonstrations),
            "dong2012": learn_library(demonstrations, "dong2012", **published_options(demonstrations)),
        }


def _motion(
    task: TaskDescription,
    libraries: Mapping[str, MotionLibrary],
    demonstrations: tuple[Demonstration, ...],
    shown: Demonstration,
) -> LearnedMotion:
    label = shown.label
    thin = [thinned(item, SAMPLES) for item in demonstrations]
    with expected_conflicts():
        return LearnedMotion(
            label,
            demonstrations,
            shown,
            {method: library[label].flow_tube(shown.scene, shown.start) for method, library in libraries.items()},
            task.relations(label),
            {method: found_relations(library, label) for method, library in libraries.items()},
            {method: library[label].describe() for method, library in libraries.items()},
            {method: _learning_time(thin, library[label]) for method, library in libraries.items()},
        )


def _learning_time(demonstrations: Sequence[Demonstration], motion: Motion) -> float:
    """Of a motion's method and options, ms; the median of some runs."""
    return milliseconds(lambda: learn_motion(demonstrations, motion.method, **motion.options), repeats=5)


def thinned(demonstration: Demonstration, samples: int) -> Demonstration:
    """So many samples of a demonstration, evenly chosen; all where it has fewer."""
    rows = np.unique(np.round(np.linspace(0, len(demonstration) - 1, samples)).astype(int))
    quaternion, configuration = demonstration.quaternion, demonstration.configuration
    return Demonstration(
        demonstration.label,
        demonstration.time[rows],
        demonstration.position[rows],
        None if quaternion is None else quaternion[rows],
        {name: values[rows] for name, values in demonstration.continuous.items()},
        {name: values[rows] for name, values in demonstration.discrete.items()},
        {name: poses if poses.ndim == 1 else poses[rows] for name, poses in demonstration.objects.items()},
        None if configuration is None else configuration[rows],
        demonstration.keyframes,
    )


def _extent(path: Array) -> float:
    """Diagonal of the box around a path (N, 3), m."""
    return float(np.linalg.norm(np.ptp(path, axis=0)))


def write_figure5(motions: Sequence[LearnedMotion], folder: Path) -> Path:
    """Write ``figure5.html`` with everything in it, and the picture of each motion beside it."""
    parts = [
        page.paragraph(
            f"Each motion was taught {len(motions[0].demonstrations)} times by a simulated hand that leads the "
            "floating arm. Left: the demonstrations as recorded. Then the tubes that the methods learned, in a scene "
            "that nobody taught. Below, over time: the dark band is the tube at the same place of the motion, the "
            f"light one holds also who is early or late. The paper learned a motion in {PUBLISHED_LEARNING} from five "
            "demonstrations of about 100 samples."
        ),
        page.paragraph(
            "Variables: position and orientation at the start and at the end, four of each motion; one is right where "
            "exactly the relation was found that the motion's author meant, none where none was meant."
        ),
        page.table([item.row() for item in motions], "all motions"),
    ]
    for item in motions:
        picture = folder / f"figure5_{item.label}.png"
        plot_motion(item.demonstrations, item.tubes, picture, item.shown, item.objects)
        parts.append(page.section(*_section(item, picture)))
    return page.write_page(folder / "figure5.html", "Figure 5: motions taught to a PR2", parts)


def _section(item: LearnedMotion, picture: Path) -> list[str]:
    rows = [
        {"end": end, "meant": meant, **{method: found[end] for method, found in item.found.items()}}
        for end, meant in item.meant.items()
    ]
    learned = ", ".join(f"{time:.1f} ms ({method})" for method, time in item.learning.items())
    parts = [
        page.heading(item.label.replace("_", " ")),
        page.image(picture, f"{item.label}: taught and learned"),
        page.paragraph(f"In the paper: {PUBLISHED.get(item.label, UNMENTIONED)}."),
        page.paragraph(f"Learned in {learned}; in the paper in {PUBLISHED_LEARNING}."),
    ]
    parts.append(page.table(rows, "relevant motion variables"))
    for method, text in item.numbers.items():
        lines = [{"decision": line.replace("`", "")} for line in text.splitlines()]
        parts.append(page.table(lines, f"numbers, {method}"))
    return parts
