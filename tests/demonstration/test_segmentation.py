"""Segmentation: pieces that join without a gap, and idle ends that are found and nothing else."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from pft_exec.demonstration import (
    Demonstration,
    discrete_changes,
    moving_range,
    split_at_discrete_changes,
    split_at_keyframes,
    without_idle_ends,
)


def minimum_jerk(count: int) -> Any:
    s = np.linspace(0.0, 1.0, count)
    return 10 * s**3 - 15 * s**4 + 6 * s**5


def moving(count: int = 100, before: int = 0, after: int = 0, **fields: Any) -> Demonstration:
    progress = np.concatenate([np.zeros(before), minimum_jerk(count), np.ones(after)])
    time = 0.01 * np.arange(len(progress))
    return Demonstration("reach", time, np.outer(progress, [0.3, 0.1, 0.0]), **fields)


def test_pieces_between_keyframes_share_their_ends() -> None:
    demonstration = moving(keyframes=(0.3, 0.6))
    pieces = split_at_keyframes(demonstration)
    assert [piece.label for piece in pieces] == ["reach/1", "reach/2", "reach/3"]
    for first, second in pairwise(pieces):
        np.testing.assert_array_equal(first.position[-1], second.position[0])
    np.testing.assert_array_equal(pieces[0].position[0], demonstration.position[0])
    np.testing.assert_array_equal(pieces[-1].position[-1], demonstration.position[-1])
    assert sum(len(piece) for piece in pieces) == len(demonstration) + 2


def test_without_keyframes_or_changes_the_demonstration_is_returned() -> None:
    demonstration = moving(discrete={"closed": np.zeros(100, int)})
    assert split_at_keyframes(demonstration) == [demonstration]
    assert split_at_discrete_changes(demonstration) == [demonstration]


def test_keyframes_closer_than_a_sample_make_one_cut() -> None:
    assert len(split_at_keyframes(moving(keyframes=(0.301, 0.302)))) == 2


def test_cuts_where_any_discrete_signal_changes() -> None:
    closed = (np.arange(100) >= 40).astype(int)
    power = (np.arange(100) >= 70).astype(int)
    demonstration = moving(discrete={"closed": closed, "power": power})
    np.testing.assert_array_equal(discrete_changes(demonstration), [40, 70])
    pieces = split_at_discrete_changes(demonstration)
    assert [len(piece) for piece in pieces] == [41, 31, 30]


@pytest.mark.parametrize(("before", "after"), [(0, 0), (50, 0), (0, 80), (200, 30)])
def test_finds_the_motion_between_idle_ends(before: int, after: int) -> None:
    start, stop = moving_range(moving(before=before, after=after))
    assert abs(start - before) <= 12  # a minimum-jerk motion starts below the speed that counts
    assert abs(stop - (before + 100)) <= 12


def test_tremor_at_rest_is_still_idle() -> None:
    generator = np.random.default_rng(5)
    still = moving(before=100, after=100)
    shaking = Demonstration("reach", still.time, still.position + 1e-5 * generator.normal(size=still.position.shape))
    start, stop = moving_range(shaking)
    assert 85 <= start <= 120
    assert 180 <= stop <= 215


def test_a_turn_on_the_spot_is_motion() -> None:
    angle = 0.5 * minimum_jerk(100)
    quaternion = np.stack([0 * angle, 0 * angle, np.sin(angle / 2), np.cos(angle / 2)], axis=1)
    turn = Demonstration("turn", 0.01 * np.arange(100), np.zeros((100, 3)), quaternion)
    start, stop = moving_range(turn)
    assert stop - start > 75


def test_what_never_moves_is_all_motion() -> None:
    still = Demonstration("hold", [0.0, 1.0, 2.0], np.zeros((3, 3)))
    assert moving_range(still) == (0, 3)


def test_two_samples_stay_two() -> None:
    short = Demonstration("hop", [0.0, 1.0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert moving_range(short) == (0, 2)


def test_times_stay_as_recorded_without_idle_ends() -> None:
    demonstration = moving(before=50, after=50)
    trimmed = without_idle_ends(demonstration)
    assert trimmed.time[0] == demonstration.time[moving_range(demonstration)[0]]
    np.testing.assert_allclose(trimmed.position[-1], demonstration.position[-1], atol=1e-3)


def test_a_gripper_that_closes_while_the_tool_rests_is_no_idleness() -> None:
    closed = (np.arange(300) >= 250).astype(int)
    width = np.interp(np.arange(300), [250, 262], [0.08, 0.02])
    assert moving_range(moving(before=100, after=100, discrete={"closed": closed}))[1] == 251
    start, stop = moving_range(moving(before=100, after=100, continuous={"width": width}))
    assert abs(start - 100) <= 12
    assert 258 <= stop <= 266


def test_what_settles_between_the_pads_while_the_tool_rests_is_idleness() -> None:
    """A gripper's width in m: a held thing gives way by a fifth of a millimetre, and a reading jumps at its first."""
    settling = np.interp(np.arange(300), [5, 30], [0.0593, 0.0595])
    empty = np.where(np.arange(300) == 0, 0.0, 2e-5) + 1e-6 * np.random.default_rng(2).normal(size=300)
    for width in (settling, empty):
        start, _ = moving_range(moving(before=100, after=100, continuous={"width": width}))
        assert abs(start - 100) <= 12


def test_a_switch_before_the_motion_belongs_to_it_with_the_value_before() -> None:
    opened = (np.arange(300) < 40).astype(int)
    demonstration = without_idle_ends(moving(before=100, after=100, discrete={"closed": opened}))
    np.testing.assert_array_equal(demonstration.discrete["closed"][:2], [1, 0])


@pytest.mark.parametrize("amount", [0.0, 0.01])
def test_a_noisy_signal_and_a_steady_drift_are_idle(amount: float) -> None:
    generator = np.random.default_rng(3)
    warming = np.linspace(20.0, 21.0, 300) + amount * generator.normal(size=300)
    noise = generator.normal(size=300)
    start, stop = moving_range(moving(before=100, after=100, continuous={"temperature": warming, "noise": noise}))
    assert abs(start - 100) <= 12
    assert abs(stop - 200) <= 12
