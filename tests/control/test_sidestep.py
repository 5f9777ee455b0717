"""The sidestep: the side is chosen ahead of the encounter, where the tube is wide, and taken without a jump."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from pft_exec.control import TrackingController, compute_compliance, constant_compliance
from pft_exec.control.avoidance import Avoidance
from pft_exec.control.sidestep import INSTANTS, LARGEST, LOOK_PERIOD, POLE, Sidestep
from pft_exec.control.sidestep_kernel import carried_ends, judge_steps, segment_distance, spread_of
from pft_exec.evaluation.benchmarks.plant import Mismatch, Plant, arch_trajectory, arch_tube, run
from pft_exec.geometry import Pose
from pft_exec.learning import FlowTube
from pft_exec.model import Box, Obstacle, Sphere

PERIOD = 0.002
PERIODS = round(INSTANTS * LOOK_PERIOD / PERIOD)
"""Until a choice is made."""


@pytest.fixture(scope="module")
def tube(arm):
    """Along x, with an arch along z; wide along y in its middle."""
    return arch_tube(arm)


@pytest.fixture(scope="module")
def trajectory(arm, tube):
    return arch_trajectory(arm, tube)


def crossing(tube, velocity, beside=(0.0, 0.0, 0.0), radius=0.04):
    """A ball that meets the middle of a tube at a velocity (3,), m/s."""
    met = tube.position[len(tube) // 2] + np.asarray(beside)
    velocity = np.concatenate([velocity, np.zeros(3)])
    return Obstacle("ball", Sphere(radius), Pose(met - 0.5 * tube.time[-1] * velocity[:3]), velocity)


def _delayed(trajectory, late, time):
    return trajectory.at(time - late)


def choose(arm, trajectory, compliance, obstacles, times=(0.0,), error=(0.0, 0.0, 0.0)):
    """A sidestep that has looked at what comes, some times over, and all of its shifts."""
    sidestep, clock = Sidestep(arm, Avoidance(arm).moved), 0.0
    shifts = []
    for time in times:
        sidestep.watch([replace(it, pose=it.after(time)) for it in obstacles], clock)
        late = clock - time
        for _ in range(PERIODS):
            phase = trajectory.at(clock - late).phase
            ahead = partial(_delayed, trajectory, late)
            shifts.append(sidestep.update(clock, PERIOD, phase, np.array(error), compliance, ahead))
            clock += PERIOD
    return sidestep, shifts


@pytest.mark.parametrize("seed", range(20))
def test_distance_of_segments_is_that_of_their_nearest_points(seed):
    generator = np.random.default_rng(seed)
    a, b, c, d = generator.normal(size=(4, 3))
    if seed % 4 == 0:
        b = a.copy()
    if seed % 3 == 0:
        d = c.copy()
    share = np.linspace(0.0, 1.0, 801)[:, None]
    first, second = a + share * (b - a), c + share * (d - c)
    least = np.min(np.linalg.norm(first[:, None] - second[None], axis=2))
    one, other = np.array([a, b]), np.array([c, d])
    assert segment_distance(one, other) == pytest.approx(least, abs=1e-5)
    assert segment_distance(other, one) == pytest.approx(segment_distance(one, other), abs=1e-12)


def test_links_are_carried_as_the_arm_carries_them_where_the_tool_does_not_turn(arm, start):
    links = [arm.geometry.links[i] for i in Avoidance(arm).moved]
    local, joint = np.array([[link.start, link.end] for link in links]), np.array([link.joint for link in links])
    shape = (len(links), 2, 3)
    aside = np.concatenate([[0.002, -0.003, 0.001], np.zeros(3)])
    found = []
    for q in (start, start + np.linalg.pinv(arm.jacobian(start)) @ aside):
        ends, carried = np.zeros(shape), np.zeros((*shape, 3))
        carried_ends(local, joint, arm.joint_frames(q), arm.jacobian(q), ends, carried)
        found.append((ends, carried))
    np.testing.assert_allclose(found[1][0] - found[0][0], found[0][1] @ aside[:3], atol=3e-5)


def test_room_is_the_deviation_of_the_position_with_the_tool_as_it_is_turned(tube):
    """Where position and rotation go together, less is left when the rotation is kept."""
    phase = 0.5
    free = spread_of(compute_compliance(tube).deviation, phase)
    index = round(phase * (len(tube) - 1))
    np.testing.assert_allclose(free @ free, tube.covariance[index, :3, :3], rtol=0.03, atol=3e-6)
    covariance = np.array(tube.covariance)
    covariance[:, 1, 5] = covariance[:, 5, 1] = 0.8 * np.sqrt(covariance[:, 1, 1] * covariance[:, 5, 5])
    tied = FlowTube("tied", tube.time, tube.position, tube.quaternion, covariance)
    kept = spread_of(compute_compliance(tied).deviation, phase)
    assert 0.55 * free[1, 1] < kept[1, 1] < 0.75 * free[1, 1]


def test_the_step_is_to_where_the_ball_comes_from(arm, tube, trajectory):
    """It is beyond the tube's middle when they meet, and goes on."""
    ball = crossing(tube, [0.0, 0.1, 0.17], beside=[0.0, 0.02, 0.0])
    sidestep, _ = choose(arm, trajectory, compute_compliance(tube), [ball])
    assert sidestep.wanted[1] < -0.5
    assert np.abs(sidestep.wanted[[0, 2]]).max() < 1e-9


