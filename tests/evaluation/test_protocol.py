"""The protocol on answers whose score is known by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.evaluation.protocol import (
    FRACTIONS,
    Interval,
    Summary,
    area_under_curve,
    score,
    strangeness,
)
from pft_exec.evaluation.trace import Trace, softmax


def trace(leading: str, confidence: float = 1.0, seconds: float = 0.0) -> Trace:
    """A trace over labels a and b whose leader after each sample is spelled out, such as "aab"."""
    probability = np.array(
        [[confidence, 1 - confidence] if x == "a" else [1 - confidence, confidence] for x in leading]
    )
    unknown = np.arange(len(leading), dtype=float)
    return Trace(("a", "b"), np.log(np.maximum(probability, 1e-12)), probability, unknown, seconds)


def test_accuracy_counts_samples_known_after_each_fraction() -> None:
    judged = score([trace("bbbaaaaaaa")], ["a"])
    np.testing.assert_array_equal(judged.accuracy, [0.0, 0.0, 1.0, 1.0, 1.0])
    assert FRACTIONS == (0.1, 0.3, 0.5, 0.75, 1.0)


def test_share_is_averaged_over_tests_not_samples() -> None:
    judged = score([trace("ab"), trace("bbbbbbbb")], ["a", "b"])
    assert judged.share == pytest.approx(0.75)
    assert judged.shares == {"a": 0.5, "b": 1.0}


@pytest.mark.parametrize(("leading", "decided"), [("aaaa", 0.0), ("baaa", 0.25), ("abaa", 0.5), ("aaab", 1.0)])
def test_decision_point_is_where_the_answer_stays_right(leading: str, decided: float) -> None:
    assert score([trace(leading)], ["a"]).decided == decided


def test_confusion_has_the_truth_in_rows() -> None:
    judged = score([trace("ab"), trace("bb"), trace("aa")], ["a", "b", "b"])
    np.testing.assert_array_equal(judged.confusion, [[0, 1], [1, 1]])


def test_calibration_error_is_the_gap_of_confidence_and_accuracy() -> None:
    """Ten samples at 85 %, of which 6 are right: the gap is 0.25. Sure and right: none."""
    assert score([trace("aaaaaabbbb", confidence=0.85)], ["a"]).calibration_error == pytest.approx(0.25)
    assert score([trace("aaaa")], ["a"]).calibration_error == 0.0


def test_calibration_error_weighs_bins_by_their_samples() -> None:
    judged = score([trace("aaaaaaaa", confidence=0.95), trace("bb", confidence=0.65)], ["a", "a"])
    assert judged.calibration_error == pytest.approx(0.8 * 0.05 + 0.2 * 0.65)


def test_area_under_curve() -> None:
    assert area_under_curve([0.0, 1.0], [2.0, 3.0]) == 1.0
    assert area_under_curve([2.0, 3.0], [0.0, 1.0]) == 0.0
    assert area_under_curve([1.0, 1.0], [1.0]) == 0.5
    assert area_under_curve([0.0, 2.0], [1.0, 3.0]) == 0.75


def test_strangeness_is_read_after_the_fraction() -> None:
    assert strangeness([trace("aaaa")], 0.5) == [1.0]
    assert strangeness([trace("aaaa")], 1.0) == [3.0]


def test_interval_is_that_of_student() -> None:
    """Mean 2, standard deviation 1, n = 3: t(0.975, 2) = 4.3027 by the tables."""
    interval = Interval.of([1.0, 2.0, 3.0])
    assert interval.mean == 2.0
    assert interval.half == pytest.approx(4.3027 / np.sqrt(3.0), rel=1e-4)
    assert Interval.of([0.5]).percent() == "50.0"
    assert Interval(0.5, 0.021).percent() == "50.0 ± 2.1"


def test_summary_joins_seeds() -> None:
    summary = Summary("some", (score([trace("aa")], ["a"]), score([trace("ab")], ["a"])))
    assert summary.accuracy().mean == 0.5
    np.testing.assert_array_equal(summary.confusion, [[1, 1], [0, 0]])
    assert summary.to_dict()["share"]["mean"] == 0.75


def test_softmax_bears_any_size() -> None:
    np.testing.assert_allclose(softmax(np.array([-1e6, -1e6 + np.log(3.0)])), [0.25, 0.75])
