"""Joint trajectories: on the tube, twice continuously differentiable, within the limits, at rest at the end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.control import plan_joint_trajectory
from pft_exec.control.joint_trajectory import (
    GRID,
    LIMIT_SHARE,
    evaluate_spline,
    limit_rate,
    sample_tube,
    smooth,
    spline_points,
)
from pft_exec.exceptions import ControlError
from pft_exec.geometry import geodesic_distance


@pytest.fixture(scope="module")
def trajectory(arm, tube, start):
    return plan_joint_trajectory(arm, tube, start)


def test_tool_follows_the_tube(arm, tube, trajectory):
    law = trajectory.time_law
    for time in np.linspace(0.0, trajectory.duration, 40):
        reference = trajectory.at(time)
        tool = arm.forward(reference.configuration)
        position, quaternion = sample_tube(tube, np.array([law.at(time)[0]]), tool.quaternion)
        assert np.linalg.norm(tool.position - position[0]) <= 5e-4
        assert geodesic_distance(tool.quaternion, quaternion[0]) <= 2e-3
    assert np.linalg.norm(arm.forward(trajectory.at(1e3).configuration).position - tube.position[-1]) <= 1e-6
    assert trajectory.at(1e3).phase == 1.0


def test_velocity_and_acceleration_are_the_derivatives(trajectory):
    step = 1e-5
    for time in np.linspace(0.03, trajectory.duration - 0.01, 60) + 1e-4:
        before, now, after = (trajectory.at(time + shift) for shift in (-step, 0.0, step))
        slope = (after.configuration - before.configuration) / (2 * step)
        np.testing.assert_allclose(slope, now.velocity, atol=1e-5)
        np.testing.assert_allclose((after.velocity - before.velocity) / (2 * step), now.acceleration, atol=2e-2)


def test_acceleration_is_continuous_over_a_control_period(trajectory):
    time = np.arange(0.0, trajectory.duration + 0.1, 0.001)
    acceleration = np.array([trajectory.at(t).acceleration for t in time])
    assert np.abs(np.diff(acceleration, axis=0)).max() <= 0.5


def test_it_ends_at_rest_and_stays(trajectory):
    q, v, a = trajectory.state_at(trajectory.duration)
    np.testing.assert_array_equal(v, 0.0)
    np.testing.assert_array_equal(a, 0.0)
    np.testing.assert_array_equal(trajectory.at(trajectory.duration + 5.0).configuration, q)


@pytest.mark.parametrize("pace", [1.0, 50.0])
def test_limits_are_kept_whatever_the_pace(arm, tube, start, pace):
    trajectory = plan_joint_trajectory(arm, tube, start, pace=pace)
    states = [trajectory.at(t) for t in np.linspace(0.0, trajectory.time_law.duration - 0.1, 300)]
    assert (np.abs([s.velocity for s in states]) <= arm.limits.velocity).all()
    assert (np.abs([s.acceleration for s in states]) <= 1.05 * arm.limits.acceleration).all()


def test_it_can_begin_anywhere_along_the_tube_at_any_pace(arm, tube, start):
    middle = plan_joint_trajectory(arm, tube, start, phase=0.5, pace=0.8)
    assert middle.at(0.0).phase == pytest.approx(0.5)
    assert middle.duration == pytest.approx(0.5 * tube.duration / 0.8 + 0.05, abs=1e-6)
    position = sample_tube(tube, np.array([0.5 * tube.duration]), np.zeros(4))[0][0]
    assert np.linalg.norm(arm.forward(middle.at(0.0).configuration).position - position) <= 1e-5


def test_at_the_very_end_of_a_tube_it_holds(arm, tube, start):
    end = plan_joint_trajectory(arm, tube, start, phase=1.0)
    np.testing.assert_array_equal(end.at(0.0).velocity, 0.0)
    assert np.linalg.norm(arm.forward(end.at(0.0).configuration).position - tube.position[-1]) <= 1e-5


def test_a_tube_still_under_way_at_its_end_comes_to_rest_within_limits(arm, tube, start):
    cut = 30
    half = replace(
        tube,
        **{name: getattr(tube, name)[:cut] for name in ("time", "position", "quaternion", "covariance")},
        time_deviation=None,
    )
    trajectory = plan_joint_trajectory(arm, half, start)
    times = np.arange(0.0, trajectory.duration + 0.05, 0.001)
    acceleration = np.array([trajectory.at(t).acceleration for t in times])
    assert (np.abs(acceleration) <= arm.limits.acceleration).all()
    assert trajectory.duration > half.duration


def test_a_tube_without_orientation_keeps_the_tools(arm, tube, start):
    bare = replace(tube, quaternion=None, covariance=tube.covariance[:, :3, :3])
    trajectory = plan_joint_trajectory(arm, bare, start)
    tool = arm.forward(trajectory.at(1.0).configuration)
    assert geodesic_distance(tool.quaternion, arm.forward(start).quaternion) <= 2e-3


def test_a_tube_beyond_reach_says_how_far(arm, tube, start):
    far = replace(tube, position=tube.position + np.array([2.0, 0.0, 0.0]))
    assert plan_joint_trajectory(arm, far, start).position_error > 0.5


@pytest.mark.parametrize("setting", [{"phase": 1.5}, {"phase": -0.1}, {"pace": 0.0}])
def test_a_phase_or_pace_out_of_range_is_refused(arm, tube, start, setting):
    with pytest.raises(ControlError, match="phase must lie in"):
        plan_joint_trajectory(arm, tube, start, **setting)


def test_smoothing_keeps_ends_and_parabolas_and_takes_out_tremor():
    time = np.arange(200) * GRID
    parabola = (0.3 + 0.2 * time - 0.4 * time**2)[:, None]
    np.testing.assert_allclose(smooth(parabola), parabola, atol=1e-8)
    tremor = 0.01 * np.sin(2 * np.pi * 10.0 * time)[:, None]
    smoothed = smooth(parabola + tremor)
    assert np.abs(smoothed - parabola)[20:-20].max() <= 0.2 * 0.01
    np.testing.assert_allclose(smoothed[[0, -1]], (parabola + tremor)[[0, -1]], atol=1e-5)
    slow = 0.01 * np.sin(2 * np.pi * 2.0 * time)[:, None]
    assert np.abs(smooth(slow) - slow)[20:-20].max() <= 0.02 * 0.01
    np.testing.assert_array_equal(smooth(parabola[:5]), parabola[:5])


def test_spline_reproduces_cubics_and_matches_its_plain_form():
    place = np.arange(12.0)
    samples = np.stack([place**3 - 4 * place, 2.0 - place**2], axis=1)
    points = spline_points(samples)
    for at in (2.5, 6.25, 8.0):
        value, slope, curvature = evaluate_spline(points, at)
        np.testing.assert_allclose(value, [at**3 - 4 * at, 2 - at**2], rtol=1e-10)
        np.testing.assert_allclose(slope, [3 * at**2 - 4, -2 * at], rtol=1e-10)
        np.testing.assert_allclose(curvature, [6 * at, -2.0], rtol=1e-9)
        np.testing.assert_allclose(evaluate_spline.py_func(points, at), evaluate_spline(points, at), rtol=1e-12)
    np.testing.assert_allclose(evaluate_spline(points, 0.0)[0], samples[0])


def test_limit_rate_is_set_by_the_joint_that_is_hardest_pressed(arm):
    points = np.zeros((20, 7))
    points[:, 2] = np.linspace(0.0, 19 * GRID * arm.limits.velocity[2] * 2.0, 20)
    assert limit_rate(points, arm.limits) == pytest.approx(LIMIT_SHARE / 2.0)
