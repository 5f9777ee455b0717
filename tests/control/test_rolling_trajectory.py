"""The rolling trajectory: however it is extended it is one smooth path, the same as at once, and says what it lacks."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control import RollingTrajectory, TakenUp, plan_joint_trajectory, smooth_tube
from pft_exec.exceptions import ControlError
from tests.control.plant import arch


@pytest.fixture(scope="module")
def tube(arm, start):
    return smooth_tube(arch(arm, start, 2.0, 60), arm.forward(start).quaternion)


def states(reference, until):
    times = np.arange(0.0, until, 1e-3)
    return [
        np.array(part)
        for part in zip(*((r.configuration, r.velocity, r.acceleration) for r in map(reference, times)), strict=True)
    ]


def test_extended_by_a_few_samples_it_is_the_same_path_bit_for_bit(arm, start, tube):
    whole, rolling = RollingTrajectory(arm, tube, start), RollingTrajectory(arm, tube, start)
    whole.extend(10_000)
    while not rolling.is_complete:
        rolling.extend(3)
    assert rolling.highest_rate == whole.highest_rate
    for theta in np.linspace(tube.start, tube.end, 50):
        one, other = whole.reference(theta, 1.0, 0.0), rolling.reference(theta, 1.0, 0.0)
        np.testing.assert_array_equal(one.configuration, other.configuration)
        np.testing.assert_array_equal(one.acceleration, other.acceleration)


def test_it_is_the_path_that_is_planned_at_once(arm, start, tube):
    planned = plan_joint_trajectory(arm, arch(arm, start, 2.0, 60), start)
    taken_up = TakenUp(RollingTrajectory(arm, tube, start), 0.0)
    assert taken_up.duration == pytest.approx(planned.duration)
    for time in np.linspace(0.0, planned.duration, 40):
        np.testing.assert_allclose(taken_up.at(time).configuration, planned.at(time).configuration, atol=1e-5)


@pytest.mark.parametrize("begin", [0.0, 0.7])
def test_the_reference_is_smooth_across_every_extension(arm, start, tube, begin):
    """Extended only when the next instant is asked for; the acceleration steps by less than the jerk limit allows."""
    path = RollingTrajectory(arm, tube, start, begin)
    taken_up = TakenUp(path, begin)
    q, v, a = states(taken_up.at, taken_up.duration + 0.1)
    np.testing.assert_allclose(np.diff(q, axis=0), 0.5e-3 * (v[1:] + v[:-1]), atol=1e-7)
    np.testing.assert_allclose(np.diff(v, axis=0), 0.5e-3 * (a[1:] + a[:-1]), atol=1e-5)
    assert (np.abs(np.diff(a, axis=0)) <= arm.limits.jerk * 1e-3).all()
    assert path.is_complete


def test_what_is_known_grows_with_the_samples_and_ends_at_the_tubes_end(arm, start, tube):
    path = RollingTrajectory(arm, tube, start)
    known = []
    while not path.is_complete:
        path.extend(20)
        known.append(path.known_until)
    assert np.all(np.diff(known) > 0.0)
    assert known[0] == pytest.approx(0.17)
    assert known[-1] == tube.end


def test_the_tool_follows_the_tube(arm, start, tube):
    path = RollingTrajectory(arm, tube, start)
    for index in range(0, len(tube.position), 20):
        q = path.reference(tube.start + 0.01 * index, 1.0, 0.0).configuration
        np.testing.assert_allclose(arm.forward(q).position, tube.position[index], atol=1e-4)
    assert path.position_error < 1e-6


def test_a_tube_out_of_reach_shows_as_an_error_as_soon_as_it_is_computed(arm, start):
    far = arch(arm, start, 2.0, 60)
    far = type(far)(
        far.label, far.time, far.position + np.linspace(0, 1.5, 60)[:, None], far.quaternion, far.covariance
    )
    path = RollingTrajectory(arm, smooth_tube(far, far.quaternion[0]), start)
    path.extend(10)
    assert path.position_error < 1e-6
    path.extend(1000)
    assert path.position_error > 0.1


def test_later_parts_that_are_too_fast_ask_for_a_lower_rate(arm, start, tube):
    path = RollingTrajectory(arm, tube, start)
    path.extend(20)
    taken_up = TakenUp(path, 0.0, pace=0.9 * path.highest_rate)
    assert taken_up.slower == 1.0
    path.extend(1000)
    assert taken_up.slower == pytest.approx(path.highest_rate / taken_up.time_law.rate)
    assert taken_up.slower < 0.9


def test_a_pace_or_a_beginning_that_is_none_is_refused(arm, start, tube):
    with pytest.raises(ControlError, match="pace must be positive"):
        TakenUp(RollingTrajectory(arm, tube, start), 0.0, pace=0.0)
    with pytest.raises(ControlError, match="finite tube time"):
        RollingTrajectory(arm, tube, start, np.nan)


def test_what_is_foreseen_is_what_is_known_and_computes_nothing(arm, start, tube):
    taken_up = TakenUp(RollingTrajectory(arm, tube, start), 0.0)
    taken_up.path.extend(60)
    known = taken_up.path.known_until
    for time in np.linspace(0.0, taken_up.duration, 20):
        foreseen = taken_up.foreseen(float(time))
        if taken_up.time_law.at(float(time))[0] <= known - 0.02:
            np.testing.assert_array_equal(foreseen.configuration, taken_up.at(float(time)).configuration)
    assert taken_up.path.known_until == known
    taken_up.path.extend(10_000)
    end = taken_up.foreseen(taken_up.duration + 1.0).configuration
    np.testing.assert_array_equal(end, taken_up.at(taken_up.duration).configuration)
