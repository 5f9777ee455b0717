"""An arm: its derivatives against finite differences, its springs, mirror and payload, and what it refuses."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from pft_exec.assets import robot_file
from pft_exec.exceptions import (
    ConfigurationError,
    DescriptionError,
    UnknownArmError,
    UnknownNameError,
    UnknownRobotError,
)
from pft_exec.geometry import Array, relative_rotation_vector, rotate
from pft_exec.model import Arm, RobotModel, load_robot

NUDGE = 1e-6


def velocity_by_difference(arm: Arm, q: Array, v: Array) -> Array:
    """Tool velocity (6,), linear then angular in the base frame, by central differences of the pose."""
    before, after = arm.forward(q - NUDGE * v), arm.forward(q + NUDGE * v)
    turn = rotate(before.quaternion, relative_rotation_vector(before.quaternion, after.quaternion))
    return np.concatenate([after.position - before.position, turn]) / (2.0 * NUDGE)


def test_jacobian_times_velocity_is_the_tools_velocity(arm: Arm, states: list[tuple[Array, Array]]) -> None:
    for q, v in states:
        np.testing.assert_allclose(arm.jacobian(q) @ v, velocity_by_difference(arm, q, v), rtol=0, atol=1e-8)


def test_jacobian_drift_is_the_tools_acceleration_at_constant_velocity(
    arm: Arm, states: list[tuple[Array, Array]]
) -> None:
    for q, v in states:
        expected = (arm.jacobian(q + NUDGE * v) @ v - arm.jacobian(q - NUDGE * v) @ v) / (2.0 * NUDGE)
        np.testing.assert_allclose(arm.dynamics(q, v).jacobian_drift, expected, rtol=0, atol=1e-7)


def test_one_pass_gives_what_the_single_functions_give(arm: Arm, states: list[tuple[Array, Array]]) -> None:
    for q, v in states:
        dynamics, pose = arm.dynamics(q, v), arm.forward(q)
        np.testing.assert_allclose(dynamics.mass_matrix, arm.mass_matrix(q), rtol=0, atol=1e-13)
        np.testing.assert_allclose(dynamics.jacobian, arm.jacobian(q), rtol=0, atol=1e-13)
        np.testing.assert_allclose(dynamics.velocity, arm.jacobian(q) @ v, rtol=0, atol=1e-13)
        np.testing.assert_allclose(arm.dynamics(q, 0 * v).bias, arm.gravity(q), rtol=0, atol=1e-12)
        np.testing.assert_allclose(np.append(dynamics.position, dynamics.quaternion), pose.array, rtol=0, atol=1e-13)


def test_the_mass_matrix_is_symmetric_and_positive_definite(arm: Arm, states: list[tuple[Array, Array]]) -> None:
    for q, _ in states:
        matrix = arm.mass_matrix(q)
        np.testing.assert_array_equal(matrix, matrix.T)
        assert np.linalg.eigvalsh(matrix).min() > 1e-4


def test_energy_is_kept_by_the_bias(arm: Arm, states: list[tuple[Array, Array]]) -> None:
    """dM/dt - 2 C is skew: twice the Coriolis power is the kinetic energy's share that the mass matrix carries."""
    for q, v in states:
        coriolis = arm.dynamics(q, v).bias - arm.gravity(q)
        change = (arm.mass_matrix(q + NUDGE * v) - arm.mass_matrix(q - NUDGE * v)) / (2.0 * NUDGE)
        assert v @ change @ v == pytest.approx(2.0 * v @ coriolis, abs=1e-6)


def test_results_are_copies(arm: Arm, states: list[tuple[Array, Array]]) -> None:
    (q, v), (other, _) = states[:2]
    kept = arm.dynamics(q, v)
    pose, gravity, kinematics = arm.forward(q), arm.gravity(q), arm.kinematics(q)
    before = [array.copy() for array in (*vars(kept).values(), pose.array, gravity, *kinematics)]
    arm.dynamics(other, v)
    arm.forward(other)
    arm.gravity(other)
    arm.kinematics(other)
    after = (*vars(kept).values(), pose.array, gravity, *kinematics)
    for first, second in zip(before, after, strict=True):
        np.testing.assert_array_equal(first, second)


def test_inputs_are_not_written_to(arm: Arm, states: list[tuple[Array, Array]]) -> None:
    q, v = states[0]
    q.setflags(write=False)
    v.setflags(write=False)
    arm.dynamics(q, v)
    arm.counterbalance(q)
    assert arm.forward(list(q)) == arm.forward(q)


