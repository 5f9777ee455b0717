"""What the engine itself makes of a robot's description, apart from the model: joints, limits, tool pose, gravity.

Two engines read the same URDF. Where they disagree, nothing that is planned with the one holds in the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pybullet
from numpy.typing import ArrayLike

from pft_exec.exceptions import SimulationError
from pft_exec.geometry import Array, Pose
from pft_exec.model import RobotModel
from pft_exec.simulation.engine import Engine, simulation_errors

_STEP = 1e-3  # s
_LOCK = 1e4  # N m; holds the joints that are not of the arm


@dataclass(frozen=True, eq=False)
class ArmReading:
    """One arm as the engine has it.

    Parameters
    ----------
    missing : tuple of str
        Joints of the arm that move nothing in the engine; then the rest is empty.
    lower, upper, torque, velocity : (n,), rad, N m, rad/s
        Limits of its joints.
    tool : Pose
        In the robot's base frame.
    acceleration : (n,), rad/s^2
        Of the arm at rest, without friction, under the torque that was given.
    """

    missing: tuple[str, ...]
    lower: Array
    upper: Array
    torque: Array
    velocity: Array
    tool: Pose
    acceleration: Array


def read_arm(robot: RobotModel, name: str, configuration: ArrayLike, torque: ArrayLike) -> ArmReading:
    """Load a robot into an engine of its own, put one arm into a configuration, and let a torque act for one step.

    Parameters
    ----------
    robot : RobotModel
    name : str
        Of the arm.
    configuration : (n,), rad
    torque : (n,), N m

    Raises
    ------
    SimulationError
        If PyBullet cannot load the robot, or it has no link of the tool's name.
    """
    arm, engine = robot.arm(name), Engine(_STEP, gui=False)
    client, path = engine.client, robot.description.urdf
    try:
        with simulation_errors(f"loading {path}"):
            flags = pybullet.URDF_USE_INERTIA_FROM_FILE
            body = pybullet.loadURDF(str(path), useFixedBase=True, flags=flags, physicsClientId=client)
        count = pybullet.getNumJoints(body, physicsClientId=client)
        infos = [pybullet.getJointInfo(body, index, physicsClientId=client) for index in range(count)]
        moving = {info[1].decode(): info for info in infos if info[2] != pybullet.JOINT_FIXED}
        links = {info[12].decode(): info[0] for info in infos}
        missing = tuple(joint for joint in arm.joint_names if joint not in moving)
        if missing:
            empty = np.empty(0)
            return ArmReading(missing, empty, empty, empty, empty, Pose(np.zeros(3)), empty)
        if arm.tool_frame not in links:
            raise SimulationError(f"{path} has no link named {arm.tool_frame!r} for the tool of arm {name!r}.")
        joints = [moving[joint][0] for joint in arm.joint_names]
        for index, value in zip(joints, np.asarray(configuration, dtype=float), strict=True):
            pybullet.resetJointState(body, index, float(value), physicsClientId=client)
        tool = pybullet.getLinkState(body, links[arm.tool_frame], computeForwardKinematics=1, physicsClientId=client)
        limits = np.array([moving[joint][8:12] for joint in arm.joint_names], dtype=float)
        others = [info[0] for info in moving.values() if info[0] not in joints]
        acceleration = _accelerated(client, body, joints, others, torque)
    finally:
        engine.close()
    return ArmReading((), limits[:, 0], limits[:, 1], limits[:, 2], limits[:, 3], Pose(*tool[4:6]), acceleration)


def _accelerated(client: int, body: int, joints: Sequence[int], others: Sequence[int], torque: ArrayLike) -> Array:
    """Acceleration (n,) of joints at rest under a torque; the other joints are locked."""
    for link in range(-1, pybullet.getNumJoints(body, physicsClientId=client)):
        pybullet.changeDynamics(
            body, link, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, physicsClientId=client
        )
    for index in [*joints, *others]:
        lock = 0.0 if index in joints else _LOCK
        pybullet.setJointMotorControl2(
            body, index, pybullet.VELOCITY_CONTROL, targetVelocity=0.0, force=lock, physicsClientId=client
        )
    for index, value in zip(joints, np.asarray(torque, dtype=float), strict=True):
        pybullet.setJointMotorControl2(body, index, pybullet.TORQUE_CONTROL, force=float(value), physicsClientId=client)
    pybullet.stepSimulation(physicsClientId=client)
    states = pybullet.getJointStates(body, joints, physicsClientId=client)
    acceleration: Array = np.array([state[1] for state in states]) / _STEP
    return acceleration
