"""Table 3 of [Dong2012]_: five motions taught to a Barrett WAM, told from one another while they are made.

Two conditions. *One scene, centered* is the paper's: every trial of a motion in the same scene, all recordings shifted
to a common start, so that objects play no part. A recording is cut to the motion, since nobody can tell what will be
made while the hand still rests; with the rests, 0.2 to 0.4 s before each motion, the same is reported beside it.
*Scenes varied, absolute* the paper did not try: a new placement for each trial, nothing shifted, nothing cut. The five
motions come from three tasks, whose objects would stand in one another's way on one board; so in that condition the
objects of all three are seen in every recording, those of the other tasks where their own tasks may have put them: each
motion is a candidate in every scene.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.demonstration.segmentation import without_idle_ends
from pft_exec.description import draw_scene, load_task, random_stream
from pft_exec.evaluation.lessons import Lesson, Taught, give_lessons
from pft_exec.evaluation.methods import method_named
from pft_exec.evaluation.protocol import FRACTIONS, Progress, Summary, judge, silent

MOTIONS = {
    "ball_to_bin": "ball_bin",
    "wind": "cable",
    "unwind": "cable",
    "anchor_left_right": "anchor",
    "anchor_right_left": "anchor",
}
"""The task of each motion, in the order of the table."""
ROBOT, TOOL = "wam", "gripper"
TRIALS, FOLDS = 10, 2  # of each motion: five train, five test, both ways
METHODS = ("robust, phase", "dong2012")

CENTERED, RESTED, VARIED = "one scene, centered", "one scene, centered, rests kept", "scenes varied, absolute"
CONDITIONS = (CENTERED, RESTED, VARIED)

PUBLISHED = {
    "ball_to_bin": (10, 93.5, 24.0),
    "wind": (10, 92.7, 13.0),
    "unwind": (10, 96.4, 11.0),
    "anchor_left_right": (10, 84.1, 32.0),
    "anchor_right_left": (10, 86.2, 33.0),
}
"""[Dong2012]_, table 3: recognized at the end, of 10; share of time, %; ms a sample."""


@dataclass(frozen=True, eq=False)
class Table3:
    """One condition: both methods over the seeds.

    Parameters
    ----------
    condition : str
        One of `CONDITIONS`.
    summaries : {method: Summary}
    learning : {method: float}, s
        Mean time to learn all motions of one training set.
    """

    condition: str
    summaries: Mapping[str, Summary]
    learning: Mapping[str, float]

    def table(self) -> list[dict[str, Any]]:
        """Rows: each method, and in the paper's condition the published one."""
        rows = [self._row(method, summary) for method, summary in self.summaries.items()]
        if self.condition == CENTERED:
            end = sum(row[0] for row in PUBLISHED.values())
            share = float(np.mean([row[1] for row in PUBLISHED.values()]))
            rows.append(
                {"method": "published", "recognized at the end": f"{end} of 50", "share of time %": f"{share:.1f}"}
            )
        return rows

    def _row(self, method: str, summary: Summary) -> dict[str, Any]:
        hits, count = int(np.trace(summary.confusion)), int(summary.confusion.sum())
        by_seed = [f"{np.trace(item.confusion)}" for item in summary.scores]
        row: dict[str, Any] = {
            "method": method,
            "recognized at the end": f"{hits} of {count}",
            "by seed, of 50": ", ".join(by_seed),
            "share of time %": summary.share.percent(),
            "by seed": ", ".join(f"{100.0 * item.share:.1f}" for item in summary.scores),
        }
        row |= {f"after {100 * f:g} %": summary.accuracy(f).percent() for f in FRACTIONS[:-1]}
        row |= {"ms a sample": f"{1e3 * _seconds(summary):.2f}", "learning s": f"{self.learning[method]:.2f}"}
        return row

    def by_motion(self, method: str) -> list[dict[str, Any]]:
        """Rows: each motion, beside the published figures, with what it was taken for at the end."""
        summary = self.summaries[method]
        labels, rows = summary.scores[0].labels, []
        for label in MOTIONS:
            confusion = summary.confusion[labels.index(label)]
            published = PUBLISHED[label]
            rows.append(
                {
                    "motion": label,
                    "at the end": f"{confusion[labels.index(label)]} of {confusion.sum()}",
                    "published, of 10": published[0],
                    "share %": 100.0 * float(np.mean([item.shares[label] for item in summary.scores])),
                    "published share %": published[1],
                    "ms a sample": 1e3 * float(np.mean([item.seconds[label] for item in summary.scores])),
                    "published ms": published[2],
                    **{f"as {other}": int(confusion[labels.index(other)]) for other in MOTIONS},
                }
            )
        return rows

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "condition": self.condition,
            "methods": {method: summary.to_dict() for method, summary in self.summaries.items()},
            "by_motion": {method: self.by_motion(method) for method in self.summaries},
            "learning_seconds": dict(self.learning),
        }


