"""Synthetic people move smoothly, a little differently each time, and end where they mean to."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.demonstration.synthetic import STEADY, HumanPath, HumanStyle, human_path, minimum_jerk
from pft_exec.exceptions import InvalidDemonstrationError
from pft_exec.geometry import geodesic_distance, quaternion_from_rotation_vector

POSITIONS = np.array([[0.5, -0.4, 1.0], [0.5, -0.3, 0.9], [0.6, -0.2, 0.85]])
QUATERNIONS = quaternion_from_rotation_vector(np.array([[0.0, 0.0, 1.2], [0.1, 0.0, 1.0], [0.0, -0.3, 0.8]]))
DURATIONS = (1.4, 1.1)


def _path(seed: int, style: HumanStyle | None = None) -> HumanPath:
    return human_path(POSITIONS, QUATERNIONS, DURATIONS, np.random.default_rng(seed), style)


def test_a_steady_hand_makes_the_minimum_jerk_path() -> None:
    """10 u^3 - 15 u^4 + 6 u^5 of [Flash1985]_, against the closed form."""
    path = human_path(POSITIONS[:2], None, [2.0], np.random.default_rng(0), STEADY)
    u = np.linspace(0.0, 1.0, 41)
    position, quaternion = path.at(2.0 * u)
    share = 10 * u**3 - 15 * u**4 + 6 * u**5
    np.testing.assert_allclose(position, POSITIONS[0] + share[:, None] * (POSITIONS[1] - POSITIONS[0]), atol=1e-12)
    np.testing.assert_array_equal(quaternion, np.tile([0.0, 0.0, 0.0, 1.0], (41, 1)))


def test_a_steady_hand_without_overlap_stops_at_each_waypoint() -> None:
    path = _path(0, STEADY)
    position, quaternion = path.at([0.0, 1.4, 2.5])
    np.testing.assert_allclose(position, POSITIONS, atol=1e-12)
    assert geodesic_distance(quaternion, QUATERNIONS).max() < 1e-7
    speed = np.linalg.norm(path.at(1.4 + 1e-4)[0] - path.at(1.4 - 1e-4)[0]) / 2e-4
    assert speed < 1e-4


def test_a_human_hand_runs_through_waypoints_without_a_stop() -> None:
    path = _path(0, HumanStyle(pause_probability=0.0))
    time, position, _ = path.sample(0.01)
    speed = np.linalg.norm(np.gradient(position, time, axis=0), axis=1)
    middle = speed[(time > 0.3 * path.duration) & (time < 0.7 * path.duration)]
    assert middle.min() > 0.4 * speed.max()


@pytest.mark.parametrize("seed", range(8))
def test_position_velocity_and_acceleration_are_continuous_and_rest_at_both_ends(seed: int) -> None:
    path = _path(seed, HumanStyle(pause_probability=1.0))
    time = np.arange(-0.1, path.duration + 0.1, 1e-3)
    position, quaternion = path.at(time)
    assert np.abs(np.linalg.norm(quaternion, axis=1) - 1.0).max() < 1e-12
    velocity = np.diff(position, axis=0) / 1e-3
    acceleration = np.diff(velocity, axis=0) / 1e-3
    assert np.abs(velocity[:100]).max() < 1e-4
    assert np.abs(velocity[-95:]).max() < 1e-4
    assert np.abs(np.diff(acceleration, axis=0)).max() < 0.25, "a jump would be as large as the acceleration itself"
    turned = np.linalg.norm(np.diff(quaternion, axis=0), axis=1) / 1e-3
    assert np.abs(np.diff(turned)).max() < 0.02


def test_the_path_begins_exactly_at_the_first_waypoint_and_ends_near_the_last() -> None:
    ends = [_path(seed).at(100.0) for seed in range(200)]
    firsts = [_path(seed).at(0.0) for seed in range(20)]
    for position, quaternion in firsts:
        np.testing.assert_allclose(position, POSITIONS[0], atol=1e-12)
        assert geodesic_distance(quaternion, QUATERNIONS[0]) < 1e-7
    distance = np.array([np.linalg.norm(position - POSITIONS[-1]) for position, _ in ends])
    angle = np.array([geodesic_distance(quaternion, QUATERNIONS[-1]) for _, quaternion in ends])
    assert np.sqrt(np.mean(distance**2)) == pytest.approx(1.5e-3 * np.sqrt(3.0), rel=0.15)
    assert np.sqrt(np.mean(angle**2)) == pytest.approx(0.012 * np.sqrt(3.0), rel=0.15)


def test_durations_spread_by_the_pace() -> None:
    style = HumanStyle(pause_probability=0.0)
    logarithms = np.log([_path(seed, style).duration / sum(DURATIONS) for seed in range(400)])
    assert np.mean(logarithms) == pytest.approx(0.0, abs=0.03)
    assert np.std(logarithms) == pytest.approx(0.12, rel=0.15)


def test_a_pause_costs_its_time_and_nearly_stops_the_hand() -> None:
    style = HumanStyle(pace=0.0, tremor=0.0, pause_probability=1.0, pause=(0.3, 0.3))
    path = _path(3, style)
    assert path.duration == pytest.approx(sum(DURATIONS) + 0.3)
    speed = np.linalg.norm(path.at(path.pause_at + 1e-3)[0] - path.at(path.pause_at - 1e-3)[0]) / 2e-3
    assert speed < 0.01


def test_pauses_come_as_often_as_stated() -> None:
    share = np.mean([_path(seed).pause_cost > 0.0 for seed in range(400)])
    assert share == pytest.approx(0.3, abs=0.06)


def test_tremor_is_below_a_millimeter_and_in_its_band() -> None:
    still = HumanStyle(bow=0.0, wobble=0.0, pace=0.0, pause_probability=0.0, end_error=0.0, end_angle=0.0)
    bare = HumanStyle(
        bow=0.0, wobble=0.0, pace=0.0, pause_probability=0.0, tremor=0.0, tremor_angle=0.0, end_error=0.0, end_angle=0.0
    )
    time = np.arange(0.0, 2.5, 1e-3)
    shaking = _path(5, still).at(time)[0] - _path(5, bare).at(time)[0]
    assert 5e-5 < np.std(shaking) < 3e-4
    assert np.abs(shaking).max() < 1e-3
    power = np.abs(np.fft.rfft(shaking[:, 0])) ** 2
    rates = np.fft.rfftfreq(len(time), 1e-3)
    inside = (rates > 7.0) & (rates < 13.0)
    assert power[inside].sum() > 0.95 * power.sum()


def test_each_path_bows_by_its_own_amount_sideways() -> None:
    style = HumanStyle(pause_probability=0.0, end_error=0.0, tremor=0.0, overlap=0.0)
    direct = human_path(POSITIONS[:2], None, [2.0], np.random.default_rng(0), STEADY)
    deviations = []
    for seed in range(60):
        path = human_path(POSITIONS[:2], None, [2.0], np.random.default_rng(seed), style)
        deviations.append(path.at(0.5 * path.duration)[0] - direct.at(1.0)[0])
    length = np.linalg.norm(POSITIONS[1] - POSITIONS[0])
    along = np.array(deviations) @ (POSITIONS[1] - POSITIONS[0]) / length
    np.testing.assert_allclose(along, 0.0, atol=1e-12)
    assert np.std(deviations) == pytest.approx(0.04 * length * np.sqrt(2.0 / 3.0), rel=0.25)


def test_the_same_generator_gives_the_same_path_and_another_gives_another() -> None:
    time = np.linspace(0.0, 2.0, 11)
    np.testing.assert_array_equal(_path(4).at(time)[0], _path(4).at(time)[0])
    assert np.abs(_path(4).at(time)[0] - _path(5).at(time)[0]).max() > 1e-3


def test_a_planar_path_stays_in_the_plane_and_does_not_turn() -> None:
    flat = POSITIONS * [1.0, 1.0, 0.0]
    path = human_path(flat, None, DURATIONS, np.random.default_rng(0), planar=True)
    _, position, quaternion = path.sample(0.01)
    np.testing.assert_array_equal(position[:, 2], 0.0)
    np.testing.assert_array_equal(quaternion, np.tile([0.0, 0.0, 0.0, 1.0], (len(position), 1)))


def test_a_closed_path_bows_without_a_direction_of_its_own() -> None:
    closed = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 0.0]])
    path = human_path(closed, None, DURATIONS, np.random.default_rng(0))
    assert np.isfinite(path.sample(0.01)[1]).all()


def test_samples_are_even_and_include_both_ends() -> None:
    path = _path(2)
    time, position, quaternion = path.sample(0.01)
    assert time[0] == 0.0
    assert time[-1] == path.duration
    assert (np.diff(time) > 0.004).all()
    assert position.shape == (len(time), 3)
    assert quaternion.shape == (len(time), 4)


def test_minimum_jerk_is_clipped_outside_the_motion() -> None:
    np.testing.assert_array_equal(minimum_jerk([-1.0, 0.0, 0.5, 1.0, 2.0]), [0.0, 0.0, 0.5, 1.0, 1.0])


@pytest.mark.parametrize(
    ("positions", "quaternions", "durations", "message"),
    [
        (POSITIONS[:1], None, [], r"W >= 2 positions"),
        (POSITIONS[:, :2], None, DURATIONS, r"\(W, 3\)"),
        (POSITIONS, QUATERNIONS[:2], DURATIONS, r"quaternions \(W, 4\)"),
        (POSITIONS, None, [1.0], r"durations \(W - 1,\)"),
        (POSITIONS, None, [1.0, 0.0], r"above 0 s"),
        (POSITIONS * np.nan, None, DURATIONS, r"finite"),
    ],
)
def test_waypoints_that_make_no_path_are_refused(
    positions: np.ndarray, quaternions: np.ndarray | None, durations: list[float], message: str
) -> None:
    with pytest.raises(InvalidDemonstrationError, match=message):
        human_path(positions, quaternions, durations, np.random.default_rng(0))


CIRCLE = np.array([[np.cos(a) - 1.0, np.sin(a), 0.0] for a in np.linspace(0.0, 2.0 * np.pi, 401)]) * 0.04


def test_a_curve_follows_the_waypoints_and_comes_back_to_the_last() -> None:
    path = human_path(
        POSITIONS, QUATERNIONS, DURATIONS, np.random.default_rng(0), STEADY, curve=CIRCLE, curve_duration=2.0
    )
    assert path.duration == pytest.approx(sum(DURATIONS) + 2.0)
    half = path.at(path.arrivals[-1] + 1.0)[0]
    assert np.allclose(half, np.asarray(POSITIONS[-1]) + CIRCLE[200], atol=1e-6)
    assert np.allclose(path.at(path.duration)[0], POSITIONS[-1], atol=1e-9)


def test_a_curve_alone_begins_where_the_hand_is() -> None:
    path = human_path(
        POSITIONS[:1], QUATERNIONS[:1], [], np.random.default_rng(0), STEADY, curve=CIRCLE, curve_duration=2.0
    )
    assert path.duration == pytest.approx(2.0)
    assert np.allclose(path.at(0.0)[0], POSITIONS[0])
    assert np.allclose(path.at(1.0)[0], np.asarray(POSITIONS[0]) + CIRCLE[200], atol=1e-6)


def test_a_hand_that_rests_stands_still_and_arrives_when_it_says() -> None:
    rests = np.zeros(len(DURATIONS))
    rests[0] = 0.8
    path = human_path(POSITIONS, QUATERNIONS, DURATIONS, np.random.default_rng(2), rests=rests)
    begin = float(path.arrivals[0])
    during = path.at(np.linspace(begin + 0.05, begin + 0.7, 20))[0]
    still = path.pause_cost == 0.0
    assert np.ptp(during, axis=0).max() < (2e-3 if still else 5e-3)
    assert np.linalg.norm(during.mean(axis=0) - np.asarray(POSITIONS[1])) < 5e-3
