"""Rotations as whole arrays: quaternions (x, y, z, w), their logarithm, exponential and distance.

Every function takes arrays of shape (..., 4) for quaternions and (..., 3) for vectors and broadcasts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

UNIT_TOLERANCE = 1e-3  # how far from 1 the length of a given quaternion may be before it counts as an error
_SMALL_ANGLE = 1e-6  # rad; below it the Taylor series of sin(x / 2) / x is exact to double precision


def normalize_quaternion(quaternion: ArrayLike) -> Array:
    """Quaternions (..., 4) (x, y, z, w) scaled to unit length."""
    quaternion = np.asarray(quaternion, dtype=float)
    unit: Array = quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True)
    return unit


def is_nearly_unit(quaternion: ArrayLike) -> NDArray[np.bool_]:
    """(...): whether quaternions (..., 4) have length 1 within `UNIT_TOLERANCE`."""
    near: NDArray[np.bool_] = np.abs(np.linalg.norm(quaternion, axis=-1) - 1.0) <= UNIT_TOLERANCE
    return near


def mend_quaternions(quaternion: ArrayLike) -> Array:
    """Nearly unit quaternions (N, 4) (x, y, z, w) at unit length, their signs continuous.

    What is unit already stays bit for bit, so that it survives storage unchanged.
    """
    quaternion = np.asarray(quaternion, dtype=float)
    norms = np.linalg.norm(quaternion, axis=-1, keepdims=True)
    off = np.abs(norms - 1.0) > 4.0 * np.finfo(float).eps
    return sign_continuous(np.where(off, quaternion / norms, quaternion))


def _components(values: Array) -> list[Array]:
    """Along the last axis; of a single vector they are numbers, with which one counts much faster than with arrays."""
    return [values[..., k][()] for k in range(values.shape[-1])]


def conjugate(quaternion: ArrayLike) -> Array:
    """Inverse of unit quaternions (..., 4) (x, y, z, w)."""
    inverse: Array = np.asarray(quaternion, dtype=float) * np.array([-1.0, -1.0, -1.0, 1.0])
    return inverse


def multiply(left: ArrayLike, right: ArrayLike) -> Array:
    """Hamilton product of quaternions (..., 4) (x, y, z, w): first `right`, then `left`."""
    left, right = np.asarray(left, dtype=float), np.asarray(right, dtype=float)
    x1, y1, z1, w1 = _components(left)
    x2, y2, z2, w2 = _components(right)
    product = np.empty(np.broadcast_shapes(left.shape, right.shape))
    product[..., 0] = w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2
    product[..., 1] = w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2
    product[..., 2] = w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2
    product[..., 3] = w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2
    return product


def rotate(quaternion: ArrayLike, vector: ArrayLike) -> Array:
    """Vectors (..., 3) turned by unit quaternions (..., 4) (x, y, z, w)."""
    quaternion = np.asarray(quaternion, dtype=float)
    vector = np.asarray(vector, dtype=float)
    x, y, z, w = _components(quaternion)
    a, b, c = _components(vector)
    p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)  # twice the cross product
    rotated = np.empty((*np.broadcast_shapes(quaternion.shape[:-1], vector.shape[:-1]), 3))
    rotated[..., 0] = a + w * p + y * r - z * q
    rotated[..., 1] = b + w * q + z * p - x * r
    rotated[..., 2] = c + w * r + x * q - y * p
    return rotated


def rotation_vector_from_quaternion(quaternion: ArrayLike) -> Array:
    """Logarithm: rotation vectors (..., 3), rad, of unit quaternions (..., 4) (x, y, z, w); |v| <= pi."""
    quaternion = np.asarray(quaternion, dtype=float)
    quaternion = np.where(quaternion[..., 3:] < 0.0, -quaternion, quaternion)
    axis, w = quaternion[..., :3], quaternion[..., 3]
    sine = np.linalg.norm(axis, axis=-1)
    angle = 2.0 * np.arctan2(sine, w)
    ratio = np.where(sine > _SMALL_ANGLE, angle / np.where(sine > _SMALL_ANGLE, sine, 1.0), 2.0)
    vector: Array = axis * ratio[..., None]
    return vector


def quaternion_from_rotation_vector(vector: ArrayLike) -> Array:
    """Exponential: unit quaternions (..., 4) (x, y, z, w) of rotation vectors (..., 3), rad."""
    vector = np.asarray(vector, dtype=float)
    angle = np.linalg.norm(vector, axis=-1)
    safe = np.where(angle > _SMALL_ANGLE, angle, 1.0)
    ratio = np.where(angle > _SMALL_ANGLE, np.sin(0.5 * safe) / safe, 0.5 - angle**2 / 48.0)
    return np.concatenate([vector * ratio[..., None], np.cos(0.5 * angle)[..., None]], axis=-1)


def relative_rotation_vector(reference: ArrayLike, quaternion: ArrayLike) -> Array:
    """Rotation vectors (..., 3) of ``reference^-1 * quaternion``, rad, in the frame of `reference`."""
    return rotation_vector_from_quaternion(multiply(conjugate(reference), quaternion))


def geodesic_distance(first: ArrayLike, second: ArrayLike) -> Array:
    """Angles (...), rad in [0, pi], between unit quaternions (..., 4); their sign does not matter."""
    distance: Array = np.linalg.norm(relative_rotation_vector(first, second), axis=-1)
    return distance


def interpolate_quaternion(first: ArrayLike, second: ArrayLike, ratio: ArrayLike) -> Array:
    """Geodesic interpolation (slerp) between unit quaternions (..., 4); ratio (...) 0 gives the first."""
    step = relative_rotation_vector(first, second) * np.asarray(ratio, dtype=float)[..., None]
    return multiply(first, quaternion_from_rotation_vector(step))


def sign_continuous(quaternion: ArrayLike) -> Array:
    """Quaternions (N, 4) with signs chosen so that neighbours lie in one half space; the first keeps its own."""
    quaternion = np.array(quaternion, dtype=float)
    if len(quaternion) < 2:
        return quaternion
    flips = np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0.0
    signs = np.where(np.cumsum(flips) % 2 == 1, -1.0, 1.0)
    quaternion[1:] *= signs[:, None]
    return quaternion


def rotation_matrix(quaternion: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4) (x, y, z, w)."""
    quaternion = np.asarray(quaternion, dtype=float)
    columns = [rotate(quaternion, axis) for axis in np.eye(3)]
    return np.stack(columns, axis=-1)


