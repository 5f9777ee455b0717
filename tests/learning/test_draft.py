"""Drafts: people who rest at different places are brought in step, and those who keep time are left alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.geometry import Array
from pft_exec.learning import learn_motion
from pft_exec.learning.alignment import STEPS, calmed

CORNERS = np.array([[0.0, 0.0, 0.0], [0.1, 0.25, 0.0], [0.2, 0.0, 0.0], [0.3, 0.25, 0.0]])
PERIOD = 0.01


def zigzag(duration: float, rests: Sequence[tuple[float, float]], rng: np.random.Generator) -> Demonstration:
    """From corner to corner in minimum-jerk strokes, with rests (share of the time, s), somewhere within 3 mm."""
    place = np.arange(0.0, duration, PERIOD) / duration * (len(CORNERS) - 1)
    stroke = np.minimum(place.astype(int), len(CORNERS) - 2)
    s = (place - stroke)[:, None]
    path = CORNERS[stroke] + (CORNERS[stroke + 1] - CORNERS[stroke]) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    for share, rest in rests:
        k = int(share * len(path))
        path = np.insert(path, k, np.repeat(path[k : k + 1], round(rest / PERIOD), axis=0), axis=0)
    path = path + rng.normal(0.0, 0.003, 3)
    return Demonstration("zigzag", PERIOD * np.arange(len(path)), path)


def missed(demonstrations: Sequence[Demonstration]) -> Array:
    """How far the tube stays from each corner, m."""
    tube = learn_motion(demonstrations).flow_tube(Scene(), demonstrations[0].start)
    there = CORNERS + np.mean([demonstration.position[0] for demonstration in demonstrations], axis=0)
    least: Array = np.linalg.norm(there[:, None] - tube.position, axis=2).min(axis=1)
    return least


RESTS = ([(0.2, 0.5)], [(0.45, 0.8)], [(0.7, 0.6)], [], [(0.9, 0.4)])


@pytest.mark.parametrize("seed", range(3))
def test_the_mean_of_people_who_rest_at_different_places_passes_the_corners(seed: int) -> None:
    rng = np.random.default_rng(seed)
    demonstrations = [zigzag(rng.uniform(2.1, 2.9), rests, rng) for rests in RESTS]
    assert missed(demonstrations).max() < 0.008


def test_people_who_rest_alike_keep_the_rest_in_the_tube() -> None:
    rng = np.random.default_rng(0)
    demonstrations = [zigzag(2.5, [(0.5, 1.0)], rng) for _ in range(5)]
    tube = learn_motion(demonstrations).flow_tube(Scene(), demonstrations[0].start)
    slow = np.linalg.norm(np.diff(tube.position, axis=0), axis=1) < 2e-4
    assert np.diff(tube.time)[slow].sum() == pytest.approx(1.0, abs=0.15)


def test_an_alignment_is_calmed_but_at_its_ends_and_landmarks() -> None:
    rng = np.random.default_rng(0)
    steps = np.linspace(0.0, 1.0, STEPS)
    passed = (np.arange(STEPS) >= 40).astype(float)
    warped = np.sort(np.clip(steps + 0.05 * rng.uniform(-1.0, 1.0, (3, STEPS)), 0.0, 1.0), axis=1)
    warped[:, 0], warped[:, -1] = 0.0, 1.0
    calm = calmed(warped, passed)
    kept = [0, 39, 40, STEPS - 1]
    np.testing.assert_allclose(calm[:, kept], warped[:, kept], atol=1e-12)
    assert np.all(np.diff(calm, axis=1) >= 0.0)
    assert np.abs(np.diff(calm, 2, axis=1)).mean() < 0.3 * np.abs(np.diff(warped, 2, axis=1)).mean()
