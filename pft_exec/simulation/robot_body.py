"""The robot's body in the physics engine: joints sensed and driven by torque, arms braked or released, grippers.

The only place where joint states come out of the engine (`RobotBody.sense`) and joint torques go into it
(`RobotBody.actuate`); what sensors and motors get wrong (`disturbance`) enters at these two places.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pybullet

from pft_exec.description import GripperDescription
from pft_exec.exceptions import SimulationError
from pft_exec.geometry import Array, Pose
from pft_exec.model import Arm, RobotModel
from pft_exec.simulation.disturbance import Disturbance, Encoder, Mismatch
from pft_exec.simulation.engine import Engine, simulation_errors
from pft_exec.simulation.gripper import GripperDrive
from pft_exec.simulation.joint_motors import JointMotors
from pft_exec.simulation.pads import make_pad

LEAST_PRESS = 0.5
"""N; a lighter touch is no grip."""


class RobotBody:
    """A robot loaded into an engine; every arm is braked until it is released.

    Parameters
    ----------
    engine : Engine
    robot : RobotModel
    base : Pose
        Of the robot's base frame, world frame.
    mismatch : Mismatch or None
        How it differs from its model; None: not at all.
    steps_per_period : int
        Physics steps in a control period.

    Raises
    ------
    SimulationError
        If PyBullet cannot load the URDF, or the URDF lacks a joint of an arm.
    """

    def __init__(
        self,
        engine: Engine,
        robot: RobotModel,
        base: Pose,
        mismatch: Mismatch | None = None,
        steps_per_period: int = 1,
    ) -> None:
        self._client = engine.client
        self._physics_step = engine.physics_step
        self._steps_per_period = steps_per_period
        self._arms: dict[str, Arm] = {name: robot.arm(name) for name in robot.arms}
        self._grippers: dict[str, GripperDescription] = {
            name: arm.gripper for name, arm in robot.description.arms.items() if arm.gripper is not None
        }
        with simulation_errors(f"loading {robot.description.urdf}"):
            self.body: int = pybullet.loadURDF(
                str(robot.description.urdf),
                base.position.tolist(),
                base.quaternion.tolist(),
                useFixedBase=True,
                flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
                physicsClientId=self._client,
            )
        self._motors = JointMotors(self._client, self.body)
        self._find_joints(robot)
        self._prepare_joints()
        self._clear_commands()
        if mismatch is not None:
            self.disturb(mismatch)

    def _find_joints(self, robot: RobotModel) -> None:
        """Order the moving joints arm by arm, then fingers, then the rest, so that each group is a slice."""
        count = pybullet.getNumJoints(self.body, physicsClientId=self._client)
        infos = [pybullet.getJointInfo(self.body, index, physicsClientId=self._client) for index in range(count)]
        moving = {info[1].decode(): index for index, info in enumerate(infos) if info[2] != pybullet.JOINT_FIXED}
        self._links = {info[12].decode(): index for index, info in enumerate(infos)}
        names: list[str] = []
        self._columns: dict[str, slice] = {}
        self._fingers: dict[str, slice] = {}
        for name, arm in self._arms.items():
            self._columns[name] = _append(names, arm.joint_names)
        for name, gripper in self._grippers.items():
            self._fingers[name] = _append(names, gripper.joints)
        missing = [name for name in names if name not in moving]
        if missing:
            raise SimulationError(f"{robot.description.urdf} has no moving joint named {missing[0]!r}.")
        self.joint_names = tuple(names + [name for name in moving if name not in names])
        self._indices = [moving[name] for name in self.joint_names]
        self._home = slice(len(names), len(self.joint_names))

    def _prepare_joints(self) -> None:
        """Motors off, damping of the engine off, friction and damping of the joints as described."""
        for link in range(-1, pybullet.getNumJoints(self.body, physicsClientId=self._client)):
            pybullet.changeDynamics(
                self.body,
                link,
                linearDamping=0.0,
                angularDamping=0.0,
                jointDamping=0.0,
                physicsClientId=self._client,
            )
        for name, arm in self._arms.items():
            for index, viscous in zip(self._indices[self._columns[name]], arm.friction.viscous, strict=True):
                pybullet.changeDynamics(self.body, index, jointDamping=viscous, physicsClientId=self._client)
        for fingers in self._fingers.values():
            for index in self._indices[fingers]:
                make_pad(self._client, self.body, index)
        self._motors.rub(self._indices, np.zeros(len(self._indices)))

    def _clear_commands(self) -> None:
        count = len(self._indices)
        self._torque = np.zeros(count)
        self._extra = np.zeros(count)
        self._is_pushed = False
        self._state: tuple[Array, Array] | None = None
        self._disturbance: Disturbance | None = None
        self._encoders: dict[str, Encoder] = {}
        self._reported: dict[str, tuple[Array, Array]] = {}
        self._released: dict[str, Arm] = {}
        self._braking: set[str] = set()
        self._width_goal = {name: gripper.closed_width for name, gripper in self._grippers.items()}
        self._width = dict(self._width_goal)
        self._drives = {name: GripperDrive(force=item.force.values[0]) for name, item in self._grippers.items()}
        for name in self._arms:
            self.brake(name)
        self._lock(self._home)

    def sense(self) -> tuple[Array, Array]:
        """Positions and velocities (J,) of all joints in the order of `joint_names`, rad or m, and per second."""
        if self._state is None:
            states = pybullet.getJointStates(self.body, self._indices, physicsClientId=self._client)
            self._state = np.array([state[0] for state in states]), np.array([state[1] for state in states])
        return self._state

    def arm_state(self, arm: str) -> tuple[Array, Array]:
        """Configuration and velocity (n,) of an arm as its encoders report them, rad and rad/s."""
        if arm not in self._reported:
            self._reported[arm] = self._report(arm)
        q, v = self._reported[arm]
        return q.copy(), v.copy()

    def true_state(self, arm: str) -> tuple[Array, Array]:
        """Configuration and velocity (n,) of an arm as they are, rad and rad/s; no controller may see them."""
        q, v = self.sense()
        columns = self._columns[arm]
        return q[columns].copy(), v[columns].copy()

    def _report(self, arm: str) -> tuple[Array, Array]:
        q, v = self.true_state(arm)
        if self._disturbance is not None:
            q, v = self._disturbance.measured(self._columns[arm], q, v)
        return self._encoders[arm](q, v) if arm in self._encoders else (q, v)

    def set_encoder(self, arm: str, encoder: Encoder | None) -> None:
        """Let an arm's encoders report something else; None mends them."""
        self._encoders.pop(arm, None)
        if encoder is not None:
            self._encoders[arm] = encoder
        self._reported.clear()

    def disturb(self, mismatch: Mismatch) -> None:
        """Let the plant differ from its model from now on."""
        self._disturbance = Disturbance(mismatch, len(self._indices), self._steps_per_period)
        self._reported.clear()
        for name, arm in self._arms.items():
            for index, viscous in zip(self._indices[self._columns[name]], arm.friction.viscous, strict=True):
                damping = mismatch.friction * viscous
                pybullet.changeDynamics(self.body, index, jointDamping=damping, physicsClientId=self._client)
            self._load_tool(arm.tool_frame, mismatch.payload)
        for name in self._released:
            self._disturbance.hold(name, self._torque[self._columns[name]].copy())
            (self.brake_by_motors if name in self._braking else self._rub)(name)

    def _load_tool(self, link: str, mass: float) -> None:
        """Make the massless link of a tool a point mass: it weighs, and resists acceleration, as a real load does."""
        pybullet.changeDynamics(
            self.body,
            self._links[link],
            mass=mass,
            localInertiaDiagonal=[0.0] * 3,
            physicsClientId=self._client,
        )

    def command(self, arm: str, torque: Array) -> None:
        """Set the motor torque (n,), N m, until it is set again, clipped at the limits; releases the brake."""
        if self.is_braked(arm):
            self._release(arm)
        limit = self._arms[arm].limits.torque
        if self._disturbance is not None:
            limit = self._disturbance.mismatch.strength * limit
        self._torque[self._columns[arm]] = np.minimum(np.maximum(torque, -limit), limit)

    def torque(self, arm: str) -> Array:
        """Motor torque (n,), N m, that acts in the coming step: the command, clipped; zero in an arm that is parked.

        Of an arm that brakes by its motors: what acted in the step before.
        """
        torque = self._torque[self._columns[arm]]
        if arm in self._braking:
            return torque + self._braking_torque(arm)
        return torque.copy() if arm in self._released else np.zeros_like(torque)

    def push(self, arm: str, wrench: Array) -> None:
        """Add a wrench (6,) at the tool for the coming step: force, N, then torque, N m, in the base frame.

        Notes
        -----
        On a chain with a fixed base a wrench at the tool is, exactly, the joint torque ``J^T F``; that way it does not
        depend on link poses that the engine keeps one step late.
        """
        q, _ = self.true_state(arm)
        self._extra[self._columns[arm]] += self._arms[arm].jacobian(q).T @ wrench
        self._is_pushed = True

    def actuate(self) -> None:
        """Apply motors, counterbalance, pushes and grippers for the coming step."""
        q, v = self.sense()
        total = self._torque.copy()
        for name, arm in self._released.items():
            columns = self._columns[name]
            if self._disturbance is not None and name not in self._braking:
                total[columns] = self._disturbance.delivered(name, columns, total[columns], q[columns])
            total[columns] += arm.counterbalance(q[columns])
        for name in self._grippers:
            total[self._fingers[name]] = self._finger_forces(name, q, v)
        if self._is_pushed:
            total += self._extra
            self._extra[:] = 0.0
            self._is_pushed = False
        self._motors.drive(self._indices, total)
        if self._disturbance is not None:
            self._disturbance.advance()
        self._forget_state()

    def _forget_state(self) -> None:
        self._state = None
        self._reported.clear()

    def _finger_forces(self, name: str, q: Array, v: Array) -> tuple[float, float]:
        drive, fingers = self._drives[name], self._fingers[name]
        step = drive.speed * self._physics_step
        width = self._width[name]
        width += min(max(self._width_goal[name] - width, -step), step)
        self._width[name] = width
        left, right = q[fingers].tolist()
        left_rate, right_rate = v[fingers].tolist()
        return drive.forces(width, (left, right), (left_rate, right_rate))

    def width(self, arm: str) -> float:
        """Distance between the pads of an arm's gripper, m."""
        return float(self.sense()[0][self._fingers[arm]].sum())

    def set_width(self, arm: str, width: float) -> None:
        """Ask the gripper for a distance between its pads, m."""
        gripper = self._grippers[arm]
        if not gripper.closed_width <= width <= gripper.open_width:
            raise SimulationError(
                f"the gripper of arm {arm!r} opens from {gripper.closed_width} to {gripper.open_width} m; "
                f"got {width} m."
            )
        self._width_goal[arm] = float(width)
        if width > self._width[arm]:  # what was pressed on is let go at once, from where the pads are
            self._width[arm] = min(max(self._width[arm], self.width(arm)), float(width))

    def place_gripper(self, arm: str, width: float | None = None) -> None:
        """Set up: open a gripper, or put its pads at a distance, m, and let them press on from there at once."""
        gripper = self._grippers[arm]
        goal = gripper.open_width if width is None else gripper.closed_width
        self._reset_joints(self._fingers[arm], np.full(2, 0.5 * (goal if width is None else width)))
        self._width_goal[arm] = self._width[arm] = goal

    def touching(self, arm: str) -> frozenset[int]:
        """Bodies that both pads of an arm's gripper press on."""
        if arm not in self._fingers:
            return frozenset()
        left, right = (self._pressed_by(index) for index in self._indices[self._fingers[arm]])
        return left & right

    def _pressed_by(self, finger: int) -> frozenset[int]:
        contacts = pybullet.getContactPoints(bodyA=self.body, linkIndexA=finger, physicsClientId=self._client)
        return frozenset(contact[2] for contact in contacts if contact[9] > LEAST_PRESS) - {self.body}

    def is_closing(self, arm: str) -> bool:
        """Whether the arm's gripper is asked to be less than half open."""
        return arm in self._grippers and self._width_goal[arm] < 0.5 * self._grippers[arm].open_width

    def palm(self, arm: str) -> int:
        """Index of the link that an arm's fingers slide on, in the engine."""
        return int(
            pybullet.getJointInfo(self.body, self._indices[self._fingers[arm]][0], physicsClientId=self._client)[16]
        )

    def has_gripper(self, arm: str) -> bool:
        """Whether the arm has fingers."""
        return arm in self._grippers

    def place(self, arm: str, configuration: Array) -> None:
        """Set up: put an arm, at rest and braked, into a configuration (n,), rad."""
        self._reset_joints(self._columns[arm], configuration)
        self.brake(arm)

    def place_joints(self, positions: Array) -> None:
        """Show: put every joint (J,), in the order of `joint_names`, where it was once recorded."""
        self._reset_joints(slice(0, len(self._indices)), positions)

    def brake(self, arm: str) -> None:
        """Lock an arm where it is.

        Notes
        -----
        The lock is a position motor of PyBullet. It is given the gravity torque, so that it has nothing to do and the
        solver settles at once; without that a step takes half as long again.
        """
        columns = self._columns[arm]
        self._released.pop(arm, None)
        self._braking.discard(arm)
        self._torque[columns] = self._arms[arm].gravity(self.sense()[0][columns])
        self._lock(columns)

    def brake_by_motors(self, arm: str) -> None:
        """Go on with the torque last commanded, and brake as dry friction does, together within the motors' limits.

        Notes
        -----
        The drives do so by themselves: it needs no encoder. Friction takes energy away only, so that nothing swings.
        An arm that is locked stays locked.
        """
        if arm in self._released:
            self._braking.add(arm)
            columns = self._columns[arm]
            self._motors.rub(self._indices[columns], self._friction(arm) + self._spare(arm))

    def _spare(self, arm: str) -> Array:
        """What the motors can do beside the torque they are given, (n,), N m."""
        strength = 1.0 if self._disturbance is None else self._disturbance.mismatch.strength
        limit = strength * self._arms[arm].limits.torque
        return np.maximum(limit - np.abs(self._torque[self._columns[arm]]), 0.0)

    def _braking_torque(self, arm: str) -> Array:
        """What of dry friction, (n,), N m, is the motors', in the step before."""
        spare = self._spare(arm)
        share: Array = np.clip(self._motors.rubbing(self._indices[self._columns[arm]]), -spare, spare)
        return share

    def is_braked(self, arm: str) -> bool:
        """Whether the arm is locked, or brakes by its motors."""
        return arm not in self._released or arm in self._braking

    def _release(self, arm: str) -> None:
        model = self._arms[arm]
        self._released[arm] = model
        self._braking.discard(arm)
        if self._disturbance is not None:
            q = self.sense()[0][self._columns[arm]]
            self._disturbance.hold(arm, model.gravity(q) - model.counterbalance(q))
        self._rub(arm)

    def _rub(self, arm: str) -> None:
        """Set the Coulomb friction of a released arm."""
        self._motors.rub(self._indices[self._columns[arm]], self._friction(arm))

    def _friction(self, arm: str) -> Array:
        """Coulomb friction (n,), N m, of an arm's joints."""
        factor = 1.0 if self._disturbance is None else self._disturbance.mismatch.friction
        friction: Array = factor * self._arms[arm].friction.coulomb
        return friction

    def _lock(self, columns: slice) -> None:
        self._motors.lock(self._indices[columns], self.sense()[0][columns])

    def _reset_joints(self, columns: slice, positions: Array) -> None:
        for index, position in zip(self._indices[columns], positions, strict=True):
            pybullet.resetJointState(self.body, index, float(position), 0.0, physicsClientId=self._client)
        self._forget_state()


def _append(names: list[str], more: Sequence[str]) -> slice:
    """Append names and return the slice that they take."""
    start = len(names)
    names.extend(more)
    return slice(start, len(names))
