"""Objects of a task as rigid bodies: furniture that stands fixed, and objects that can be pushed about."""

from __future__ import annotations

import numpy as np
import pybullet

from pft_exec.description import ObjectDescription
from pft_exec.geometry import Pose
from pft_exec.simulation.engine import Engine
from pft_exec.simulation.pads import SPINNING
from pft_exec.simulation.shapes import create_collision_shape, create_visual_shape, pieces_of


class ObjectBody:
    """One object in an engine; its frame stands in the middle of its shape.

    Parameters
    ----------
    engine : Engine
    description : ObjectDescription
    pose : Pose
        World frame.
    hollow : bool
        Whether a vessel is a shell, which something fits into; else it is solid, and only looks like one.
    """

    def __init__(self, engine: Engine, description: ObjectDescription, pose: Pose, hollow: bool = False) -> None:
        self._client = engine.client
        self.description = description
        is_fixed = description.fixed is not None or description.immovable
        self._fixed = pose if is_fixed else None
        color = [*description.color, 1.0]
        self.body: int = pybullet.createMultiBody(
            baseMass=0.0 if is_fixed else description.mass,
            baseCollisionShapeIndex=create_collision_shape(pieces_of(description.shape, hollow), self._client),
            baseVisualShapeIndex=create_visual_shape(pieces_of(description.shape, hollow=True), color, self._client),
            basePosition=pose.position.tolist(),
            baseOrientation=pose.quaternion.tolist(),
            physicsClientId=self._client,
        )
        pybullet.changeDynamics(
            self.body,
            -1,
            lateralFriction=description.friction,
            spinningFriction=SPINNING,
            rollingFriction=0.0,
            linearDamping=0.0,
            angularDamping=0.0,
            physicsClientId=self._client,
        )

    @property
    def pose(self) -> Pose:
        """Where it is now, world frame."""
        if self._fixed is not None:
            return self._fixed
        return Pose(*pybullet.getBasePositionAndOrientation(self.body, physicsClientId=self._client))

    @property
    def speed(self) -> float:
        """Of its middle, m/s."""
        return float(np.linalg.norm(pybullet.getBaseVelocity(self.body, physicsClientId=self._client)[0]))

    def place(self, pose: Pose) -> None:
        """Set up: put it, at rest, at a pose, world frame."""
        if self._fixed is not None:
            self._fixed = pose
        pybullet.resetBasePositionAndOrientation(
            self.body, pose.position.tolist(), pose.quaternion.tolist(), physicsClientId=self._client
        )
