"""The floor of the room: for the eye alone, since everything in it stands fixed or on furniture."""

from __future__ import annotations

import pybullet

from pft_exec.simulation.engine import Engine

_TILE = 0.5  # m
_TILES = 12  # along each side
_COLORS = ((0.80, 0.81, 0.83, 1.0), (0.72, 0.73, 0.76, 1.0))


def build_floor(engine: Engine) -> None:
    """Lay tiles of two colors; a single large box would show its two triangles."""
    for row in range(_TILES):
        for column in range(_TILES):
            shape = pybullet.createVisualShape(
                pybullet.GEOM_BOX,
                halfExtents=[0.5 * _TILE, 0.5 * _TILE, 0.005],
                rgbaColor=_COLORS[(row + column) % 2],
                physicsClientId=engine.client,
            )
            position = [(row - 0.5 * _TILES + 0.5) * _TILE, (column - 0.5 * _TILES + 0.5) * _TILE, -0.005]
            pybullet.createMultiBody(baseVisualShapeIndex=shape, basePosition=position, physicsClientId=engine.client)
