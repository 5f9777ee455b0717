"""Recognition of recordings of real people: five of each motion teach, the rest are recognized, in random splits.

The absolute start gives the motion away in some sets, so that every set is judged twice: as recorded, and with every
start moved to the origin (where orientations count: turned so that each begins at the identity as well).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from pft_exec.demonstration import Demonstration, convert_recordings
from pft_exec.evaluation.methods import method_named
from pft_exec.evaluation.protocol import (
    FRACTIONS,
    Interval,
    Progress,
    Score,
    Summary,
    area_under_curve,
    score,
    silent,
    strangeness,
    traces,
)
from pft_exec.evaluation.trace import Learn
from pft_exec.geometry import conjugate, multiply

TAUGHT = 5  # demonstrations of each motion that teach
SAMPLES = 200  # a recording is thinned to; the sets were resampled to 200 and 1000 samples by their authors
SETS = ("letters2d", "helloworld", "robottasks9")

# What was known before: start removed, accuracy % after 10, 30, 50, 75, 100 %, and mean share of time right.
# Open-end DTW and the paper's algorithm, one set of prototypes; the last is the prototype of the phase filter.
KNOWN: dict[str, dict[str, tuple[float, ...]]] = {
    "letters2d": {
        "known: DTW neighbor": (35, 58, 85, 94, 96, 73.9),
        "known: dong2012": (18, 55, 89, 100, 100, 73.1),
        "known: phase filter": (41, 74, 97, 100, 100, 81.0),
    },
    "helloworld": {
        "known: DTW neighbor": (83, 90, 95, 100, 100, 92.3),
        "known: dong2012": (61, 81, 96, 100, 100, 87.3),
        "known: phase filter": (86, 97, 99, 100, 100, 94.5),
    },
    "robottasks9": {
        "known: DTW neighbor": (85, 94, 96, 99, 100, 92.6),
        "known: dong2012": (24, 96, 99, 100, 100, 87.7),
        "known: phase filter": (90, 99, 100, 100, 100, 95.3),
    },
}


@dataclass(frozen=True)
class Condition:
    """How a set is judged: with the start moved to the origin or as recorded; with orientation or positions alone."""

    start_removed: bool = True
    pose: bool = False

    @property
    def name(self) -> str:
        """For a table."""
        return f"{'start removed' if self.start_removed else 'absolute'}, {'pose' if self.pose else 'position'}"


def load_set(folder: Path, name: str, condition: Condition) -> list[Demonstration]:
    """The recordings of one set, thinned to at most `SAMPLES` samples, under a condition."""
    return [conditioned(thinned(item), condition) for item in convert_recordings(folder / f"{name}.npz")]


def thinned(demonstration: Demonstration, samples: int = SAMPLES) -> Demonstration:
    """Every k-th sample, so that at most `samples` remain."""
    step = -(-len(demonstration) // samples)
    if step == 1:
        return demonstration
    quaternion = demonstration.quaternion
    return replace(
        demonstration,
        time=demonstration.time[::step],
        position=demonstration.position[::step],
        quaternion=None if quaternion is None else quaternion[::step],
        continuous={name: values[::step] for name, values in demonstration.continuous.items()},
        discrete={name: values[::step] for name, values in demonstration.discrete.items()},
        objects={name: poses if poses.ndim == 1 else poses[::step] for name, poses in demonstration.objects.items()},
        configuration=None,
    )


def conditioned(demonstration: Demonstration, condition: Condition) -> Demonstration:
    """Without what the condition leaves out."""
    position, quaternion = demonstration.position, demonstration.quaternion if condition.pose else None
    if condition.start_removed:
        position = position - position[0]
        quaternion = None if quaternion is None else multiply(conjugate(quaternion[0]), quaternion)
    return replace(demonstration, position=position, quaternion=quaternion)


def split(demonstrations: Sequence[Demonstration], seed: int) -> tuple[list[Demonstration], list[Demonstration]]:
    """`TAUGHT` of each motion at random, and the rest."""
    rng = np.random.default_rng([seed, 5])
    train: list[Demonstration] = []
    tests: list[Demonstration] = []
    for label in sorted({item.label for item in demonstrations}):
        group = [item for item in demonstrations if item.label == label]
        order = rng.permutation(len(group))
        train += [group[i] for i in order[:TAUGHT]]
        tests += [group[i] for i in order[TAUGHT:]]
    return train, tests


@dataclass(frozen=True, eq=False)
class RealResult:
    """One set under one condition: every method over the splits.

    Parameters
    ----------
    name : str
    condition : Condition
    summaries : {method: Summary}
    unknown : {method: (half, end)}
        AUROC of strange motions against known ones, one value per split, half way and at the end; a motion at a time
        is left out of the library.
    """

    name: str
    condition: Condition
    summaries: Mapping[str, Summary]
    unknown: Mapping[str, tuple[Sequence[float], Sequence[float]]]

    def table(self) -> list[dict[str, Any]]:
        """Rows: each method, and what was known before; percent, with 95 % intervals over splits."""
        rows: list[dict[str, Any]] = []
        for method, summary in self.summaries.items():
            row: dict[str, Any] = {"method": method}
            row |= {f"{100 * f:g} %": summary.accuracy(f).percent() for f in FRACTIONS}
            row |= {"share": summary.share.percent(), "decided at": summary.decided.percent()}
            row |= {"calibration": summary.calibration_error.percent()}
            half, end = self.unknown.get(method, ((), ()))
            row["unknown half"] = f"{np.mean(half):.3f}" if len(half) else ""
            row["unknown end"] = f"{np.mean(end):.3f}" if len(end) else ""
            rows.append(row)
        if self.condition == Condition():
            for known, values in KNOWN.get(self.name, {}).items():
                row = {"method": known} | {f"{100 * f:g} %": f"{v:g}" for f, v in zip(FRACTIONS, values, strict=False)}
                rows.append(row | {"share": f"{values[-1]:g}"})
        return rows

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "set": self.name,
            "condition": self.condition.name,
            "methods": {method: summary.to_dict() for method, summary in self.summaries.items()},
            "unknown_auroc": {
                method: {"half": Interval.of(half).to_dict(), "end": Interval.of(end).to_dict()}
                for method, (half, end) in self.unknown.items()
                if len(half)
            },
        }


def evaluate_set(
    folder: Path,
    name: str,
    methods: Sequence[str],
    splits: int = 10,
    condition: Condition | None = None,
    unknown_splits: int = 2,
    unknown_methods: Sequence[str] | None = None,
    progress: Progress = silent,
    jobs: int = 1,
) -> RealResult:
    """Recognize one set with each method over random splits.

    Parameters
    ----------
    folder : Path
        Where the recordings are.
    name : str
        Of the set.
    methods : sequence of str
    splits : int
    condition : Condition
        Start removed and positions alone, where None.
    unknown_splits : int
        On how many of the splits every motion is left out once; it takes as many libraries as there are motions.
    unknown_methods : sequence of str or None
        Which methods are asked that; None asks all.
    progress : callable
    jobs : int
        Splits that are judged at the same time, each by a process of its own.
    """
    condition = condition or Condition()
    demonstrations = load_set(folder, name, condition)
    asked = tuple(methods if unknown_methods is None else unknown_methods)
    work = (
        delayed(_judge_split)(demonstrations, methods, asked if seed < unknown_splits else (), seed)
        for seed in range(splits)
    )
    judged = []
    for one in Parallel(n_jobs=jobs, return_as="generator")(work):
        judged.append(one)
        progress(f"{name}, {condition.name}: {len(judged)} of {splits} splits", len(judged) / splits)
    summaries = {method: Summary(method, tuple(one[method].score for one in judged)) for method in methods}
    return RealResult(name, condition, summaries, {method: _areas(judged, method) for method in asked})


@dataclass(frozen=True, eq=False)
class _Judgment:
    """How one method did on one split; `areas` are the AUROC of strange motions half way and at the end, if asked."""

    score: Score
    areas: tuple[float, float] | None


def _judge_split(
    demonstrations: Sequence[Demonstration], methods: Sequence[str], asked: Sequence[str], seed: int
) -> dict[str, _Judgment]:
    train, tests = split(demonstrations, seed)
    truth = [test.label for test in tests]
    judgments = {}
    for method in methods:
        learn = method_named(method)
        areas = strange_motions(learn, train, tests, seed) if method in asked else None
        judgments[method] = _Judgment(score(traces(learn(train), tests), truth), areas)
    return judgments


def _areas(judged: Sequence[Mapping[str, _Judgment]], method: str) -> tuple[list[float], list[float]]:
    areas = [one[method].areas for one in judged]
    found = [pair for pair in areas if pair is not None]
    return [half for half, _ in found], [end for _, end in found]


def strange_motions(
    learn: Learn, train: Sequence[Demonstration], tests: Sequence[Demonstration], seed: int
) -> tuple[float, float]:
    """AUROC half way and at the end: each motion left out once, its tests against as many of the known ones."""
    rng = np.random.default_rng([seed, 9])
    known: dict[float, list[float]] = {0.5: [], 1.0: []}
    strange: dict[float, list[float]] = {0.5: [], 1.0: []}
    for label in sorted({item.label for item in train}):
        classifier = learn([item for item in train if item.label != label])
        left_out = [item for item in tests if item.label == label]
        others = [item for item in tests if item.label != label]
        chosen = rng.choice(len(others), size=min(len(left_out), len(others)), replace=False)
        strange_answers = traces(classifier, left_out)
        known_answers = traces(classifier, [others[i] for i in chosen])
        for fraction in known:
            strange[fraction] += strangeness(strange_answers, fraction)
            known[fraction] += strangeness(known_answers, fraction)
    return area_under_curve(known[0.5], strange[0.5]), area_under_curve(known[1.0], strange[1.0])
