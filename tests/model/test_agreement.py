"""The model and the simulator are the same mechanism: gravity, mass matrix, one step, tool pose."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pybullet
import pytest

from pft_exec.geometry import Array, geodesic_distance, normalize_quaternion
from pft_exec.model import Arm, RobotModel

STEP = 1e-3  # s


class Twin:
    """The robot in PyBullet; all joints but the arm's stand at zero. Dynamics calls take lists: arrays crash them."""

    def __init__(self, robot: RobotModel, arm: Arm) -> None:
        self.client = pybullet.connect(pybullet.DIRECT)
        self.body = pybullet.loadURDF(
            str(robot.description.urdf),
            useFixedBase=True,
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
            physicsClientId=self.client,
        )
        pybullet.setGravity(0, 0, -9.81, physicsClientId=self.client)
        pybullet.setTimeStep(STEP, physicsClientId=self.client)
        pybullet.changeDynamics(self.body, -1, linearDamping=0, angularDamping=0, physicsClientId=self.client)
        every = range(pybullet.getNumJoints(self.body, physicsClientId=self.client))
        self.infos = [pybullet.getJointInfo(self.body, index, physicsClientId=self.client) for index in every]
        self.movable = [info[0] for info in self.infos if info[2] != pybullet.JOINT_FIXED]
        by_name = {info[1].decode(): info[0] for info in self.infos}
        by_link = {info[12].decode(): info[0] for info in self.infos}
        self.joints = [by_name[name] for name in arm.joint_names]
        self.places = [self.movable.index(joint) for joint in self.joints]
        self.tool = by_link[arm.tool_frame]
        for joint in self.movable:
            pybullet.setJointMotorControl2(
                self.body, joint, pybullet.VELOCITY_CONTROL, force=0, physicsClientId=self.client
            )

    def spread(self, values: Array) -> list[float]:
        whole = np.zeros(len(self.movable))
        whole[self.places] = values
        return [float(value) for value in whole]

    def place(self, q: Array, v: Array) -> None:
        for joint, position, velocity in zip(self.movable, self.spread(q), self.spread(v), strict=True):
            pybullet.resetJointState(self.body, joint, position, velocity, physicsClientId=self.client)

    def inverse_dynamics(self, q: Array, v: Array, acceleration: Array) -> Array:
        lists = [self.spread(values) for values in (q, v, acceleration)]
        return np.array(pybullet.calculateInverseDynamics(self.body, *lists, physicsClientId=self.client))

    def mass_matrix(self, q: Array) -> Array:
        whole = np.array(pybullet.calculateMassMatrix(self.body, self.spread(q), physicsClientId=self.client))
        return whole[np.ix_(self.places, self.places)]

    def stepped(self, torque: Array) -> Array:
        """Velocity of the arm after one step with a torque on every movable joint."""
        for joint, value in zip(self.movable, torque, strict=True):
            pybullet.setJointMotorControl2(
                self.body, joint, pybullet.TORQUE_CONTROL, force=float(value), physicsClientId=self.client
            )
        pybullet.stepSimulation(physicsClientId=self.client)
        states = pybullet.getJointStates(self.body, self.joints, physicsClientId=self.client)
        return np.array([state[1] for state in states])


@pytest.fixture
def twin(robot_and_arm: tuple[RobotModel, Arm]) -> Iterator[Twin]:
    twin = Twin(*robot_and_arm)
    yield twin
    pybullet.disconnect(twin.client)


def test_gravity_torques_agree(arm: Arm, twin: Twin, states: list[tuple[Array, Array]]) -> None:
    for q, _ in states:
        expected = twin.inverse_dynamics(q, 0 * q, 0 * q)[twin.places]
        np.testing.assert_allclose(arm.gravity(q), expected, rtol=0, atol=1e-9)


def test_mass_matrices_agree(arm: Arm, twin: Twin, states: list[tuple[Array, Array]]) -> None:
    for q, _ in states:
        np.testing.assert_allclose(arm.mass_matrix(q), twin.mass_matrix(q), rtol=0, atol=1e-9)


def test_velocity_dependent_torques_agree(arm: Arm, twin: Twin, states: list[tuple[Array, Array]]) -> None:
    for q, v in states:
        expected = twin.inverse_dynamics(q, v, 0 * q)[twin.places]
        np.testing.assert_allclose(arm.dynamics(q, v).bias, expected, rtol=0, atol=1e-9)


def test_one_step_of_forward_dynamics_agrees(arm: Arm, twin: Twin, states: list[tuple[Array, Array]]) -> None:
    """A torque computed here makes the simulator accelerate as asked; other joints are held by theirs."""
    generator = np.random.default_rng(3)
    for q, v in states:
        asked = generator.normal(size=len(q))
        dynamics = arm.dynamics(q, v)
        torque = twin.inverse_dynamics(q, v, asked)
        torque[twin.places] = dynamics.mass_matrix @ asked + dynamics.bias
        twin.place(q, v)
        velocity = twin.stepped(torque)
        np.testing.assert_allclose(velocity, v + STEP * asked, rtol=0, atol=1e-9)


def test_tool_poses_agree(arm: Arm, twin: Twin, states: list[tuple[Array, Array]]) -> None:
    for q, v in states:
        twin.place(q, v)
        state = pybullet.getLinkState(twin.body, twin.tool, computeForwardKinematics=1, physicsClientId=twin.client)
        pose = arm.forward(q)
        np.testing.assert_allclose(pose.position, state[4], rtol=0, atol=1e-6)
        assert geodesic_distance(pose.quaternion, normalize_quaternion(state[5])) < 1e-6  # rad; single precision


def test_the_simulator_stops_at_the_hard_limits(arm: Arm, twin: Twin) -> None:
    infos = [twin.infos[joint] for joint in twin.joints]
    np.testing.assert_allclose([info[8] for info in infos], arm.limits.hard_lower, rtol=0, atol=1e-9)
    np.testing.assert_allclose([info[9] for info in infos], arm.limits.hard_upper, rtol=0, atol=1e-9)


def test_every_link_has_an_inertial_of_its_own(twin: Twin) -> None:
    """A link without one gets a mass of 1 kg in PyBullet."""
    frames = ("frame", "footprint", "plate")
    for info in twin.infos:
        mass = pybullet.getDynamicsInfo(twin.body, info[0], physicsClientId=twin.client)[0]
        assert (mass == 0.0) == info[12].decode().endswith(frames)
