"""The robot's base in the world: what an arm's model says in its base frame, told in the world's, and the other way."""

from __future__ import annotations

import numpy as np

from pft_exec.geometry import Array, Pose, conjugate, multiply, rotate
from pft_exec.model import ArmDynamics


class BaseFrame:
    """Where a robot's base stands; most stand at the world's origin, where nothing is to be computed.

    Parameters
    ----------
    pose : Pose
        Of the base, world frame.
    """

    def __init__(self, pose: Pose) -> None:
        self._pose = pose
        self._is_origin = pose == Pose(np.zeros(3))

    def to_world(self, pose: Pose) -> Pose:
        """A pose in the base frame, in the world frame."""
        return pose if self._is_origin else self._pose @ pose

    def motion_to_world(self, dynamics: ArmDynamics) -> tuple[Array, Array, Array]:
        """Position (3,), m, quaternion (4,), (x, y, z, w), and velocity (6,), m/s and rad/s, of a tool, world frame."""
        if self._is_origin:
            return dynamics.position, dynamics.quaternion, dynamics.velocity
        turn = self._pose.quaternion
        velocity = rotate(turn, dynamics.velocity.reshape(2, 3)).ravel()
        return self._pose.apply(dynamics.position), multiply(turn, dynamics.quaternion), velocity

    def wrench_from_world(self, wrench: Array) -> Array:
        """Force and torque (2, 3), N and N m, world frame, as one vector (6,) in the base frame."""
        turned = wrench if self._is_origin else rotate(conjugate(self._pose.quaternion), wrench)
        flat: Array = turned.ravel()
        return flat
