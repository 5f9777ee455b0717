"""Tempo: what it takes from the demonstrations, and what it leaves alone."""

from __future__ import annotations

import numpy as np

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.demonstration.synthetic import minimum_jerk
from pft_exec.geometry import Array, Pose
from pft_exec.learning import learn_motion
from pft_exec.learning.tempo import EVEN, find_tempo, way_passed

STEPS = 100
PHASE = np.linspace(0.0, 1.0, STEPS)
WHOLE = np.array([0, STEPS - 1])


def _line(share: Array, length: float = 1.0) -> Array:
    """Paths (1, N, 3) along x, m."""
    return length * np.stack([share, 0.0 * share, 0.0 * share], axis=-1)[None]


def test_a_path_is_passed_in_the_tempo_of_the_demonstrations_whatever_its_own() -> None:
    shown = np.concatenate([_line(minimum_jerk(PHASE), length) for length in (0.5, 1.0, 2.0)])
    tempo = find_tempo(shown, None, np.zeros(STEPS), 0.0)
    paced, _ = tempo.given_to(_line(PHASE**2, 3.0), None, leave_out=False)
    np.testing.assert_allclose(paced[0, :, 0], 3.0 * minimum_jerk(PHASE), atol=0.03 + EVEN * 3.0)
    np.testing.assert_allclose(paced[0, [0, -1], 0], [0.0, 3.0], atol=1e-9)


def test_each_demonstration_has_the_tempo_of_the_others_where_it_is_left_out() -> None:
    shown = np.concatenate([_line(PHASE), _line(PHASE), _line(PHASE**2)])
    paced, _ = find_tempo(shown, None, np.zeros(STEPS), 0.0).given_to(shown, None, leave_out=True)
    np.testing.assert_allclose(paced[2, :, 0], PHASE, atol=0.02)
    assert np.abs(paced[0, :, 0] - 0.5 * (PHASE + PHASE**2)).max() < 0.02


def test_a_landmark_stays_where_the_path_has_it() -> None:
    passed = (np.arange(STEPS) >= 50).astype(float)
    tempo = find_tempo(np.concatenate([_line(minimum_jerk(PHASE)), _line(PHASE)]), None, passed, 0.0)
    path = _line(PHASE**2)
    paced, _ = tempo.given_to(path, None, leave_out=False)
    np.testing.assert_allclose(paced[0, 50], path[0, 50], atol=1e-9)


def test_a_turn_in_place_is_way_too() -> None:
    turn = np.stack([0.0 * PHASE, 0.0 * PHASE, np.sin(0.5 * PHASE**2), np.cos(0.5 * PHASE**2)], axis=-1)[None]
    passed = way_passed(_line(0.0 * PHASE), turn, WHOLE, 1.0)
    np.testing.assert_allclose(passed[0], (1.0 - EVEN) * PHASE**2 + EVEN * PHASE, atol=1e-3)


def test_what_never_moves_passes_evenly() -> None:
    np.testing.assert_allclose(way_passed(_line(0.0 * PHASE), None, WHOLE, 0.0)[0], PHASE)


def test_tremor_in_a_long_rest_is_no_reason_to_creep_through_it() -> None:
    rng = np.random.default_rng(3)
    rested = np.interp(PHASE, [0.0, 0.2, 0.8, 1.0], [0.0, 0.5, 0.5, 1.0])
    demonstrations = []
    for _ in range(5):
        goal = np.array([1.0, 0.0, 0.0]) + rng.uniform(-0.1, 0.1, 3)
        path = rested[:, None] * goal + rng.normal(0.0, 0.001, (STEPS, 3))
        demonstrations.append(
            Demonstration("rest", time=4.0 * PHASE, position=path, objects={"goal": Pose(goal).array})
        )
    tube = learn_motion(demonstrations).flow_tube(Scene({"goal": Pose([1.0, 0.0, 0.0])}), Pose([0.0, 0.0, 0.0]))
    middle = (tube.time > 0.25 * tube.duration) & (tube.time < 0.75 * tube.duration)
    assert np.ptp(tube.position[middle, 0]) < 0.03
