"""The surroundings of an arm: objects of the scene, and the robot's other arms, as obstacles that may move."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pft_exec.exceptions import MissingObjectError
from pft_exec.geometry import Pose, relative_rotation_vector, rotate
from pft_exec.model import Obstacle, task_obstacles
from pft_exec.simulation import World

LOOK_PERIOD = 0.02
"""s; how often the scene is looked at."""
STILL = (0.005, 0.02)
"""m/s, rad/s; slower than this counts as standing still."""


class Surroundings:
    """What an arm keeps off.

    Parameters
    ----------
    world : World
    arm : str
    names : sequence of str
        Objects and furniture of the task. What the arm must touch is not to be among them.
    other_arms : bool
        Whether the links of the robot's other arms are obstacles too.

    Raises
    ------
    MissingObjectError
        If the task has no object of such a name.
    """

    def __init__(self, world: World, arm: str, names: Sequence[str], other_arms: bool = True) -> None:
        for name in names:
            if name not in world.task.objects:
                raise MissingObjectError("object of the task", name, world.task.objects)
        self._world, self._names = world, frozenset(names)
        self._others = [name for name in world.robot.arms if name != arm] if other_arms else []
        self._seen: dict[int, tuple[float, Pose]] = {}
        self._due = -np.inf

    @property
    def is_due(self) -> bool:
        """Whether it is time to look again."""
        return self._world.time >= self._due - 1e-9

    def look(self) -> tuple[Obstacle, ...]:
        """Obstacles now, in the robot's base frame, with velocities from this look and the last."""
        self._due = self._world.time + LOOK_PERIOD
        leave_out = tuple(name for name in self._world.task.objects if name not in self._names)
        objects = task_obstacles(self._world.task, self._world.scene.objects, leave_out)
        found = [obstacle.seen_from(self._world.base) for obstacle in objects]
        for name in self._others:
            model = self._world.robot.arm(name)
            rotation, translation, _ = model.joint_frames(self._world.state(name)[0])
            found += model.geometry.obstacles(rotation, translation)
        return tuple(self._moving(k, obstacle) for k, obstacle in enumerate(found))

    def _moving(self, place: int, obstacle: Obstacle) -> Obstacle:
        """The obstacle with the velocity that it has had since the last look."""
        now, pose = self._world.time, obstacle.pose
        before, earlier = self._seen.get(place, (now, pose))
        self._seen[place] = (now, pose)
        if now <= before:
            return obstacle
        linear = (pose.position - earlier.position) / (now - before)
        turn = relative_rotation_vector(earlier.quaternion, pose.quaternion)
        angular = rotate(earlier.quaternion, turn) / (now - before)
        linear = linear if np.linalg.norm(linear) > STILL[0] else np.zeros(3)
        angular = angular if np.linalg.norm(angular) > STILL[1] else np.zeros(3)
        return Obstacle(obstacle.name, obstacle.solid, pose, np.concatenate([linear, angular]))
