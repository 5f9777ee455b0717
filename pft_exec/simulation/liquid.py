"""Liquid as small balls in a vessel: enough to see whether something was poured, few enough to be quick."""

from __future__ import annotations

import math

import numpy as np
import pybullet

from pft_exec.description import LiquidDescription, VesselShape
from pft_exec.exceptions import SimulationError
from pft_exec.geometry import Array
from pft_exec.simulation.engine import Engine

_GAP = 1.05  # of a ball's diameter, between balls as they are put into a vessel


class Liquid:
    """Balls in an engine.

    Parameters
    ----------
    engine : Engine
    description : LiquidDescription
    places : (S, 3), m, world frame
    """

    def __init__(self, engine: Engine, description: LiquidDescription, places: Array) -> None:
        self._client = engine.client
        self._mass = description.mass
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_SPHERE, radius=description.radius, physicsClientId=self._client
        )
        seen = pybullet.createVisualShape(
            pybullet.GEOM_SPHERE,
            radius=description.radius,
            rgbaColor=[*description.color, 1.0],
            physicsClientId=self._client,
        )
        self.bodies = [self._ball(description, shape, seen, place) for place in places]

    @property
    def mass(self) -> float:
        """Of each ball, kg."""
        return self._mass

    def _ball(self, description: LiquidDescription, shape: int, seen: int, place: Array) -> int:
        body: int = pybullet.createMultiBody(
            baseMass=description.mass,
            baseCollisionShapeIndex=shape,
            baseVisualShapeIndex=seen,
            basePosition=place.tolist(),
            physicsClientId=self._client,
        )
        pybullet.changeDynamics(
            body,
            -1,
            lateralFriction=description.friction,
            rollingFriction=0.0,
            spinningFriction=0.0,
            linearDamping=0.0,
            angularDamping=0.0,
            physicsClientId=self._client,
        )
        return body

    @property
    def positions(self) -> Array:
        """Where the balls are now, (S, 3), m, world frame."""
        poses = [pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client) for body in self.bodies]
        return np.array([position for position, _ in poses])

    def place(self, positions: Array) -> None:
        """Show: put the balls where they once were, (S, 3), m, world frame."""
        for body, position in zip(self.bodies, positions, strict=True):
            pybullet.resetBasePositionAndOrientation(
                body, position.tolist(), [0.0, 0.0, 0.0, 1.0], physicsClientId=self._client
            )


def places_in(description: LiquidDescription, vessel: VesselShape) -> Array:
    """Middles (S, 3), m, in the vessel's frame, of balls that fill it from its floor up: rings, layer by layer.

    Raises
    ------
    SimulationError
        If they do not fit in.
    """
    room = vessel.radius - vessel.wall - _GAP * description.radius
    step = 2.0 * _GAP * description.radius
    ring = max(room, 0.0)
    around = max(1, math.floor(math.pi / math.asin(min(1.0, 0.5 * step / ring)))) if ring > 0.5 * step else 1
    places = []
    for index in range(description.count):
        layer, angle = divmod(index, around)
        turn = 2.0 * math.pi * (angle + 0.5 * (layer % 2)) / around
        height = -0.5 * vessel.height + vessel.wall + (layer + 0.5) * step
        radius = ring if around > 1 else 0.0
        places.append([radius * math.cos(turn), radius * math.sin(turn), height])
    top = places[-1][2] + description.radius
    if room < 0.0 or top > 0.5 * vessel.height:
        raise SimulationError(f"{description.count} balls of {description.radius} m do not fit into the vessel.")
    return np.array(places)
