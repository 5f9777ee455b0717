"""Pacing: a longer way takes longer, but less than in proportion; rests and turns in place take as long as ever."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.geometry import Pose
from pft_exec.learning import learn_motion
from pft_exec.learning.pacing import Pacing, learn_pacing, path_lengths


def walks(lengths: list[float], exponent: float, rest: int = 0) -> list[Demonstration]:
    """Straight ways to a target, of durations that go with a power of their lengths, and a rest at the end."""
    found = []
    for length in lengths:
        count = round(100 * length**exponent)
        share = np.linspace(0.0, 1.0, count)
        x = np.append(length * (3.0 * share**2 - 2.0 * share**3), np.full(rest, length))
        place = np.stack([x, 0.01 * np.sin(3.0 * x), np.zeros(len(x))], axis=1)
        target = Pose(np.array([length, 0.0, 0.0]))
        found.append(Demonstration("go", 0.02 * np.arange(len(x)), place, objects={"target": target.array}))
    return found


def duration_in(demonstrations: list[Demonstration], length: float) -> float:
    scene = Scene({"target": Pose(np.array([length, 0.0, 0.0]))})
    return learn_motion(demonstrations).flow_tube(scene, Pose(np.zeros(3))).duration


@pytest.mark.parametrize("exponent", [0.3, 0.5, 0.7])
def test_the_tube_of_a_nearer_or_farther_target_takes_the_time_that_the_demonstrations_show(exponent: float) -> None:
    demonstrations = walks([0.5, 0.7, 1.0, 1.4, 2.0], exponent)
    for length in (0.4, 1.0, 2.5):
        assert duration_in(demonstrations, length) == pytest.approx(2.0 * length**exponent, rel=0.2)


def test_in_the_scene_of_all_demonstrations_the_duration_is_their_mean() -> None:
    demonstrations = walks([1.0] * 4, 0.5)
    assert duration_in(demonstrations, 1.0) == pytest.approx(demonstrations[0].duration, rel=1e-3)


def test_time_never_goes_back_and_a_rest_is_as_long_in_any_scene() -> None:
    position = np.zeros((2, 7, 3))
    position[:, :, 0] = [0.0, 1.0, 2.0, 2.0, 2.0, 3.0, 4.0]
    pacing = Pacing(np.array([4.0, 4.0]), np.array([1.0, 1.0, 0.0, 0.0, 1.0, 1.0]), 0.5)
    time = np.tile(np.arange(7.0), (2, 1))
    longer = pacing.carried(time, 4.0 * position[0])
    np.testing.assert_allclose(longer[0], [0.0, 2.0, 4.0, 5.0, 6.0, 8.0, 10.0])


def test_a_tool_that_only_turns_keeps_its_times() -> None:
    position, time = np.zeros((3, 5, 3)), np.tile(np.arange(5.0), (3, 1))
    pacing = learn_pacing(position, position, time)
    np.testing.assert_allclose(pacing.carried(time, position[0]), time)
    np.testing.assert_allclose(path_lengths(position), 0.0)


def test_the_exponent_stays_between_equal_times_and_equal_speeds() -> None:
    position = np.zeros((3, 11, 3))
    position[:, :, 0] = np.array([[1.0], [2.0], [4.0]]) * np.linspace(0.0, 1.0, 11)
    for power in (-1.0, 3.0):
        time = np.array([[1.0], [2.0**power], [4.0**power]]) * np.linspace(0.0, 1.0, 11)
        assert 0.0 <= learn_pacing(position, position, time).exponent <= 1.0


def test_a_shorter_way_is_bowed_less_but_its_ends_scatter_as_ever() -> None:
    straight = np.zeros((11, 3))
    straight[:, 0] = np.linspace(0.0, 1.0, 11)
    residual = np.zeros((2, 11, 3))
    residual[:, :, 1] = 0.2 + 0.1 * np.sin(np.pi * np.linspace(0.0, 1.0, 11))
    pacing = Pacing(np.array([1.0, 1.0]), np.ones(10), 0.5)
    np.testing.assert_allclose(pacing.bowed(residual, straight), residual)
    short = pacing.bowed(residual, 0.25 * straight)
    np.testing.assert_allclose(short[:, [0, -1], 1], 0.2)
    np.testing.assert_allclose(short[:, 5, 1], 0.25)
