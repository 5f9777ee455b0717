"""Inverse kinematics: round trips, limits, redundancy, paths, and honest answers where nothing reaches."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.exceptions import ConfigurationError
from pft_exec.geometry import Array, Pose, geodesic_distance, quaternion_from_rotation_vector
from pft_exec.model import Arm, follow_path, load_robot, solve_inverse_kinematics
from pft_exec.model.descent import LEVER, bounded_step

YAW = np.array([0.0, 0.0, np.sin(0.6), np.cos(0.6)])  # 1.2 rad about z


def reachable(arm: Arm, count: int, margin: float = 0.0) -> list[Array]:
    generator = np.random.default_rng(11)
    lower, upper = np.maximum(arm.limits.lower, -np.pi) + margin, np.minimum(arm.limits.upper, np.pi) - margin
    return list(generator.uniform(lower, upper, size=(count, len(lower))))


def straight(length: float = 0.20, count: int = 200) -> tuple[Array, Array]:
    """A minimum-jerk path along y at constant orientation, within the right arm's reach."""
    s = np.linspace(0.0, 1.0, count)
    ratio = 10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5
    positions = np.array([0.54, -0.40, 0.94]) + ratio[:, None] * np.array([0.0, length, 0.0])
    return positions, np.tile(YAW, (count, 1))


def test_every_reachable_pose_is_reached_from_a_fixed_seed(arm: Arm) -> None:
    for q in reachable(arm, 60):
        pose = arm.forward(q)
        solution = solve_inverse_kinematics(arm, pose, arm.configuration("work"))
        assert solution.found
        reached = arm.forward(solution.configuration)
        assert np.linalg.norm(reached.position - pose.position) <= 1e-6
        assert geodesic_distance(reached.quaternion, pose.quaternion) <= 1e-6


def test_solutions_lie_inside_the_soft_limits(arm: Arm) -> None:
    for q in reachable(arm, 60):
        solution = solve_inverse_kinematics(arm, arm.forward(q), arm.configuration("home"))
        assert arm.limits.margin(solution.configuration).min() >= 0.0
        assert solution.limit_margin == pytest.approx(arm.limits.margin(solution.configuration).min())


def test_a_seed_that_solves_is_the_solution(arm: Arm) -> None:
    for q in reachable(arm, 5):
        np.testing.assert_array_equal(solve_inverse_kinematics(arm, arm.forward(q), q).configuration, q)


def test_a_near_pose_is_reached_near_the_seed(arm: Arm) -> None:
    """The change is of the order of the joint displacement that made the pose, so no branch was changed."""
    generator = np.random.default_rng(2)
    for q in reachable(arm, 30, margin=0.3):
        pose = arm.forward(q + generator.uniform(-0.05, 0.05, len(q)))
        solution = solve_inverse_kinematics(arm, pose, q)
        assert solution.found
        assert np.abs(solution.configuration - q).max() < 0.5


def test_the_same_question_has_the_same_answer_to_the_bit(right: Arm) -> None:
    poses = [right.forward(q) for q in reachable(right, 10)]
    first = [solve_inverse_kinematics(right, pose, right.configuration("work")).configuration for pose in poses]
    other = load_robot("pr2").arm("right")
    again = [solve_inverse_kinematics(other, pose, other.configuration("work")).configuration for pose in poses]
    np.testing.assert_array_equal(first, again)


def test_the_posture_draws_the_redundant_joint(right: Arm) -> None:
    pose = right.forward(right.configuration("work"))
    seed = right.configuration("teach")
    postures = [right.configuration("work") + lean * np.array([0, 0, 1, 0, 0, 0, 0]) for lean in (-0.6, 0.6)]
    low, high = (solve_inverse_kinematics(right, pose, seed, posture=posture) for posture in postures)
    assert low.found
    assert high.found
    assert low.configuration[2] < high.configuration[2]


def test_endless_joints_stay_within_half_a_turn_of_the_seed(right: Arm) -> None:
    endless = right.limits.upper - right.limits.lower > 100.0
    seed = right.configuration("work") + 4.0 * np.pi * endless
    for q in reachable(right, 20):
        solution = solve_inverse_kinematics(right, right.forward(q), seed)
        assert (np.abs(solution.configuration - seed)[endless] <= np.pi + 1e-9).all()


def test_a_seed_outside_the_limits_is_taken_from_their_edge(right: Arm) -> None:
    seed = right.limits.upper + 0.2
    seed[[4, 6]] = 0.0
    assert solve_inverse_kinematics(right, right.forward(right.configuration("work")), seed).found


def test_out_of_reach_is_said_with_the_distance(right: Arm) -> None:
    shoulder = np.array([-0.05, -0.188, 1.091])
    pose = Pose(shoulder + np.array([2.0, 0.0, 0.0]))
    solution = solve_inverse_kinematics(right, pose, right.configuration("work"))
    reached = right.forward(solution.configuration)
    assert not solution.found
    assert solution.position_error == pytest.approx(float(np.linalg.norm(reached.position - pose.position)))
    assert 0.9 < solution.position_error < 1.3  # the arm is 1.0 m long
    assert right.limits.margin(solution.configuration).min() >= 0.0


def test_manipulability_is_the_smallest_singular_value(right: Arm) -> None:
    q = right.configuration("work")
    solution = solve_inverse_kinematics(right, right.forward(q), q)
    assert solution.manipulability == pytest.approx(np.linalg.svd(right.jacobian(q), compute_uv=False)[-1])