def test_a_choice_is_kept_where_the_other_side_is_as_good(arm, tube, trajectory):
    ball = crossing(tube, [0.0, 0.0, 0.1])
    chosen = [choose(arm, trajectory, compute_compliance(tube), [ball], (0.0, 0.1, 0.2, 0.3)[:k])[0] for k in (1, 4)]
    assert abs(chosen[0].wanted[1]) > 1.0
    assert np.sign(chosen[0].wanted[1]) == np.sign(chosen[1].wanted[1])


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_path_that_would_change_sides_through_the_ball_lacks_more(side):
    """A small hand that stands to one side of a ball; a step to the same size on either side is free in the end."""
    instants = np.arange(10)
    fading = np.exp(-0.5 * instants)
    hand = np.zeros((10, 1, 2, 3)), np.tile(np.eye(3), (10, 1, 2, 1, 1)), np.array([0.03])
    ball = np.zeros((10, 1, 2, 3)), np.tile(np.eye(3), (10, 1, 1, 1)), np.array([0.04]), np.zeros((1, 3))
    steps, spread = np.array([[0.0, -3.0, 0.0], [0.0, 3.0, 0.0]]), np.tile(0.05 * np.eye(3), (10, 1, 1))
    lacking = judge_steps(steps, hand, spread, fading, np.array([0.0, 0.12 * side, 0.0]), ball, 0.035)
    assert lacking[int(side > 0.0)] == 0.0
    assert lacking[int(side < 0.0)] > 0.05**2


