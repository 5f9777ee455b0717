"""A camera in the world: pictures by PyBullet's software renderer, which needs no display."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import pybullet
from numpy.typing import NDArray

from pft_exec.exceptions import SimulationError, UnknownNameError
from pft_exec.geometry import Pose


@dataclass(frozen=True)
class View:
    """Where a camera stands and looks, in the robot's base frame, m, and its vertical field of view, degrees."""

    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    field_of_view: float


VIEWS = MappingProxyType(
    {
        "room": View(eye=(2.5, -1.75, 1.95), target=(0.36, -0.02, 0.78), field_of_view=36.0),
        "table": View(eye=(1.75, -0.85, 1.55), target=(0.52, -0.12, 0.86), field_of_view=36.0),
    }
)


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

    def frame(self, size: tuple[int, int] = (640, 480), view: str = "room", shadow: bool = False) -> NDArray[np.uint8]:
        """Take a picture.

        Parameters
        ----------
        size : (int, int)
            Width and height, pixels.
        view : str
            "room": robot and table; "table": close, on arm and objects.
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
        if view not in VIEWS:
            raise UnknownNameError("view", view, VIEWS)
        width, height = size
        if width < 1 or height < 1:
            raise SimulationError(f"a picture needs a positive width and height in pixels; got {size}.")
        image = pybullet.getCameraImage(
            width,
            height,
            viewMatrix=self._view_matrix(VIEWS[view]),
            projectionMatrix=pybullet.computeProjectionMatrixFOV(VIEWS[view].field_of_view, width / height, 0.1, 12.0),
            lightDirection=[1.5, -1.0, 3.0],
            lightDistance=8.0,
            shadow=int(shadow),
            renderer=pybullet.ER_TINY_RENDERER,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )[2]
        return np.asarray(image, dtype=np.uint8).reshape(height, width, 4)[:, :, :3].copy()

    def _view_matrix(self, view: View) -> list[float]:
        matrix: list[float] = pybullet.computeViewMatrix(
            self._base.apply(view.eye).tolist(), self._base.apply(view.target).tolist(), [0.0, 0.0, 1.0]
        )
        return matrix