def test_counterbalance_is_the_gradient_of_a_potential(arm: Arm, states: list[tuple[Array, Array]]) -> None:
    """Its Jacobian is symmetric, so passive springs can make it."""
    size = len(arm.joint_names)
    for q, _ in states:
        columns = [arm.counterbalance(q + 1e-5 * e) - arm.counterbalance(q - 1e-5 * e) for e in np.eye(size)]
        stiffness = np.array(columns) / 2e-5
        np.testing.assert_allclose(stiffness, stiffness.T, rtol=0, atol=1e-6)


def test_counterbalance_knows_nothing_of_the_wrist(right: Arm) -> None:
    q = right.configuration("work")
    other = q + np.array([0.3, 0, 0, 0, 1.0, 0.5, -2.0])
    np.testing.assert_allclose(right.counterbalance(q), right.counterbalance(other), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", ["left", "right"])
def test_counterbalance_passes_the_published_qualification(name: str) -> None:
    """pr2_self_test, pr2_counterbalance_check: over lift and flex, mean square < 3 and mean absolute < 2 at both."""
    arm = load_robot("pr2").arm(name)
    residuals = []
    for lift in np.linspace(-0.2, 1.21, 12):
        for flex in np.linspace(-1.8, -0.19, 12):
            q = arm.configuration("parked").copy()
            q[1], q[2], q[3] = lift, 0.0, flex
            residuals.append((arm.gravity(q) - arm.counterbalance(q))[[1, 3]])
    assert np.square(residuals).mean(axis=0).max() < 3.0
    assert np.abs(residuals).mean(axis=0).max() < 2.0


@pytest.mark.parametrize("name", ["left", "right"])
def test_with_springs_gravity_leaves_the_motors_little_to_do(name: str) -> None:
    arm = load_robot("pr2").arm(name)
    generator = np.random.default_rng(0)
    lower, upper = np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)
    q = generator.uniform(lower, upper, size=(500, 7))
    bare = np.array([arm.gravity(one) for one in q])
    left = bare - np.array([arm.counterbalance(one) for one in q])
    assert np.abs(bare[:, 1]).max() > arm.limits.torque[1]
    assert (np.abs(left).max(axis=0) < 2.0).all()


def test_an_arm_without_springs_has_none() -> None:
    arm = load_robot("wam").arm("arm")
    np.testing.assert_array_equal(arm.counterbalance(arm.configuration("work")), np.zeros(7))


def test_gravity_stays_within_the_torques_of_an_arm_without_springs() -> None:
    arm = load_robot("wam", tool="gripper").arm("arm")
    generator = np.random.default_rng(0)
    q = generator.uniform(arm.limits.lower, arm.limits.upper, size=(500, 7))
    assert (np.abs([arm.gravity(one) for one in q]).max(axis=0) < arm.limits.torque).all()


def test_mirrored_configurations_put_the_tools_in_mirror_images(right: Arm) -> None:
    left = load_robot("pr2").arm("left")
    assert (right.mirror_arm, left.mirror_arm) == ("left", "right")
    generator = np.random.default_rng(5)
    for _ in range(20):
        q = generator.uniform(-1.0, 1.0, 7)
        image, mirrored = left.forward(right.mirror_configuration(q)), right.forward(q).mirrored()
        np.testing.assert_allclose(image.position, mirrored.position, rtol=0, atol=1e-12)
        assert abs(image.quaternion @ mirrored.quaternion) == pytest.approx(1.0, abs=1e-12)


def test_the_mirror_of_a_mirror_is_the_original(right: Arm) -> None:
    left, q = load_robot("pr2").arm("left"), np.linspace(-0.5, 0.7, 7)
    np.testing.assert_array_equal(left.mirror_configuration(right.mirror_configuration(q)), q)


def test_soft_limits_mirror_too(right: Arm) -> None:
    left = load_robot("pr2").arm("left")
    ends = np.sort(
        [right.mirror_configuration(right.limits.lower), right.mirror_configuration(right.limits.upper)], axis=0
    )
    np.testing.assert_allclose(ends, [left.limits.lower, left.limits.upper], rtol=0, atol=1e-12)


def test_an_arm_alone_has_no_mirror_image() -> None:
    arm = load_robot("wam").arm("arm")
    assert arm.mirror_arm is None
    with pytest.raises(ConfigurationError, match="'arm' has no arm on the other side"):
        arm.mirror_configuration(np.zeros(7))