def test_a_step_is_no_larger_than_what_lacks_and_never_beyond_the_largest(arm, tube, trajectory):
    """Looked at again and again, the choice comes to the least step that leaves the room, whatever came first."""
    before = 0.5 * tube.time[-1] - 0.5
    ball = Obstacle("ball", Sphere(0.04), Pose(tube.position[len(tube) // 2] + np.array([0.0, 0.07, 0.0])))
    first, late = (
        choose(arm, trajectory, compute_compliance(tube), [ball], np.full(looks, before))[0].wanted[1]
        for looks in (1, 8)
    )
    assert 1.0 < -late < -first < LARGEST
    huge = Obstacle("huge", Sphere(0.5), Pose(tube.position[len(tube) // 2]))
    sidestep, _ = choose(arm, trajectory, compute_compliance(tube), [huge], np.full(8, before))
    assert np.linalg.norm(sidestep.wanted) <= LARGEST + 1e-9


def test_nothing_is_shifted_where_nothing_comes_near_or_the_tube_is_narrow(arm, tube, trajectory):
    far = Obstacle("far", Sphere(0.04), Pose(tube.position[0] + np.array([0.0, 1.0, 0.0])))
    shelf = Obstacle("shelf", Box((0.4, 0.4, 0.02)), Pose(tube.position[0] - np.array([0.0, 0.0, 0.35])))
    assert choose(arm, trajectory, compute_compliance(tube), [far, shelf])[1] == [None] * PERIODS
    narrow = FlowTube("narrow", tube.time, tube.position, tube.quaternion, np.tile(1e-5 * np.eye(6), (len(tube), 1, 1)))
    ball = crossing(tube, [0.0, 0.0, 0.1])
    assert choose(arm, trajectory, compute_compliance(narrow), [ball])[1] == [None] * PERIODS


def test_a_flat_sided_obstacle_lacks_room_as_a_ball_of_its_size_does(arm):
    """A link above a box: its distance is that from the face."""
    ends = np.array([[[[-0.1, 0.0, 0.2], [0.1, 0.0, 0.2]]]])
    carried = np.tile(np.eye(3), (1, 1, 2, 1, 1))
    others = np.zeros((1, 1, 2, 3)), np.eye(3).reshape(1, 1, 3, 3), np.zeros(1), np.array([[0.3, 0.3, 0.1]])
    steps = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    link = ends, carried, np.array([0.05])
    lacking = judge_steps(steps, link, 0.02 * np.eye(3)[None], np.zeros(1), np.zeros(3), others, 0.06)
    np.testing.assert_allclose(np.sqrt(lacking), [0.01, 0.0, 0.03], atol=1e-12)


def test_a_step_is_taken_without_a_jump_of_the_targets_acceleration(arm, tube, trajectory):
    """Position, velocity and acceleration belong together in the middle of the tube, and none of them jumps."""
    ball = crossing(tube, [0.0, 0.0, 0.1])
    times = np.arange(0.3 * tube.time[-1], 0.6 * tube.time[-1], PERIODS * PERIOD)
    _, shifts = choose(arm, trajectory, compute_compliance(tube), [ball], times)
    rest = (np.zeros(3),) * 3
    place, speed, change = (np.array([(shift or rest)[k] for shift in shifts]) for k in range(3))
    assert np.abs(place).max() > 0.05
    largest = LARGEST * 0.05
    assert np.abs(np.diff(place, axis=0)).max() <= POLE * largest * PERIOD
    assert np.abs(np.diff(speed, axis=0)).max() <= POLE**2 * largest * PERIOD
    assert np.abs(np.diff(change, axis=0)).max() <= 3.0 * POLE**3 * largest * PERIOD


@pytest.mark.slow
@pytest.mark.parametrize("way", [[0.0, 0.12, -0.16], [0.0, -0.17, 0.1], [0.09, 0.1, 0.15]])
def test_a_ball_from_the_side_is_gone_round_and_not_fled_from(arm, tube, trajectory, way):
    """Without the sidestep the arm flees before it, decimeters aside and centimeters out of the tube."""
    ball = crossing(tube, way, beside=[0.0, 0.01, 0.0])
    controller = TrackingController(arm, PERIOD)
    controller.follow(trajectory.at, compute_compliance(tube), 0.0, blend=False)
    plant = Plant(arm, trajectory.at(0.0).configuration, Mismatch(friction=1.25))

    def look(time):
        if round(time / PERIOD) % 10 == 0:
            controller.avoid([replace(ball, pose=ball.after(time))], time)

    done = run(controller, plant, trajectory.duration + 0.8, before=look)
    distance = min(command.distance for command in done.commands)
    off_axis = np.hypot(done.error[:, 0], done.error[:, 2]).max()
    assert distance >= 0.02
    assert off_axis <= 0.010
    assert np.linalg.norm(done.error[-1, :3]) <= 0.004


def test_without_a_tube_there_is_no_room_and_the_rows_alone_keep_off(arm, start, trajectory, tube):
    ball = crossing(tube, [0.0, 0.0, 0.1])
    controller = TrackingController(arm, PERIOD)
    controller.follow(trajectory.at, constant_compliance(100.0), 0.0, blend=False)
    controller.avoid([ball])
    for step in range(2 * PERIODS):
        command = controller.update(step * PERIOD, start, np.zeros(7))
    plain = TrackingController(arm, PERIOD)
    plain.follow(trajectory.at, constant_compliance(100.0), 0.0, blend=False)
    for step in range(2 * PERIODS):
        other = plain.update(step * PERIOD, start, np.zeros(7))
    np.testing.assert_array_equal(command.torque, other.torque)