def table3(
    seeds: int = 5,
    methods: Sequence[str] = METHODS,
    *,
    folder: Path | None = None,
    jobs: int = 1,
    progress: Progress = silent,
) -> list[Table3]:
    """Both conditions over some seeds.

    Parameters
    ----------
    seeds : int
        Each teaches ten trials of every motion in both conditions, and is split two ways.
    methods : sequence of str
        See `pft_exec.evaluation.methods`.
    folder : Path or None
        Of lessons that are kept; teaching takes most of the time.
    jobs : int
        Processes that teach.
    progress : callable
    """
    lessons = {condition: _lessons(seeds, condition) for condition in CONDITIONS}
    everything = list(dict.fromkeys(lesson for chosen in lessons.values() for lesson in chosen))
    taught = give_lessons(everything, folder, jobs, lambda stage, done: progress(stage, 0.8 * done))
    tables = []
    for place, (condition, chosen) in enumerate(lessons.items()):
        progress(condition, 0.8 + 0.2 * place / len(CONDITIONS))
        trials = [
            _trials(taught, [lesson for lesson in chosen if lesson.seed == seed], condition) for seed in range(seeds)
        ]
        tables.append(_judged(condition, trials, methods))
    return tables


def _lessons(seeds: int, condition: str) -> list[Lesson]:
    return [
        Lesson(ROBOT, task, label, seed, TRIALS, tool=TOOL, same_scene=condition != VARIED)
        for seed in range(seeds)
        for label, task in MOTIONS.items()
    ]


def _trials(taught: Taught, lessons: Sequence[Lesson], condition: str) -> list[list[Demonstration]]:
    """The trials of one seed, by motion, as their condition has them."""
    if condition == VARIED:
        return [
            [with_bystanders(trial, lesson.seed, i) for i, trial in enumerate(taught[lesson])] for lesson in lessons
        ]
    cut = without_idle_ends if condition == CENTERED else _as_recorded
    return [[centered(cut(trial)) for trial in taught[lesson]] for lesson in lessons]


def _as_recorded(demonstration: Demonstration) -> Demonstration:
    return demonstration


def centered(demonstration: Demonstration) -> Demonstration:
    """Shifted so that it begins at the origin and at time 0, and without objects: as the paper compared recordings."""
    return replace(
        demonstration,
        time=demonstration.time - demonstration.time[0],
        position=demonstration.position - demonstration.position[0],
        objects={},
    )


def with_bystanders(demonstration: Demonstration, seed: int, number: int) -> Demonstration:
    """With the objects of the other tasks in its scene, where those tasks may have put them."""
    own = MOTIONS[demonstration.label]
    objects = dict(demonstration.objects)
    for task in dict.fromkeys(MOTIONS.values()):
        if task != own:
            rng = random_stream(seed, "teach", "bystanders", demonstration.label, number, task)
            objects |= {name: pose.array for name, pose in draw_scene(load_task(task), rng).items()}
    return replace(demonstration, objects=objects)


def _judged(condition: str, trials: Sequence[list[list[Demonstration]]], methods: Sequence[str]) -> Table3:
    learning: dict[str, list[float]] = {method: [] for method in methods}
    scores = {
        method: tuple(judge(method_named(method), _splits(groups), learning[method]) for groups in trials)
        for method in methods
    }
    summaries = {method: Summary(method, values) for method, values in scores.items()}
    return Table3(condition, summaries, {method: float(np.mean(values)) for method, values in learning.items()})


def _splits(groups: Sequence[Sequence[Demonstration]]) -> Iterator[tuple[list[Demonstration], list[Demonstration]]]:
    for fold in range(FOLDS):
        train = [trial for group in groups for i, trial in enumerate(group) if i % FOLDS == fold]
        tests = [trial for group in groups for i, trial in enumerate(group) if i % FOLDS != fold]
        yield train, tests


def _seconds(summary: Summary) -> float:
    return float(np.mean([np.mean(list(item.seconds.values())) for item in summary.scores]))
