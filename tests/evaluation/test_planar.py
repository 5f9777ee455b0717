"""The planar world: seeded, in bounds, and as hard as the paper's."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.evaluation.planar import (
    PEOPLE,
    PERIOD,
    SCENE_MOTIONS,
    SIZE,
    VARYING_MOTIONS,
    O,
    X,
    draw_scene,
    fixed_scene,
    perform,
    scene_trials,
    varying_trials,
)
from pft_exec.evaluation.tables import table1, table2


def test_same_seed_same_trials() -> None:
    for trials in (varying_trials, scene_trials):
        first, again, other = trials(3, 2), trials(3, 2), trials(4, 2)
        assert all(np.array_equal(a.position, b.position) for a, b in zip(first, again, strict=True))
        assert not np.array_equal(first[0].position, other[0].position)


def test_trials_are_those_of_the_paper() -> None:
    varying, one = varying_trials(0), scene_trials(0)
    assert {label: sum(t.label == label for t in varying) for label in VARYING_MOTIONS} == dict.fromkeys(
        VARYING_MOTIONS, 50
    )
    assert {label: sum(t.label == label for t in one) for label in SCENE_MOTIONS} == dict.fromkeys(SCENE_MOTIONS, 25)
    assert len({tuple(t.scene["bin"].position) for t in varying}) == 150
    assert len({tuple(t.scene["bin"].position) for t in one}) == 1


def test_things_lie_inside_and_apart() -> None:
    rng = np.random.default_rng(1)
    for _ in range(200):
        scene = draw_scene(rng)
        box, container = scene["box"].position[:2], scene["bin"].position[:2]
        assert (np.abs(np.array([box, container]) - SIZE / 2) <= SIZE / 2).all()
        assert min(np.linalg.norm(box - container), np.linalg.norm(box - X), np.linalg.norm(container - X)) >= 1.0


@pytest.mark.parametrize("label", SCENE_MOTIONS)
def test_motions_are_planar_evenly_sampled_and_begin_at_the_box(label: str) -> None:
    rng = np.random.default_rng(2)
    for _ in range(10):
        trial = perform(label, fixed_scene(), rng)
        assert (trial.position[:, 2] == 0.0).all()
        np.testing.assert_allclose(np.diff(trial.time), PERIOD)
        assert np.linalg.norm(trial.start.position - trial.scene["box"].position) < 5.0 * PEOPLE.start


@pytest.mark.parametrize(
    ("label", "goal"), [("to bin", [8.0, 8.0]), ("to x", X), ("anchor x, o", O), ("anchor o, x", X)]
)
def test_motions_end_near_their_goals(label: str, goal: np.ndarray) -> None:
    rng = np.random.default_rng(3)
    ends = [perform(label, fixed_scene(), rng).end.position[:2] for _ in range(50)]
    reach = 1.0 if label.startswith("anchor") else 0.3  # an anchor's loop ends beside its place
    assert np.linalg.norm(np.mean(ends, axis=0) - goal) < reach


def test_left_moves_one_unit_to_the_left_on_average() -> None:
    rng = np.random.default_rng(4)
    trials = [perform("left", draw_scene(rng), rng) for _ in range(100)]
    moved = np.mean([t.end.position - t.start.position for t in trials], axis=0)
    np.testing.assert_allclose(moved, [-1.0, 0.0, 0.0], atol=0.1)


@pytest.mark.parametrize(("label", "sign"), [("CW", -1.0), ("CCW", 1.0)])
def test_circles_turn_as_they_are_named(label: str, sign: float) -> None:
    rng = np.random.default_rng(5)
    for _ in range(10):
        path = perform(label, fixed_scene(), rng).position[:, :2]
        x, y = (path - path.mean(axis=0)).T
        area = 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
        assert sign * area > 1.0


@pytest.mark.parametrize("label", ["anchor x, o", "anchor o, x"])
def test_anchors_are_laid_round_both_places(label: str) -> None:
    """Most of them: people are careless, but not blind."""
    rng = np.random.default_rng(7)
    paths = [perform(label, fixed_scene(), rng).position[:, :2] for _ in range(200)]
    around = [min(_turns(path, place) for place in (X, O)) > 0.5 for path in paths]
    assert np.mean(around) > 0.8


def _turns(path: np.ndarray, place: np.ndarray) -> float:
    """How often a path (N, 2) goes round a place (2,), counter-clockwise."""
    x, y = (path - place).T
    angle = np.unwrap(np.arctan2(y, x))
    return float(angle[-1] - angle[0]) / (2.0 * np.pi)


def test_a_carried_box_goes_with_the_hand() -> None:
    trial = perform("to bin", fixed_scene(), np.random.default_rng(6))
    offset = trial.objects["box"][:, :3] - trial.position
    np.testing.assert_allclose(offset, offset[:1].repeat(len(trial), axis=0), atol=1e-12)
    assert perform("CW", fixed_scene(), np.random.default_rng(6)).objects["box"].shape == (7,)


@pytest.mark.slow
def test_the_people_are_as_hard_as_the_papers_for_the_papers_baseline() -> None:
    """The better topology of the hidden Markov model comes within 8 points of the published 55 and 78 %."""
    both = ("HMM, left to right", "HMM, ergodic")
    for table, seeds, methods, published in ((table1, 3, both, 0.55), (table2, 1, both[:1], 0.78)):
        result = table(seeds, methods)
        better = max(summary.accuracy().mean for summary in result.summaries.values())
        assert abs(better - published) <= 0.08
