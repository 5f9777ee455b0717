"""The floor of the room: for the eye alone, since everything in it stands fixed or on furniture."""

from __future__ import annotations

import numpy as np
import pybullet

from pft_exec.simulation.engine import Engine

_TILE = 0.5  # m
_TILES = 14  # along each side
_COLORS = ((0.80, 0.81, 0.83, 1.0), (0.72, 0.73, 0.76, 1.0))
_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


def build_floor(engine: Engine) -> None:
    """Lay tiles of two colors as two bodies without weight, which the physics passes over quickly."""
    for color, rgba in enumerate(_COLORS):
        vertices, indices = _tiles(color)
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            vertices=vertices,
            indices=indices,
            normals=[[0.0, 0.0, 1.0]] * len(vertices),
            rgbaColor=rgba,
            physicsClientId=engine.client,
        )
        pybullet.createMultiBody(baseVisualShapeIndex=shape, physicsClientId=engine.client)


def _tiles(color: int) -> tuple[list[list[float]], list[int]]:
    """Vertices, m, and triangles of every second tile."""
    rows, columns = np.indices((_TILES, _TILES))
    chosen = (rows + columns) % 2 == color
    cells = np.stack([rows[chosen], columns[chosen], np.zeros(chosen.sum(), dtype=int)], axis=-1) - [
        _TILES // 2,
        _TILES // 2,
        0,
    ]
    vertices = _TILE * (cells[:, None, :] + _CORNERS).reshape(-1, 3)
    triangles = 4 * np.arange(len(cells))[:, None] + np.array([0, 1, 2, 0, 2, 3])
    return vertices.astype(float).tolist(), triangles.ravel().tolist()
