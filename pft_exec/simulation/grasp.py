"""Grasps: which object an arm's gripper holds, how it is put there at set-up, and what it weighs.

By default friction between the pads holds an object, and nothing else. With ``grasp="constraint"`` a fixed joint
between palm and object is added once both pads press on it, and taken away when the gripper is told to open: for
whoever studies motions and not grasps.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, get_args

import numpy as np
import pybullet

from pft_exec.exceptions import UnknownNameError
from pft_exec.geometry import Pose
from pft_exec.simulation.engine import Engine
from pft_exec.simulation.object_body import ObjectBody
from pft_exec.simulation.robot_body import RobotBody
from pft_exec.simulation.shapes import half_width, turned_axis

GraspKind = Literal["friction", "constraint"]

_CLOSING_AXIS = np.array([0.0, 1.0, 0.0])  # of the tool's frame, along which the pads close
_CONSTRAINT_FORCE = 200.0  # N; 20 to 1000 hold alike (measured)
_PRESSED = 2e-4  # m; by how much less than its width the pads stand apart when an object is put between them


class Grasps:
    """What the grippers of a robot hold.

    Parameters
    ----------
    engine : Engine
    robot : RobotBody
    objects : mapping of name to ObjectBody
    kind : "friction" or "constraint"

    Raises
    ------
    UnknownNameError
        If there is no such kind.
    """

    def __init__(
        self, engine: Engine, robot: RobotBody, objects: Mapping[str, ObjectBody], kind: str = "friction"
    ) -> None:
        if kind not in get_args(GraspKind):
            raise UnknownNameError("kind of grasp", kind, get_args(GraspKind))
        self._client = engine.client
        self._robot, self._objects = robot, objects
        self._names = {item.body: name for name, item in objects.items() if item.description.mass > 0.0}
        self._kind = kind
        self._joints: dict[str, tuple[str, int]] = {}

    def held(self, arm: str) -> str | None:
        """Name of the object that both pads press on, and that can move; the first by name of several."""
        if arm in self._joints:
            return self._joints[arm][0]
        names = sorted(self._names[body] for body in self._robot.touching(arm) if body in self._names)
        return names[0] if names else None

    def put(self, arm: str, name: str, tool: Pose) -> None:
        """Set up: close the gripper, whose tool stands at a pose, world frame, about an object where that is."""
        item = self._objects[name]
        axis = turned_axis(item.pose, tool.rotation @ _CLOSING_AXIS)
        width = 2.0 * half_width(item.description.shape, axis) - _PRESSED
        self._robot.place_gripper(arm, width)

    def update(self, arm: str) -> None:
        """Add the fixed joint of a grasp by constraint where one is due, and take it away where none is."""
        if self._kind != "constraint":
            return
        is_closing = self._robot.is_closing(arm)
        if arm in self._joints and not is_closing:
            pybullet.removeConstraint(self._joints.pop(arm)[1], physicsClientId=self._client)
        elif arm not in self._joints and is_closing:
            name = self.held(arm)
            if name is not None:
                self._joints[arm] = name, self._joined(arm, self._objects[name])

    def _joined(self, arm: str, item: ObjectBody) -> int:
        """A fixed joint between palm and object as they stand; both frames at the centers of mass."""
        palm = self._robot.palm(arm)
        state = pybullet.getLinkState(
            self._robot.body, palm, computeForwardKinematics=True, physicsClientId=self._client
        )
        relative = Pose(state[0], state[1]).inverse() @ item.pose
        joint: int = pybullet.createConstraint(
            self._robot.body,
            palm,
            item.body,
            -1,
            pybullet.JOINT_FIXED,
            [0, 0, 0],
            relative.position.tolist(),
            [0, 0, 0],
            relative.quaternion.tolist(),
            physicsClientId=self._client,
        )
        pybullet.changeConstraint(joint, maxForce=_CONSTRAINT_FORCE, physicsClientId=self._client)
        return joint