def quaternion_from_matrix(matrix: ArrayLike) -> Array:
    """Unit quaternions (..., 4) (x, y, z, w >= 0) of rotation matrices (..., 3, 3)."""
    from scipy.spatial.transform import Rotation

    matrix = np.asarray(matrix, dtype=float)
    flat = Rotation.from_matrix(matrix.reshape(-1, 3, 3)).as_quat(canonical=True)
    return np.asarray(flat, dtype=float).reshape(*matrix.shape[:-2], 4)


def shortest_rotation(first: ArrayLike, second: ArrayLike) -> Array:
    """Unit quaternions (..., 4) of the shortest rotation that takes direction `first` to `second` (..., 3).

    Opposite directions are turned about z, or about x where they lie along z.
    """
    first = np.asarray(first, dtype=float)
    second = np.asarray(second, dtype=float)
    a = first / np.linalg.norm(first, axis=-1, keepdims=True)
    b = second / np.linalg.norm(second, axis=-1, keepdims=True)
    w = 1.0 + np.sum(a * b, axis=-1, keepdims=True)
    along_z = np.abs(a[..., 2:]) > 0.9
    fallback = np.where(along_z, np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    fallback = fallback - a * np.sum(fallback * a, axis=-1, keepdims=True)
    half = np.where(w > 1e-12, np.cross(a, b), fallback)
    w = np.where(w > 1e-12, w, 0.0)
    return normalize_quaternion(np.concatenate([half, w], axis=-1))


def mean_quaternion(quaternions: ArrayLike, weights: ArrayLike | None = None, axis: int = 0) -> Array:
    """Intrinsic (Karcher) mean of unit quaternions along `axis`; the other axes are a batch.

    Parameters
    ----------
    quaternions : (..., K, ..., 4)
        Unit quaternions (x, y, z, w); signs do not matter.
    weights : (K,) or None
        Non-negative; None weighs equally.
    axis : int
        Which axis holds the K quaternions; not the last.

    Notes
    -----
    Gradient descent on the sum of squared geodesic distances; converges where all lie within pi / 2 of the mean.
    """
    quaternions = np.moveaxis(np.asarray(quaternions, dtype=float), axis, 0)
    count = len(quaternions)
    share = np.full(count, 1.0 / count) if weights is None else np.asarray(weights, dtype=float)
    share = share / share.sum()
    mean: Array = quaternions[int(np.argmax(share))]
    for _ in range(30):
        step = np.tensordot(share, relative_rotation_vector(mean, quaternions), axes=1)
        mean = normalize_quaternion(multiply(mean, quaternion_from_rotation_vector(step)))
        if np.max(np.abs(step), initial=0.0) < 1e-12:
            break
    return mean