@pytest.mark.parametrize("length", [6, 8])
def test_a_seed_or_posture_of_the_wrong_length_is_refused(right: Arm, length: int) -> None:
    pose = right.forward(right.configuration("work"))
    with pytest.raises(ConfigurationError, match="7 joints"):
        solve_inverse_kinematics(right, pose, np.zeros(length))
    with pytest.raises(ConfigurationError, match="7 joints"):
        solve_inverse_kinematics(right, pose, np.zeros(7), posture=np.zeros(length))


def test_a_path_is_followed_within_tolerance_and_limits(right: Arm) -> None:
    positions, quaternions = straight()
    path = follow_path(right, positions, quaternions, right.configuration("work"))
    assert path.found
    assert path.samples.shape == (200, 7)
    assert path.worst_position_error <= 1e-6
    assert path.worst_rotation_error <= 1e-6
    assert path.limit_margin > 0.1
    assert path.manipulability > 0.06
    reached = np.array([right.forward(q).position for q in path.samples])
    np.testing.assert_allclose(np.linalg.norm(reached - positions, axis=1), path.position_error, rtol=0, atol=1e-12)


def test_a_smooth_tool_path_gives_a_smooth_joint_path(right: Arm) -> None:
    """At 100 Hz over 2 s, joint acceleration stays of the order of the tool's over a lever of half a meter."""
    path = follow_path(right, *straight(), right.configuration("work"))
    acceleration = np.diff(path.samples[1:], n=2, axis=0) / 0.01**2
    assert np.abs(acceleration).max() < 2.0


def test_a_path_does_not_depend_on_how_finely_it_is_sampled(right: Arm) -> None:
    coarse = follow_path(right, *straight(count=51), right.configuration("work"))
    fine = follow_path(right, *straight(count=401), right.configuration("work"))
    assert np.abs(coarse.samples[-1] - fine.samples[-1]).max() < 0.05


def test_a_path_mirrored_is_followed_by_the_other_arm_mirrored(right: Arm) -> None:
    left = load_robot("pr2").arm("left")
    positions, quaternions = straight()
    path = follow_path(right, positions, quaternions, right.configuration("work"))
    image = follow_path(left, positions * [1, -1, 1], quaternions * [1, -1, 1, -1], left.configuration("work"))
    mirrored = np.array([right.mirror_configuration(q) for q in path.samples])
    np.testing.assert_allclose(image.samples, mirrored, rtol=0, atol=1e-9)


def test_a_path_that_leaves_reach_says_where(right: Arm) -> None:
    positions, quaternions = straight(length=2.0)
    path = follow_path(right, positions, quaternions, right.configuration("work"))
    assert not path.found
    assert path.position_error[0] <= 1e-6
    assert path.worst_position_error > 0.5
    assert right.limits.margin(path.samples).min() >= 0.0


def test_a_path_of_one_sample_is_a_pose(right: Arm) -> None:
    pose = right.forward(right.configuration("home"))
    path = follow_path(right, pose.position[None], pose.quaternion[None], right.configuration("work"))
    assert path.found


@pytest.mark.parametrize(
    ("positions", "quaternions"),
    [(np.zeros((0, 3)), np.zeros((0, 4))), (np.zeros((2, 3)), np.zeros((3, 4))), (np.zeros(3), np.zeros(4))],
)
def test_a_path_of_the_wrong_shape_is_refused(right: Arm, positions: Array, quaternions: Array) -> None:
    with pytest.raises(ConfigurationError, match=r"positions \(N, 3\) and quaternions \(N, 4\)"):
        follow_path(right, positions, quaternions, right.configuration("work"))


def test_the_compiled_step_is_the_damped_least_squares_step(right: Arm) -> None:
    """Against the formula with numpy, where no limit is near."""
    generator = np.random.default_rng(4)
    q, posture = right.configuration("work"), right.configuration("teach")
    weight = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])
    jacobian = right.jacobian(q)
    for _ in range(10):
        error = generator.normal(scale=0.005, size=6)
        size = float(np.linalg.norm(weight * error))
        pull = 0.3 * min(1.0, size / 0.05) * (posture - q)
        weighted = weight[:, None] * jacobian
        squared = weighted @ weighted.T + (1e-2 * size**2 + 1e-12) * np.eye(6)
        expected = pull + weighted.T @ np.linalg.solve(squared, weight * error - weighted @ pull)
        step = bounded_step(jacobian, error, size, q, posture, right.limits.lower, right.limits.upper)
        np.testing.assert_allclose(step, expected, rtol=0, atol=1e-10)


def test_a_joint_at_its_limit_leaves_the_step_and_the_others_do_its_share(right: Arm) -> None:
    q = right.configuration("work").copy()
    error = np.array([0.0, 1e-4, 0.0, 0.0, 0.0, 0.0])
    jacobian = right.jacobian(q)
    free = bounded_step(jacobian, error, 1e-4, q, q, right.limits.lower, right.limits.upper)
    joint = int(np.argmax(np.abs(free)))
    lower, upper = right.limits.lower.copy(), right.limits.upper.copy()
    lower[joint] = upper[joint] = q[joint]
    held = bounded_step(jacobian, error, 1e-4, q, q, lower, upper)
    assert held[joint] == 0.0
    np.testing.assert_allclose(jacobian @ held, error, rtol=0, atol=1e-8)


def test_a_turn_about_each_axis_is_reached(right: Arm) -> None:
    pose = right.forward(right.configuration("work"))
    for axis in np.eye(3):
        turned = Pose(pose.position, (pose @ Pose(np.zeros(3), quaternion_from_rotation_vector(0.3 * axis))).quaternion)
        assert solve_inverse_kinematics(right, turned, right.configuration("work")).found
