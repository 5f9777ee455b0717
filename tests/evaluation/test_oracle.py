"""The recognizer that knows the simulated people: its hand is theirs, its posterior right, its future unknown."""

from __future__ import annotations

import inspect
from dataclasses import replace

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.evaluation import tables
from pft_exec.evaluation.baselines.oracle import TIMES, Oracle, _places, know_people
from pft_exec.evaluation.baselines.planar_hand import ANCHOR, GOAL, LEFT, LOOP, lay_waypoints, place_hand
from pft_exec.evaluation.planar import PEOPLE, SCENE_MOTIONS, VARYING_MOTIONS, X, draw_scene, perform
from pft_exec.geometry import Array

# Of the normal draws of a trial, in their order, those that lay its waypoints, and how many the waypoints take in all.
OWN_DRAWS = {GOAL: ((1,), 2), LEFT: ((1, 2), 3), LOOP: ((2, 3, 4), 5), ANCHOR: (tuple(range(2, 14)), 14)}
KINDS = {
    "to bin": GOAL,
    "to x": GOAL,
    "left": LEFT,
    "CW": LOOP,
    "CCW": LOOP,
    "anchor x, o": ANCHOR,
    "anchor o, x": ANCHOR,
}


class Recorded:
    """A generator that remembers what it drew."""

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self.drawn: list[Array] = []

    def __getattr__(self, name: str):
        def draw(*arguments):
            drawn = getattr(self._rng, name)(*arguments)
            if name != "uniform":
                self.drawn.append(np.asarray(drawn))
            return drawn

        return draw


@pytest.mark.parametrize("label", SCENE_MOTIONS)
def test_its_hand_is_that_of_the_people(label: str) -> None:
    """From the chances of a trial, drawn by `planar.perform` itself, to its positions; a third of the trials pauses."""
    people, style = replace(PEOPLE, tremor=0.0), PEOPLE.style
    scatter = np.array([people.goal, people.reach, people.loop, people.bow])
    hand = np.array([style.overlap, style.bow, style.pace, *style.pause])
    which, taken = OWN_DRAWS[KINDS[label]]
    for seed in range(40):
        rng, scene = Recorded(seed), draw_scene(np.random.default_rng([seed, 1]))
        trial = perform(label, scene, rng, people)  # type: ignore[arg-type]
        own = np.concatenate([np.ravel(rng.drawn[i]) for i in which])
        pace, bows, pause = rng.drawn[taken], rng.drawn[taken + 3][:, :2], rng.drawn[-1]
        start, places, points = trial.position[0, :2], _places(label, trial), np.zeros((21, 2))
        count = lay_waypoints(KINDS[label], start, places, scatter, own, points)
        x, y = points[count - 1] - points[0]
        z = np.concatenate([[pace], bows @ [-y, x] / np.hypot(x, y), pause[1:], own])
        path = np.zeros((len(trial), 3))
        pausing = bool(pause[0] < people.pause_probability)
        place_hand(KINDS[label], start, places, scatter, hand, pausing, z, trial.time, path)
        np.testing.assert_allclose(path[:, :2], trial.position[:, :2], atol=1e-10)


def _trials(count: int, seed: int) -> list[Demonstration]:
    rng = np.random.default_rng([seed, 7])
    return [perform(label, draw_scene(rng), rng) for label in VARYING_MOTIONS for _ in range(count)]


def test_at_the_end_it_says_what_the_law_of_the_goals_says() -> None:
    """The three motions differ in their goals alone, and the last sample is the goal: its density decides."""
    oracle, worst = Oracle(VARYING_MOTIONS), 0.0
    for trial in _trials(5, 1):
        start, goal = trial.position[0, :2], trial.position[-1, :2]
        density = {
            "to bin": _normal(goal - trial.scene["bin"].position[:2], PEOPLE.goal),
            "to x": _normal(goal - X, PEOPLE.goal),
            "left": _left(goal - start),
        }
        expected = density[trial.label] / sum(density.values())
        found = oracle.recognize(trial).probability[-1, VARYING_MOTIONS.index(trial.label)]
        worst = max(worst, abs(found - expected))
    assert worst < 0.06


def _normal(offset: Array, deviation: float) -> Array:
    """Densities of offsets (..., 2)."""
    density: Array = np.exp(-0.5 * np.sum(offset**2, axis=-1) / deviation**2) / (2.0 * np.pi * deviation**2)
    return density


def _left(moved: Array) -> Array:
    """Mean over many lengths of the move."""
    lengths = np.exp(PEOPLE.reach * np.random.default_rng(0).standard_normal(20_000))
    ends = np.stack([-lengths, np.zeros(len(lengths))], axis=1)
    return _normal(moved - ends, 0.3 * PEOPLE.goal).mean()


def test_it_does_not_look_ahead() -> None:
    """A recording cut in half is judged at its end as the whole one is there, but for what is left to chance."""
    trial = next(trial for trial in _trials(5, 2) if len(trial) >= 2 * TIMES)
    whole = Oracle(VARYING_MOTIONS).recognize(trial)
    half = int(np.ceil(0.5 * len(trial) - 1e-9))
    cut = Oracle(VARYING_MOTIONS).recognize(trial.segment(0, half))
    np.testing.assert_allclose(cut.probability[-1], whole.probability[half - 1], atol=0.05)


def test_it_takes_from_demonstrations_their_names_alone() -> None:
    trials = _trials(2, 3)
    assert know_people(trials).labels == VARYING_MOTIONS


@pytest.mark.slow
def test_its_posterior_is_calibrated() -> None:
    """Of all answers along 45 fresh trials: as often right as sure, to 6 % in bins together and 3 % in the mean."""
    oracle = Oracle(VARYING_MOTIONS)
    sure, right = [], []
    for trial in _trials(15, 4):
        trace = oracle.recognize(trial)
        sure.append(trace.probability.max(axis=1))
        right.append(np.array(trace.leading) == trial.label)
    confidence, hits = np.concatenate(sure), np.concatenate(right)
    bins = np.minimum((10 * confidence).astype(int), 9)
    gaps = [np.mean(bins == b) * abs(confidence[bins == b].mean() - hits[bins == b].mean()) for b in np.unique(bins)]
    assert np.sum(gaps) < 0.06
    assert abs(confidence.mean() - hits.mean()) < 0.03
    assert np.mean([row[-1] for row in right]) > 0.95


def test_table_1_has_a_row_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here of six trials."""
    monkeypatch.setattr(tables, "TRAINED", 48)
    row = tables.table1(1, [tables.ORACLE]).table()[0]
    assert row["method"] == tables.ORACLE
    assert float(row["end"]) > 80.0
    assert tables.ORACLE in inspect.signature(tables.table1).parameters["methods"].default
