"""What a camera sees behind everything: a tiled floor under an even sky, computed once for a view.

A floor in the physics engine would double the time that the software renderer takes for a picture.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pft_exec.geometry import Array
from pft_exec.simulation.view import camera_axes

_TILE = 0.5  # m
_LIGHT, _DARK = np.array([214.0, 216.0, 220.0]), np.array([192.0, 195.0, 201.0])
_SKY = np.array([238.0, 241.0, 245.0])
_HAZE = 4.5  # m; distance at which the floor is half sky
_SUBPIXELS = 2  # along each side of a pixel


def compute_backdrop(eye: Array, target: Array, field_of_view: float, size: tuple[int, int]) -> NDArray[np.uint8]:
    """Floor at z = 0 and sky as a camera sees them.

    Parameters
    ----------
    eye, target : (3,), m, world frame
        Where the camera stands and looks; it is held level.
    field_of_view : float, degrees
        Vertical.
    size : (int, int)
        Width and height, pixels.

    Returns
    -------
    (height, width, 3) uint8
    """
    width, height = size
    right, up, forward = camera_axes(target - eye)
    half = np.tan(0.5 * np.radians(field_of_view))
    across = half * width / height * _grid(width)
    rise = -half * _grid(height)[:, None]
    x, y, z = (forward[axis] + across * right[axis] + rise * up[axis] for axis in range(3))
    below = z < -1e-3
    depth = np.where(below, -eye[2] / np.where(below, z, -1.0), 0.0)
    is_light = (np.floor((eye[0] + depth * x) / _TILE) + np.floor((eye[1] + depth * y) / _TILE)) % 2 == 0
    clear = np.where(below, np.exp(-np.log(2.0) * (depth / _HAZE) ** 2), 0.0)
    light, dark = (_pixels(clear * chosen, size)[..., None] for chosen in (is_light, ~is_light))
    image = _SKY + light * (_LIGHT - _SKY) + dark * (_DARK - _SKY)
    rounded: NDArray[np.uint8] = np.round(image).astype(np.uint8)
    return rounded


def _grid(count: int) -> Array:
    """Middles of the subpixels of `count` pixels, from -1 to 1."""
    fine = count * _SUBPIXELS
    grid: Array = 2.0 * (np.arange(fine) + 0.5) / fine - 1.0
    return grid


def _pixels(values: Array, size: tuple[int, int]) -> Array:
    """Subpixels averaged over each pixel (h, w)."""
    width, height = size
    averaged: Array = values.reshape(height, _SUBPIXELS, width, _SUBPIXELS).mean(axis=(1, 3))
    return averaged
