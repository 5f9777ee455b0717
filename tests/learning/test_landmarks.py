"""Landmarks: shared changes of discrete signals fall on one phase; what is not shared is no landmark."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array
from pft_exec.learning import FlowTube, TubeEvent, learn_motion
from pft_exec.learning.landmarks import find_landmarks, phases_through
from tests.learning.taught import lesson


def grasping(seed: int = 0, count: int = 5) -> list[Demonstration]:
    """Demonstrations that reach, rest, close the gripper after a rest of another length each time, and lift."""
    rng = np.random.default_rng(seed)
    found = []
    for d in lesson("reach", seed, count):
        rests, lifts = (int(n) for n in rng.integers((20, 40), (70, 90)))
        closing = rests + int(rng.integers(5, 20))
        up = np.linspace(0.0, 1.0, lifts)[:, None] ** 2 * [0.0, 0.0, 0.15]
        index = np.concatenate([np.arange(len(d)), np.full(closing + lifts, len(d) - 1)])
        position = d.position[index]
        position[-lifts:] += up
        closed = (np.arange(len(index)) >= len(d) + rests).astype(int)
        assert d.quaternion is not None
        found.append(
            replace(
                d,
                time=0.02 * np.arange(len(index)),
                position=position,
                quaternion=d.quaternion[index],
                continuous={"gripper": 0.08 * np.exp(-0.2 * np.maximum(np.arange(len(index)) - len(d) - rests, 0))},
                discrete={"gripper_closed": closed},
            )
        )
    return found


def closing_times(demonstrations: list[Demonstration]) -> Array:
    return np.array([d.time[np.argmax(d.discrete["gripper_closed"])] for d in demonstrations])


def tube_of(demonstrations: list[Demonstration]) -> FlowTube:
    return learn_motion(demonstrations).flow_tube(demonstrations[0].scene)


def test_a_change_at_different_times_is_sharp_in_the_tube_and_lies_where_the_motion_rests() -> None:
    demonstrations = grasping()
    motion = learn_motion(demonstrations)
    tube = motion.flow_tube(demonstrations[0].scene)
    (event,) = tube.events()
    assert (event.name, event.value) == ("gripper_closed", 1)
    probability = tube.discrete["gripper_closed"][:, 1]
    assert set(np.round(probability, 6)) == {round(1 / 7, 6), round(6 / 7, 6)}
    times = [motion.flow_tube(d.scene).at(event.phase).time for d in demonstrations]
    assert np.mean(times) == pytest.approx(closing_times(demonstrations).mean(), abs=0.1)
    here = tube.at(event.phase)
    assert np.linalg.norm(here.position - demonstrations[0].position[119]) < 0.015


def test_a_gripper_that_closes_at_the_end_while_the_tool_rests_is_in_the_tube() -> None:
    lifted = grasping()
    stop = [len(d) - 1 - int(np.argmax(np.diff(d.position[::-1, 2]) == 0.0)) for d in lifted]
    demonstrations = [d.segment(0, n) for d, n in zip(lifted, stop, strict=True)]
    tube = tube_of(demonstrations)
    (event,) = tube.events()
    assert 0.5 < event.phase <= 1.0
    assert tube.discrete["gripper_closed"][-1, 1] > 0.8
    assert tube.continuous["gripper"][-1] < 0.045


def test_phases_that_pass_through_landmarks_are_monotone_and_meet_there() -> None:
    landmarks = np.array([[0.2, 0.6], [0.3, 0.7], [0.4, 0.5]])
    phases = phases_through(landmarks, 101)
    assert (np.diff(phases, axis=1) > 0.0).all()
    np.testing.assert_allclose(phases[:, 30], landmarks[:, 0])
    np.testing.assert_allclose(phases[:, 60], landmarks[:, 1])


def _signals(**values: list[int]) -> Demonstration:
    count = len(next(iter(values.values())))
    return Demonstration("do", np.arange(count), np.zeros((count, 3)), discrete=dict(values))


def test_signals_that_change_in_another_order_in_some_demonstration_are_no_landmarks() -> None:
    one = _signals(a=[0, 1, 1, 1, 1], b=[0, 0, 0, 1, 1])
    other = _signals(a=[0, 0, 0, 1, 1], b=[0, 1, 1, 1, 1])
    np.testing.assert_allclose(find_landmarks([one, other], ["a", "b"]), [[0.125], [0.625]])


def test_different_sequences_of_values_are_no_landmarks() -> None:
    sequences = [_signals(a=[0, 1, 1, 0, 0]), _signals(a=[0, 1, 1, 1, 1])]
    assert find_landmarks(sequences, ["a"]).shape == (2, 0)


def test_a_flicker_in_one_demonstration_hides_no_landmark() -> None:
    clean = np.repeat([0, 1], 100)
    flicker = clean.copy()
    flicker[50] = 1
    found = find_landmarks([_signals(a=list(clean)), _signals(a=list(flicker))], ["a"])
    np.testing.assert_allclose(found, [[0.5], [0.5]])


def test_signals_that_disagree_still_make_a_tube_whose_events_follow_the_majority() -> None:
    demonstrations = grasping()
    first = demonstrations[0]
    never = replace(first, discrete={"gripper_closed": np.zeros(len(first), int)})
    assert [event[1:] for event in tube_of([never, *demonstrations[1:]]).events()] == [("gripper_closed", 1)]


def test_events_are_sorted_and_lie_where_the_probabilities_cross() -> None:
    probability = {"a": np.array([[0.9, 0.1], [0.6, 0.4], [0.2, 0.8]]), "b": np.array([[0.2, 0.8], [0.8, 0.2], [1, 0]])}
    tube = FlowTube(
        "do",
        np.arange(3.0),
        np.zeros((3, 3)),
        covariance=np.tile(np.eye(3), (3, 1, 1)),
        discrete=probability,
        discrete_values={"a": np.array([3, 7]), "b": np.array([0, 1])},
    )
    assert tube.events() == [TubeEvent(0.25, "b", 0), TubeEvent(pytest.approx(0.5 + 0.5 * 0.25), "a", 7)]
    assert tube.initial_values == {"a": 3, "b": 1}


def test_a_tie_is_no_event() -> None:
    tube = FlowTube(
        "do",
        np.arange(3.0),
        np.zeros((3, 3)),
        covariance=np.tile(np.eye(3), (3, 1, 1)),
        discrete={"a": np.array([[0.6, 0.4], [0.5, 0.5], [0.6, 0.4]])},
        discrete_values={"a": np.array([0, 1])},
    )
    assert tube.events() == []
