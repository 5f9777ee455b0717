"""Tables 1 and 2 of [Dong2012]_: the planar world, ours and the baselines beside the published figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.evaluation.methods import METHODS, method_named
from pft_exec.evaluation.planar import SCENE_MOTIONS, VARYING_MOTIONS, scene_trials, varying_trials
from pft_exec.evaluation.protocol import FRACTIONS, Progress, Score, Summary, judge, silent
from pft_exec.evaluation.trace import Learn

ORACLE = "knows these people (bound)"  # what nobody can beat who sees as much; no competitor
TRAINED = 30  # of 50 trials of each motion in varying scenes, 20 test
FOLDS = 5  # of 25 trials of each motion in one scene: 5 train, 20 test

# [Dong2012]_, tables 1 and 2: recognized at the end (of 20, of 100), share of time (%), tube and HMM.
PUBLISHED = {
    "table1": {
        "to bin": (20, 12, 81.1, 55.3),
        "left": (13, 6, 56.0, 28.0),
        "to x": (16, 15, 74.4, 36.3),
    },
    "table2": {
        "to bin": (95, 94, 65.6, 67.9),
        "left": (94, 100, 81.6, 95.6),
        "to x": (96, 98, 79.3, 85.1),
        "CW": (100, 72, 83.2, 65.2),
        "CCW": (99, 72, 94.3, 80.7),
        "anchor x, o": (96, 56, 79.0, 52.8),
        "anchor o, x": (99, 57, 86.7, 45.4),
    },
}
_TESTS = {"table1": 20, "table2": 100}


@dataclass(frozen=True, eq=False)
class TableResult:
    """One table: every method over the seeds.

    Parameters
    ----------
    name : "table1" or "table2"
    summaries : {method: Summary}
    learning : {method: float}, s
        Mean time to learn all motions of one training set.
    """

    name: str
    summaries: Mapping[str, Summary]
    learning: Mapping[str, float]

    def table(self) -> list[dict[str, Any]]:
        """Rows: each method, and the published ones; percent, with 95 % intervals over seeds."""
        rows: list[dict[str, Any]] = []
        for method, summary in self.summaries.items():
            row: dict[str, Any] = {
                "method": method,
                "end": summary.accuracy().percent(),
                "share": summary.share.percent(),
            }
            row |= {f"{100 * f:g} %": summary.accuracy(f).percent() for f in FRACTIONS[:-1]}
            row |= {"decided at": summary.decided.percent(), "calibration": summary.calibration_error.percent()}
            row |= {"ms a sample": f"{1e3 * self._seconds(summary):.3f}", "learning s": f"{self.learning[method]:.2f}"}
            rows.append(row)
        for place, name in ((0, "published tube"), (1, "published HMM")):
            end, share = self.published(place)
            rows.append({"method": name, "end": f"{end:.1f}", "share": f"{share:.1f}"})
        return rows

    def by_motion(self, method: str) -> list[dict[str, Any]]:
        """Rows: each motion, of one method, beside the paper's tube and HMM; percent."""
        summary, rows = self.summaries[method], []
        labels = summary.scores[0].labels
        for index, label in enumerate(labels):
            confusion, tests = summary.confusion[index], _TESTS[self.name]
            tube, hmm, tube_share, hmm_share = PUBLISHED[self.name][label]
            rows.append(
                {
                    "motion": label,
                    "end": f"{100.0 * confusion[index] / confusion.sum():.1f}",
                    "published tube": f"{100.0 * tube / tests:.0f}",
                    "published HMM": f"{100.0 * hmm / tests:.0f}",
                    "share": f"{100.0 * np.mean([item.shares[label] for item in summary.scores]):.1f}",
                    "published tube share": f"{tube_share:.1f}",
                    "published HMM share": f"{hmm_share:.1f}",
                    **{f"as {other}": int(confusion[place]) for place, other in enumerate(labels)},
                }
            )
        return rows

    def published(self, place: int) -> tuple[float, float]:
        """Recognized at the end and share of time, %, of the published tube (0) or HMM (1), all motions together."""
        rows = PUBLISHED[self.name].values()
        end = 100.0 * sum(row[place] for row in rows) / (_TESTS[self.name] * len(rows))
        return end, float(np.mean([row[2 + place] for row in rows]))

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "name": self.name,
            "methods": {method: summary.to_dict() for method, summary in self.summaries.items()},
            "learning_seconds": dict(self.learning),
            "published": {"tube": self.published(0), "hmm": self.published(1)},
        }

    @staticmethod
    def _seconds(summary: Summary) -> float:
        return float(np.mean([np.mean(list(item.seconds.values())) for item in summary.scores]))


def table1(seeds: int = 5, methods: Sequence[str] = (*METHODS, ORACLE), progress: Progress = silent) -> TableResult:
    """Varying scenes: 30 of 50 trials of each motion train, chosen at random, 20 test."""
    return _run("table1", seeds, methods, progress)


def table2(seeds: int = 5, methods: Sequence[str] = tuple(METHODS), progress: Progress = silent) -> TableResult:
    """One scene: 5-fold, 5 of 25 trials of each motion train, 20 test."""
    return _run("table2", seeds, methods, progress)


def _run(name: str, seeds: int, methods: Sequence[str], progress: Progress) -> TableResult:
    splits = _varying_splits if name == "table1" else _scene_splits
    scores: dict[str, list[Score]] = {method: [] for method in methods}
    learning: dict[str, list[float]] = {method: [] for method in methods}
    for seed in range(seeds):
        parts = list(splits(seed))
        for place, method in enumerate(methods):
            progress(f"{name}, seed {seed + 1} of {seeds}: {method}", (seed + place / len(methods)) / seeds)
            judged = judge(_learn(method), parts, learning[method])
            scores[method].append(judged)
    progress(name, 1.0)
    summaries = {method: Summary(method, tuple(values)) for method, values in scores.items()}
    return TableResult(name, summaries, {method: float(np.mean(values)) for method, values in learning.items()})


def _learn(method: str) -> Learn:
    if method != ORACLE:
        return method_named(method)
    from pft_exec.evaluation.baselines.oracle import know_people  # it compiles for a few seconds

    return know_people


def _varying_splits(seed: int) -> Iterator[tuple[list[Demonstration], list[Demonstration]]]:
    trials, rng = varying_trials(seed), np.random.default_rng([seed, 1])
    train: list[Demonstration] = []
    tests: list[Demonstration] = []
    for label in VARYING_MOTIONS:
        group = [trial for trial in trials if trial.label == label]
        order = rng.permutation(len(group))
        train += [group[i] for i in order[:TRAINED]]
        tests += [group[i] for i in order[TRAINED:]]
    yield train, tests


def _scene_splits(seed: int) -> Iterator[tuple[list[Demonstration], list[Demonstration]]]:
    trials = scene_trials(seed)
    groups = [[trial for trial in trials if trial.label == label] for label in SCENE_MOTIONS]
    for fold in range(FOLDS):
        train = [trial for group in groups for i, trial in enumerate(group) if i % FOLDS == fold]
        tests = [trial for group in groups for i, trial in enumerate(group) if i % FOLDS != fold]
        yield train, tests
