"""Rotations compiled: what `pft_exec.geometry` does on whole arrays, without an array for every step of the formula.

In the flow: wherever orientations of all demonstrations are seen from one another, which is most of what learning does
with them. Quaternions are (..., 4) (x, y, z, w), vectors (..., 3) in rad; all arguments broadcast.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit

from pft_exec.geometry import Array

SMALL_SINE = 1e-6  # below it the series of sin(x / 2) / x is exact to double precision


@njit(cache=True, fastmath=False)
def _product(x1, y1, z1, w1, x2, y2, z2, w2):  # type: ignore[no-untyped-def]
    """Hamilton product, (x, y, z, w)."""
    return (
        w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
        w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
        w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
        w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
    )


@njit(cache=True, fastmath=False)
def _compose(left, right, out):  # type: ignore[no-untyped-def]
    for k in range(len(out)):
        a, b = left[k], right[k]
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = _product(a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3])


@njit(cache=True, fastmath=False)
def _turn_between(reference, quaternion, out):  # type: ignore[no-untyped-def]
    for k in range(len(out)):
        a, b = reference[k], quaternion[k]
        x, y, z, w = _product(-a[0], -a[1], -a[2], a[3], b[0], b[1], b[2], b[3])
        sine = np.sqrt(x * x + y * y + z * z)
        ratio = 2.0 * np.arctan2(sine, abs(w)) / sine if sine > SMALL_SINE else 2.0
        if w < 0.0:
            ratio = -ratio
        out[k, 0], out[k, 1], out[k, 2] = ratio * x, ratio * y, ratio * z


@njit(cache=True, fastmath=False)
def _turn_by(quaternion, vector, out):  # type: ignore[no-untyped-def]
    for k in range(len(out)):
        a, v = quaternion[k], vector[k]
        angle = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        ratio = np.sin(0.5 * angle) / angle if angle > SMALL_SINE else 0.5 - angle * angle / 48.0
        x, y, z, w = ratio * v[0], ratio * v[1], ratio * v[2], np.cos(0.5 * angle)
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = _product(a[0], a[1], a[2], a[3], x, y, z, w)


@njit(cache=True, fastmath=False)
def _carry(quaternion, vector, out):  # type: ignore[no-untyped-def]
    for k in range(len(out)):
        x, y, z, w = quaternion[k, 0], quaternion[k, 1], quaternion[k, 2], quaternion[k, 3]
        a, b, c = vector[k, 0], vector[k, 1], vector[k, 2]
        p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
        out[k, 0] = a + w * p + y * r - z * q
        out[k, 1] = b + w * q + z * p - x * r
        out[k, 2] = c + w * r + x * q - y * p


def _row_by_row(kernel: Callable[[Array, Array, Array], None], first: Array, second: Array, width: int) -> Array:
    """Broadcast two arrays of rows against one another, and let a kernel fill an array of rows of a width.

    Notes
    -----
    Generalized universal functions of numba would broadcast by themselves, but two processes that compile them at the
    same time leave a cache that crashes whoever reads it.
    """
    shape = first.shape[:-1]
    if second.shape[:-1] != shape:
        shape = np.broadcast_shapes(shape, second.shape[:-1])
        first = np.broadcast_to(first, (*shape, first.shape[-1]))
        second = np.broadcast_to(second, (*shape, second.shape[-1]))
    out = np.empty((*shape, width))
    kernel(_rows(first), _rows(second), out.reshape(-1, width))
    return out


def _rows(array: Array) -> Array:
    return np.ascontiguousarray(array, dtype=float).reshape(-1, array.shape[-1])


def compose(left: Array, right: Array) -> Array:
    """Hamilton products ``left * right`` (..., 4)."""
    return _row_by_row(_compose, left, right, 4)


def turn_between(reference: Array, quaternion: Array) -> Array:
    """Rotation vectors (..., 3) of ``reference^-1 * quaternion``, in the axes of `reference`; at most pi long."""
    return _row_by_row(_turn_between, reference, quaternion, 3)


def turn_by(quaternion: Array, vector: Array) -> Array:
    """Quaternions (..., 4) turned on by rotation vectors in their own axes: ``quaternion * exp(vector)``."""
    return _row_by_row(_turn_by, quaternion, vector, 4)


def carry(quaternion: Array, vector: Array) -> Array:
    """Vectors (..., 3) turned by quaternions."""
    return _row_by_row(_carry, quaternion, vector, 3)
