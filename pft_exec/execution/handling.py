"""Handling: what the gripper of a run holds, by the physics, sample by sample; it belongs to the arm's model.

An object enters the model when both pads press on it and leaves when the gripper opens or has lost it. On the way it
is watched how far the object slips and where the tool has been: what a verdict on the motion needs.
"""

from __future__ import annotations

import numpy as np

from pft_exec.description import Measured
from pft_exec.geometry import Array, Pose, geodesic_distance
from pft_exec.model import Arm
from pft_exec.simulation import World

STEADY = 0.2
"""s after which a grasp has settled; from then on an object that moves in the gripper slips."""
LOST = 0.1
"""s without contact of both pads after which an object is no longer held."""


class Handling:
    """What an arm handles during one run.

    Parameters
    ----------
    world : World
        Set up; what the gripper holds now belongs to the arm's model at once.
    name : str
        Of the arm.
    """

    def __init__(self, world: World, name: str) -> None:
        self._world, self._name = world, name
        self._bare: Arm = world.arm(name)
        self.arm: Arm = self._bare
        self.held: str | None = None
        self.slip = 0.0
        """m; most that the held object's middle, or what of it was at the tool, has moved against the tool."""
        self.turned = 0.0
        """rad; most that it has turned against the tool."""
        self._path: list[Array] = []
        self._since = self._seen = world.time
        self._grip: Pose | None = None
        if world.held(name) is not None:
            self._take(world.held(name))
            self._grip = self._pose_in(world.true_tool(name))

    def update(self) -> None:
        """Look again; once a sample."""
        world, now = self._world, self._world.time
        tool = world.true_tool(self._name)
        self._path.append(tool.position)
        touched = world.held(self._name) if world.is_gripper_closed(self._name) else None
        if touched is not None and touched == self.held:
            self._seen = now
            self._watch_slip(now, tool)
        elif self.held is None or not world.is_gripper_closed(self._name) or now - self._seen > LOST:
            self._take(touched)

    def _take(self, held: str | None) -> None:
        """From now on another object, or none, is held."""
        if held == self.held:
            return
        self.held, self._grip = held, None
        self._since = self._seen = self._world.time
        self.arm = self._bare
        if held is not None:
            self.slip = self.turned = 0.0
            self.arm = self._bare.with_payload(*self._world.load(held, self._name))

    def _watch_slip(self, now: float, tool: Pose) -> None:
        """Compare the object's pose in the tool's frame with the one it was grasped in.

        What turns about the pads keeps the point between them and moves its middle; what turns about its middle, the
        other way round: so both are looked at. What both pads do together, such as give way under a weight, counts.
        """
        if self._grip is None:
            if now - self._since >= STEADY:
                self._grip = self._pose_in(tool)
            return
        now_in_tool = self._pose_in(tool)
        motion = now_in_tool @ self._grip.inverse()
        middle = float(np.linalg.norm(now_in_tool.position - self._grip.position))
        between_pads = float(np.linalg.norm(motion.position))
        self.slip = max(self.slip, middle, between_pads)
        self.turned = max(self.turned, float(geodesic_distance(now_in_tool.quaternion, self._grip.quaternion)))

    def _pose_in(self, tool: Pose) -> Pose:
        """Of the held object, in the tool's frame."""
        if self.held is None:
            raise ValueError("nothing is held.")
        return tool.inverse() @ self._world.pose(self.held)

    def measured(self) -> Measured:
        """What a verdict on the run so far needs."""
        world = self._world
        return Measured(
            path=np.array(self._path).reshape(-1, 3),
            held=world.held(self._name),
            slip=self.slip,
            liquid=world.liquid,
            speed={name: world.speed(name) for name in world.task.placed},
        )
