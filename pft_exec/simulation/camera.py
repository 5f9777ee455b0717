"""A camera in the world: pictures by PyBullet's software renderer, which needs no display."""

from __future__ import annotations

import numpy as np
import pybullet
from numpy.typing import NDArray

from pft_exec.exceptions import SimulationError, UnknownNameError
from pft_exec.geometry import Pose
from pft_exec.simulation.backdrop import compute_backdrop
from pft_exec.simulation.view import VIEWS, View

_CLIP = (0.1, 12.0)  # m; nothing nearer or farther is seen
_NOTHING = 0.9999  # depth in the clipped range beyond which no body is
_LIGHT = (1.5, -1.0, 3.0)  # direction towards the light, world frame


class Camera:
    """Takes pictures of one engine's bodies.

    Parameters
    ----------
    client : int
        Of the engine.
    base : Pose
        Of the robot's base, world frame; the views move with it.
    """

    def __init__(self, client: int, base: Pose) -> None:
        self._client = client
        self._base = base
        self._backdrops: dict[tuple[View, tuple[int, int]], NDArray[np.uint8]] = {}

    def frame(
        self, size: tuple[int, int] = (640, 480), view: str | View = "room", shadow: bool = False
    ) -> NDArray[np.uint8]:
        """Take a picture.

        Parameters
        ----------
        size : (int, int)
            Width and height, pixels.
        view : str or View
            "room": robot and table; "table": close, on arm and objects; both from the robot's right, with "_left"
            appended from its left. Or one of the caller's own.
        shadow : bool
            Twice as slow.

        Returns
        -------
        (height, width, 3) uint8
            Red, green, blue.

        Raises
        ------
        UnknownNameError
            If there is no such view.
        SimulationError
            If the size is not positive.
        """
        if isinstance(view, str) and view not in VIEWS:
            raise UnknownNameError("view", view, VIEWS)
        width, height = size
        if width < 1 or height < 1:
            raise SimulationError(f"a picture needs a positive width and height in pixels; got {size}.")
        seen = VIEWS[view] if isinstance(view, str) else view
        _, _, image, depth, _ = pybullet.getCameraImage(
            width,
            height,
            viewMatrix=self._view_matrix(seen),
            projectionMatrix=pybullet.computeProjectionMatrixFOV(seen.field_of_view, width / height, *_CLIP),
            lightDirection=_LIGHT,
            lightDistance=8.0,
            shadow=int(shadow),
            renderer=pybullet.ER_TINY_RENDERER,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )
        picture = np.array(image, dtype=np.uint8).reshape(height, width, 4)[:, :, :3]
        is_empty = np.asarray(depth).reshape(height, width, 1) > _NOTHING
        return np.where(is_empty, self._backdrop(seen, size), picture)

    def _view_matrix(self, view: View) -> list[float]:
        eye, target = self._base.apply([view.eye, view.target])
        matrix: list[float] = pybullet.computeViewMatrix(eye.tolist(), target.tolist(), [0.0, 0.0, 1.0])
        return matrix

    def _backdrop(self, view: View, size: tuple[int, int]) -> NDArray[np.uint8]:
        """Floor and sky of a view, computed when first seen."""
        if (view, size) not in self._backdrops:
            eye, target = self._base.apply([view.eye, view.target])
            self._backdrops[view, size] = compute_backdrop(eye, target, view.field_of_view, size)
        return self._backdrops[view, size]
