"""Objects of a task as rigid bodies: furniture that stands fixed, and objects that can be pushed about."""

from __future__ import annotations

import pybullet

from pft_exec.description import BoxShape, CylinderShape, ObjectDescription
from pft_exec.geometry import Pose
from pft_exec.simulation.engine import Engine

_SPINNING_FRICTION = 0.01  # keeps a held object from turning about the line between the fingers; measured to hold


class ObjectBody:
    """One object in an engine; its frame stands in the middle of its shape.

    Parameters
    ----------
    engine : Engine
    description : ObjectDescription
    pose : Pose
        World frame.
    """

    def __init__(self, engine: Engine, description: ObjectDescription, pose: Pose) -> None:
        self._client = engine.client
        self._fixed = pose if description.fixed is not None else None
        collision, visual = _shapes(description, self._client)
        self.body: int = pybullet.createMultiBody(
            baseMass=description.mass if self._fixed is None else 0.0,
            baseCollisionShapeIndex=collision,
            baseVisualShapeIndex=visual,
            basePosition=pose.position.tolist(),
            baseOrientation=pose.quaternion.tolist(),
            physicsClientId=self._client,
        )
        pybullet.changeDynamics(
            self.body,
            -1,
            lateralFriction=description.friction,
            spinningFriction=_SPINNING_FRICTION,
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

    def place(self, pose: Pose) -> None:
        """Set up: put it, at rest, at a pose, world frame."""
        pybullet.resetBasePositionAndOrientation(
            self.body, pose.position.tolist(), pose.quaternion.tolist(), physicsClientId=self._client
        )


def _shapes(description: ObjectDescription, client: int) -> tuple[int, int]:
    """Collision and visual shape of an object."""
    shape, color = description.shape, [*description.color, 1.0]
    if isinstance(shape, BoxShape):
        half = [0.5 * length for length in shape.size]
        box = pybullet.GEOM_BOX
        return (
            pybullet.createCollisionShape(box, halfExtents=half, physicsClientId=client),
            pybullet.createVisualShape(box, halfExtents=half, rgbaColor=color, physicsClientId=client),
        )
    return _cylinder(shape, color, client)


def _cylinder(shape: CylinderShape, color: list[float], client: int) -> tuple[int, int]:
    cylinder = pybullet.GEOM_CYLINDER
    return (
        pybullet.createCollisionShape(cylinder, radius=shape.radius, height=shape.height, physicsClientId=client),
        pybullet.createVisualShape(
            cylinder, radius=shape.radius, length=shape.height, rgbaColor=color, physicsClientId=client
        ),
    )
