"""Rotations compiled: what `pft_exec.geometry` does on whole arrays, without an array for every step of the formula.

In the flow: wherever orientations of all demonstrations are seen from one another, which is most of what learning does
with them. Quaternions are (..., 4) (x, y, z, w), vectors (..., 3) in rad; all arguments broadcast.
"""

from __future__ import annotations

import numpy as np
from numba import float64, guvectorize

from pft_exec.geometry import Array

SMALL_SINE = 1e-6  # below it the series of sin(x / 2) / x is exact to double precision

_SHAPE = np.empty(3)  # tells the compiled function how long a vector is
_PAIR = [(float64[:], float64[:], float64[:])]


@guvectorize(_PAIR, "(q),(q)->(q)", cache=True, nopython=True)  # type: ignore[no-untyped-call]
def compose(left, right, out):  # type: ignore[no-untyped-def]
    """Hamilton products ``left * right``."""
    x1, y1, z1, w1 = left[0], left[1], left[2], left[3]
    x2, y2, z2, w2 = right[0], right[1], right[2], right[3]
    out[0] = w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2
    out[1] = w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2
    out[2] = w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2
    out[3] = w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2


@guvectorize([(float64[:], float64[:], float64[:], float64[:])], "(q),(q),(v)->(v)", cache=True, nopython=True)  # type: ignore[no-untyped-call]
def _turn_between(reference, quaternion, _, out):  # type: ignore[no-untyped-def]
    x1, y1, z1, w1 = -reference[0], -reference[1], -reference[2], reference[3]
    x2, y2, z2, w2 = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    x = w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2
    y = w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2
    z = w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2
    w = w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2
    sine = np.sqrt(x * x + y * y + z * z)
    ratio = 2.0 * np.arctan2(sine, abs(w)) / sine if sine > SMALL_SINE else 2.0
    if w < 0.0:
        ratio = -ratio
    out[0], out[1], out[2] = ratio * x, ratio * y, ratio * z


@guvectorize([(float64[:], float64[:], float64[:])], "(q),(v)->(q)", cache=True, nopython=True)  # type: ignore[no-untyped-call]
def turn_by(quaternion, vector, out):  # type: ignore[no-untyped-def]
    """Quaternions turned on by rotation vectors in their own axes: ``quaternion * exp(vector)``."""
    angle = np.sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2])
    ratio = np.sin(0.5 * angle) / angle if angle > SMALL_SINE else 0.5 - angle * angle / 48.0
    x1, y1, z1, w1 = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    x2, y2, z2, w2 = ratio * vector[0], ratio * vector[1], ratio * vector[2], np.cos(0.5 * angle)
    out[0] = w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2
    out[1] = w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2
    out[2] = w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2
    out[3] = w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2


@guvectorize([(float64[:], float64[:], float64[:])], "(q),(v)->(v)", cache=True, nopython=True)  # type: ignore[no-untyped-call]
def carry(quaternion, vector, out):  # type: ignore[no-untyped-def]
    """Vectors turned by quaternions."""
    x, y, z, w = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    a, b, c = vector[0], vector[1], vector[2]
    p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    out[0] = a + w * p + y * r - z * q
    out[1] = b + w * q + z * p - x * r
    out[2] = c + w * r + x * q - y * p


def turn_between(reference: Array, quaternion: Array) -> Array:
    """Rotation vectors (..., 3) of ``reference^-1 * quaternion``, in the axes of `reference`; at most pi long."""
    vector: Array = _turn_between(reference, quaternion, _SHAPE)
    return vector
