"""One protocol for all methods: what is asked of the answers along a recording, and how it is averaged.

Fractions of a motion count samples: row ``ceil(f T) - 1`` is what is known after the fraction f of T samples.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from pft_exec.demonstration import Demonstration
from pft_exec.evaluation.trace import Classifier, Learn, Trace
from pft_exec.geometry import Array

FRACTIONS = (0.1, 0.3, 0.5, 0.75, 1.0)
BINS = 10  # of the expected calibration error

Progress = Callable[[str, float], None]


def silent(stage: str, done: float) -> None:
    """No progress is shown."""


@dataclass(frozen=True, eq=False)
class Score:
    """How one method did on the tests of one seed; shares in [0, 1].

    Parameters
    ----------
    accuracy : (F,)
        Share of tests whose label led after each of `FRACTIONS`.
    share : float
        Mean over tests of the share of samples at which the right label led.
    decided : float
        Mean over tests of the fraction of the motion from which on the right label led to the end; 1 where it did not.
    calibration_error : float
        Expected calibration error of the leading label's probability, every sample of every test, `BINS` bins.
    confusion : (L, L) int
        Rows are the true labels, columns the ones that led at the end; both in the order of `labels`.
    labels : (L,)
    shares : {label: float}
        `share` of each true label.
    seconds : {label: float}, s
        Mean computing time of a sample in the tests of each true label.
    """

    accuracy: Array
    share: float
    decided: float
    calibration_error: float
    confusion: NDArray[np.int64]
    labels: tuple[str, ...]
    shares: Mapping[str, float] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)


def traces(classifier: Classifier, tests: Sequence[Demonstration]) -> list[Trace]:
    """Answers along each test."""
    return [classifier.recognize(test) for test in tests]


def judge(
    learn: Learn, splits: Iterable[tuple[Sequence[Demonstration], Sequence[Demonstration]]], learning: list[float]
) -> Score:
    """One method over splits into what it learns from and what it is asked; all answers count together.

    The seconds that each learning took are appended to `learning`.
    """
    answers: list[Trace] = []
    truth: list[str] = []
    for train, tests in splits:
        begin = time.perf_counter()
        classifier = learn(train)
        learning.append(time.perf_counter() - begin)
        answers += traces(classifier, tests)
        truth += [test.label for test in tests]
    return score(answers, truth)


def score(answers: Sequence[Trace], truth: Sequence[str]) -> Score:
    """Judge the answers of one method along tests whose labels are known."""
    labels = answers[0].labels
    right = [np.array(trace.leading) == label for trace, label in zip(answers, truth, strict=True)]
    by_label = {label: [i for i, name in enumerate(truth) if name == label] for label in labels}
    confusion = np.zeros((len(labels), len(labels)), dtype=np.int64)
    for trace, label in zip(answers, truth, strict=True):
        confusion[labels.index(label), labels.index(trace.leading[-1])] += 1
    return Score(
        accuracy=np.array([np.mean([row[_after(f, len(row))] for row in right]) for f in FRACTIONS]),
        share=float(np.mean([row.mean() for row in right])),
        decided=float(np.mean([_decided(row) for row in right])),
        calibration_error=_calibration_error(answers, right),
        confusion=confusion,
        labels=labels,
        shares={label: float(np.mean([right[i].mean() for i in rows])) for label, rows in by_label.items() if rows},
        seconds={label: float(np.mean([answers[i].seconds for i in rows])) for label, rows in by_label.items() if rows},
    )


def _after(fraction: float, count: int) -> int:
    return max(int(np.ceil(fraction * count - 1e-9)) - 1, 0)


def _decided(right: NDArray[np.bool_]) -> float:
    """Fraction of the motion from which on the answer stays right."""
    wrong = np.flatnonzero(~right)
    return 0.0 if len(wrong) == 0 else float(wrong[-1] + 1) / len(right)


def _calibration_error(answers: Sequence[Trace], right: Sequence[NDArray[np.bool_]]) -> float:
    """Expected calibration error: mean gap between confidence and accuracy, weighted by the samples in each bin."""
    confidence = np.concatenate([trace.probability.max(axis=1) for trace in answers])
    hits = np.concatenate(right)
    bins = np.minimum((confidence * BINS).astype(int), BINS - 1)
    gaps = [
        np.sum(bins == b) / len(hits) * abs(float(confidence[bins == b].mean()) - float(hits[bins == b].mean()))
        for b in np.unique(bins)
    ]
    return float(np.sum(gaps))


def area_under_curve(known: Sequence[float], unknown: Sequence[float]) -> float:
    """AUROC: how likely a strange motion scores above a known one; ties count half."""
    ranks = stats.rankdata(np.concatenate([known, unknown]))
    count = len(unknown)
    above = ranks[len(known) :].sum() - count * (count + 1) / 2.0
    return float(above / (count * len(known)))


def strangeness(answers: Sequence[Trace], fraction: float) -> list[float]:
    """How unknown each test looked after a fraction of it."""
    return [float(trace.unknown[_after(fraction, len(trace.unknown))]) for trace in answers]


@dataclass(frozen=True)
class Interval:
    """A mean over seeds and half the width of its 95 % interval (Student t); 0 where there is one seed."""

    mean: float
    half: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Interval:
        """From one value per seed."""
        array = np.asarray(values, dtype=float)
        if len(array) < 2:
            return cls(float(array.mean()), 0.0)
        spread = float(array.std(ddof=1)) / np.sqrt(len(array))
        return cls(float(array.mean()), float(stats.t.ppf(0.975, len(array) - 1)) * spread)

    def percent(self, digits: int = 1) -> str:
        """As text, in percent."""
        text = f"{100 * self.mean:.{digits}f}"
        return text if self.half == 0.0 else f"{text} ± {100 * self.half:.{digits}f}"

    def to_dict(self) -> dict[str, float]:
        """For JSON."""
        return {"mean": self.mean, "half": self.half}


@dataclass(frozen=True, eq=False)
class Summary:
    """One method over all seeds."""

    method: str
    scores: tuple[Score, ...]

    def accuracy(self, fraction: float = 1.0) -> Interval:
        """Share of tests right after a fraction of the motion."""
        return Interval.of([float(item.accuracy[FRACTIONS.index(fraction)]) for item in self.scores])

    @property
    def share(self) -> Interval:
        """Share of time right."""
        return Interval.of([item.share for item in self.scores])

    @property
    def decided(self) -> Interval:
        """Stable decision point."""
        return Interval.of([item.decided for item in self.scores])

    @property
    def calibration_error(self) -> Interval:
        """Expected calibration error."""
        return Interval.of([item.calibration_error for item in self.scores])

    @property
    def confusion(self) -> NDArray[np.int64]:
        """Confusion matrix at the end, summed over seeds."""
        total: NDArray[np.int64] = np.sum([item.confusion for item in self.scores], axis=0)
        return total

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "method": self.method,
            "accuracy": {f"{fraction:g}": self.accuracy(fraction).to_dict() for fraction in FRACTIONS},
            "share": self.share.to_dict(),
            "decided": self.decided.to_dict(),
            "calibration_error": self.calibration_error.to_dict(),
            "labels": list(self.scores[0].labels),
            "confusion": self.confusion.tolist(),
            "seconds_a_sample": float(np.mean([np.mean(list(item.seconds.values())) for item in self.scores])),
        }