def test_a_payload_weighs_what_it_weighs(arm: Arm, states: list[tuple[Array, Array]]) -> None:
    """Its gravity torque is J^T of its weight at its center, its inertia that of a point."""
    center, mass = np.array([0.02, -0.01, 0.05]), 0.5
    loaded = arm.with_payload(mass, center)
    for q, _ in states:
        lever = arm.forward(q).apply(center) - arm.forward(q).position
        jacobian = arm.jacobian(q)
        at_center = jacobian[:3] - np.cross(lever, jacobian[3:], axisb=0, axisc=0)
        weight = np.array([0.0, 0.0, 9.81 * mass])
        np.testing.assert_allclose(loaded.gravity(q) - arm.gravity(q), at_center.T @ weight, rtol=0, atol=1e-10)
        gain = loaded.mass_matrix(q) - arm.mass_matrix(q)
        np.testing.assert_allclose(gain, mass * at_center.T @ at_center, rtol=0, atol=1e-10)


def test_a_payload_leaves_springs_kinematics_and_the_arm_itself_alone(right: Arm) -> None:
    q = right.configuration("work")
    before = right.gravity(q)
    loaded = right.with_payload(1.0)
    assert loaded.forward(q) == right.forward(q)
    np.testing.assert_array_equal(loaded.counterbalance(q), right.counterbalance(q))
    np.testing.assert_array_equal(right.gravity(q), before)
    np.testing.assert_allclose(loaded.with_payload(-1.0).gravity(q), before, rtol=0, atol=1e-10)


@pytest.mark.parametrize("center", [(0.0, 0.0), (0.0, 0.0, np.nan)])
def test_a_payload_without_a_proper_center_is_refused(right: Arm, center: tuple[float, ...]) -> None:
    with pytest.raises(ConfigurationError, match=r"a payload has a mass, kg, and a center \(3,\), m"):
        right.with_payload(1.0, center)


def test_named_configurations_lie_inside_the_soft_limits(arm: Arm) -> None:
    assert {"work", "teach", "home"} <= set(arm.configurations)
    for name in arm.configurations:
        assert arm.limits.margin(arm.configuration(name)).min() >= 0.0


def test_a_named_configuration_cannot_be_written_to(right: Arm) -> None:
    with pytest.raises(ValueError, match="read-only"):
        right.configuration("work")[0] = 0.0


def test_an_unknown_configuration_is_refused_with_the_nearest_name(right: Arm) -> None:
    with pytest.raises(UnknownNameError, match=r"no configuration is named 'hom'\. Did you mean 'home'\?"):
        right.configuration("hom")


@pytest.mark.parametrize(
    "method", ["forward", "gravity", "jacobian", "mass_matrix", "counterbalance", "check_configuration"]
)
def test_a_configuration_of_the_wrong_length_is_refused_with_the_joints(right: Arm, method: str) -> None:
    with pytest.raises(
        ConfigurationError, match=r"'right' has 7 joints: r_shoulder_pan_joint.* \(7,\), rad, got \(6,\)"
    ):
        getattr(right, method)(np.zeros(6))


def test_a_velocity_of_the_wrong_length_is_refused(right: Arm) -> None:
    with pytest.raises(ConfigurationError, match=r"velocity v must be \(7,\), rad/s, got \(8,\)"):
        right.dynamics(np.zeros(7), np.zeros(8))


def test_an_unknown_arm_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(UnknownArmError, match=r"no arm is named 'rihgt'\. Did you mean 'right'\?"):
        load_robot("pr2").arm("rihgt")


def test_an_unknown_robot_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(UnknownRobotError, match=r"Did you mean 'wam'\?"):
        load_robot("wamm")


def test_a_urdf_that_is_no_mechanism_is_refused(tmp_path: Path) -> None:
    """Joint frames are read by pinocchio alone; its refusal becomes ours."""
    shutil.copytree(robot_file("pr2").parent, tmp_path / "mine")
    urdf = tmp_path / "mine" / "pr2.urdf"
    urdf.write_text(urdf.read_text(encoding="utf-8").replace('rpy="0 0.35 0"', 'rpy="a b c"'), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"pr2\.urdf: cannot be made a mechanism"):
        load_robot(tmp_path / "mine")


def test_an_arm_is_the_same_object_every_time(robot_and_arm: tuple[RobotModel, Arm]) -> None:
    robot, arm = robot_and_arm
    assert robot.arm(arm.name) is arm


def test_robots_and_arms_introduce_themselves() -> None:
    robot = load_robot("pr2")
    assert repr(robot) == "RobotModel('pr2', arms 'left', 'right')"
    assert repr(robot.arm("left")) == "Arm('left', 7 joints, tool 'l_gripper_tool_frame')"


def test_friction_limits_and_names_have_one_entry_a_joint(arm: Arm) -> None:
    size = len(arm.joint_names)
    for array in (*vars(arm.limits).values(), *vars(arm.friction).values()):
        assert array.shape == (size,)
        assert not array.flags.writeable
    assert (arm.limits.hard_lower <= arm.limits.lower).all()
    assert (arm.limits.upper <= arm.limits.hard_upper).all()
