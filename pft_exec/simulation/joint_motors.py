"""Joint motors of the physics engine: torques, dry friction and locks of a body's joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pybullet

from pft_exec.geometry import Array

LOCK_TORQUE = 1000.0
"""N m; what is parked stays, whatever comes."""


class JointMotors:
    """The motors of one body in an engine.

    Parameters
    ----------
    client : int
        Of the engine.
    body : int
    """

    def __init__(self, client: int, body: int) -> None:
        self._client, self._body = client, body

    def drive(self, indices: Sequence[int], torque: Array) -> None:
        """Apply a torque (k,), N m (of sliding joints: a force, N), in the coming step."""
        pybullet.setJointMotorControlArray(
            self._body, indices, pybullet.TORQUE_CONTROL, forces=torque.tolist(), physicsClientId=self._client
        )

    def rub(self, indices: Sequence[int], friction: Array) -> None:
        """Coulomb friction (k,), N m, as velocity motors towards rest: PyBullet ignores the friction of a URDF."""
        pybullet.setJointMotorControlArray(
            self._body,
            indices,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=[0.0] * len(indices),
            forces=friction.tolist(),
            physicsClientId=self._client,
        )

    def rubbing(self, indices: Sequence[int]) -> Array:
        """Torque (k,), N m, that friction had in the step before."""
        states = pybullet.getJointStates(self._body, indices, physicsClientId=self._client)
        return np.array([state[3] for state in states])

    def lock(self, indices: Sequence[int], positions: Array) -> None:
        """Hold joints at positions (k,), rad, with more than any motor has."""
        if not indices:
            return
        pybullet.setJointMotorControlArray(
            self._body,
            indices,
            pybullet.POSITION_CONTROL,
            targetPositions=positions,
            forces=[LOCK_TORQUE] * len(indices),
            physicsClientId=self._client,
        )
