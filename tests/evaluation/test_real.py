"""Recordings of real people: how they are thinned, conditioned, split and judged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.evaluation.real import (
    Condition,
    conditioned,
    evaluate_set,
    load_set,
    split,
    strange_motions,
    thinned,
)
from pft_exec.evaluation.reproduction import recordings_folder
from pft_exec.evaluation.trace import Learn
from pft_exec.exceptions import StorageError


def recording(label: str, seed: int = 0, count: int = 30) -> Demonstration:
    rng = np.random.default_rng(seed)
    turn = rng.standard_normal((count, 4)) * 0.1 + [0.0, 0.0, 0.0, 1.0]
    turn /= np.linalg.norm(turn, axis=1, keepdims=True)
    return Demonstration(label, np.arange(float(count)), rng.standard_normal((count, 3)), turn)


def test_thinning_keeps_every_kth_sample() -> None:
    item = recording("a", count=1000)
    assert len(thinned(item)) == 200
    np.testing.assert_array_equal(thinned(item).position, item.position[::5])
    assert thinned(item, 1000) is item
    assert len(thinned(recording("a", count=201))) == 101


def test_conditions_remove_what_they_say() -> None:
    item = recording("a")
    removed = conditioned(item, Condition())
    np.testing.assert_array_equal(removed.position[0], 0.0)
    assert removed.quaternion is None
    posed = conditioned(item, Condition(pose=True))
    np.testing.assert_allclose(np.abs(posed.quaternion[0]), [0.0, 0.0, 0.0, 1.0], atol=1e-12)
    absolute = conditioned(item, Condition(start_removed=False, pose=True))
    np.testing.assert_array_equal(absolute.position, item.position)
    np.testing.assert_array_equal(absolute.quaternion, item.quaternion)


def test_splits_teach_five_of_each_and_test_the_rest() -> None:
    items = [recording(label, seed) for label in "ab" for seed in range(8)]
    train, tests = split(items, 1)
    assert len(train) == 10
    assert len(tests) == 6
    assert not {id(item) for item in train} & {id(item) for item in tests}
    assert {id(item) for item in split(items, 1)[0]} == {id(item) for item in train}
    assert {id(item) for item in split(items, 2)[0]} != {id(item) for item in train}


def _oracle(labels: set[str]) -> Learn:
    """A method whose strangeness is 1 exactly for what it was not taught."""
    from pft_exec.evaluation.trace import Trace

    class Oracle:
        def __init__(self, known: set[str]) -> None:
            self.known = known

        def recognize(self, item: Demonstration) -> Trace:
            rows = np.ones((len(item), 1))
            return Trace(("a",), rows, rows, rows[:, 0] * (item.label not in self.known))

    return lambda train: Oracle({item.label for item in train} | labels)


def test_a_method_that_knows_what_it_does_not_know_has_the_whole_area() -> None:
    train, tests = split([recording(label, seed) for label in "abc" for seed in range(8)], 0)
    assert strange_motions(_oracle(set()), train, tests, 0) == (1.0, 1.0)
    assert strange_motions(_oracle(set("abc")), train, tests, 0) == (0.5, 0.5)


def test_missing_recordings_are_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PFT_EXEC_DATA", str(tmp_path))
    with pytest.raises(StorageError, match=r"no recordings letters2d, helloworld.* in .*Set PFT_EXEC_DATA"):
        recordings_folder()


@pytest.mark.data
def test_recordings_are_found_where_the_variable_points(monkeypatch: pytest.MonkeyPatch, recordings: Path) -> None:
    monkeypatch.setenv("PFT_EXEC_DATA", str(recordings))
    assert recordings_folder() == recordings


@pytest.mark.data
def test_sets_load_thinned(recordings: Path) -> None:
    items = load_set(recordings, "robottasks9", Condition(pose=True))
    assert {len(item) for item in items} == {200}
    assert all(item.quaternion is not None for item in items)


@pytest.mark.data
@pytest.mark.slow
def test_neighbors_reach_what_was_known_of_them(recordings: Path) -> None:
    """helloworld, start removed: known 90 / 95 / 100 % after 30, 50, 100 % of the motion, share 92.3."""
    result = evaluate_set(recordings, "helloworld", ["DTW neighbor"], splits=4, unknown_splits=0)
    summary = result.summaries["DTW neighbor"]
    assert summary.accuracy(0.3).mean == pytest.approx(0.90, abs=0.06)
    assert summary.accuracy(0.5).mean == pytest.approx(0.95, abs=0.05)
    assert summary.accuracy().mean == pytest.approx(1.0, abs=0.02)
    assert summary.share.mean == pytest.approx(0.923, abs=0.03)
    methods = [row["method"] for row in result.table()]
    assert methods == ["DTW neighbor", "known: DTW neighbor", "known: dong2012", "known: phase filter"]
