"""Means of rotations that are fast for a handful of quaternions at every step of a path."""

from __future__ import annotations

import numpy as np
from numba import njit

from pft_exec.geometry import Array

ROUNDS = 8  # at most, of the intrinsic mean, from the chordal one
SQUARINGS = 6  # of the outer products, whose other eigenvalues are then gone as their 64th powers
TOLERANCE = 1e-12  # rad, of a step at which the mean has converged


@njit(cache=True, fastmath=False)
def _square(matrix, squared):  # type: ignore[no-untyped-def]
    """Square (4, 4) of a symmetric matrix, scaled to a trace of 1."""
    for i in range(4):
        for j in range(i + 1):
            value = 0.0
            for k in range(4):
                value += matrix[i, k] * matrix[k, j]
            squared[i, j] = value
            squared[j, i] = value
    trace = squared[0, 0] + squared[1, 1] + squared[2, 2] + squared[3, 3]
    for i in range(4):
        for j in range(4):
            squared[i, j] /= trace


@njit(cache=True, fastmath=False)
def _begin(mean, quaternions, share):  # type: ignore[no-untyped-def]
    """Nearly chordal means (M, 4), in place: a column of a high power of the summed outer products."""
    outer, squared = np.empty((4, 4)), np.empty((4, 4))
    for m in range(mean.shape[0]):
        outer[:] = 0.0
        for k in range(quaternions.shape[0]):
            for i in range(4):
                for j in range(4):
                    outer[i, j] += share[k, m] * quaternions[k, m, i] * quaternions[k, m, j]
        for _ in range(SQUARINGS):
            _square(outer, squared)
            outer, squared = squared, outer
        best = 0
        for i in range(4):
            if outer[i, i] > outer[best, best]:
                best = i
        mean[m] = outer[best] / np.sqrt(np.sum(outer[best] ** 2))


@njit(cache=True, fastmath=False)
def _descend(mean, quaternions, share):  # type: ignore[no-untyped-def]
    """Intrinsic means (M, 4), in place, from first guesses; quaternions (K, M, 4), shares (K, M)."""
    for m in range(mean.shape[0]):
        for _ in range(ROUNDS):
            x, y, z, w = mean[m]
            sx, sy, sz = 0.0, 0.0, 0.0
            for k in range(quaternions.shape[0]):
                a, b, c, d = quaternions[k, m]
                rx = w * a - x * d - y * c + z * b
                ry = w * b + x * c - y * d - z * a
                rz = w * c - x * b + y * a - z * d
                rw = w * d + x * a + y * b + z * c
                if rw < 0.0:
                    rx, ry, rz, rw = -rx, -ry, -rz, -rw
                sine = np.sqrt(rx * rx + ry * ry + rz * rz)
                factor = share[k, m] * (2.0 * np.arctan2(sine, rw) / sine if sine > 1e-9 else 2.0)
                sx, sy, sz = sx + factor * rx, sy + factor * ry, sz + factor * rz
            angle = np.sqrt(sx * sx + sy * sy + sz * sz)
            half = np.sin(0.5 * angle) / angle if angle > 1e-9 else 0.5
            a, b, c, d = half * sx, half * sy, half * sz, np.cos(0.5 * angle)
            mean[m, 0] = w * a + x * d + y * c - z * b
            mean[m, 1] = w * b - x * c + y * d + z * a
            mean[m, 2] = w * c + x * b - y * a + z * d
            mean[m, 3] = w * d - x * a - y * b - z * c
            mean[m] /= np.sqrt(np.sum(mean[m] ** 2))
            if angle < TOLERANCE:
                break


def average(quaternions: Array, weights: Array | None = None) -> Array:
    """Intrinsic mean (..., 4) of unit quaternions (K, ..., 4) (x, y, z, w); signs do not matter.

    Parameters
    ----------
    quaternions : (K, ..., 4)
    weights : (K, ...) or None
        Non-negative, summing to 1 over K; None weighs equally.

    Notes
    -----
    Starts near the chordal mean, the eigenvector of the largest eigenvalue of the summed outer products
    [Markley2007]_, so that it is independent of the order.
    """
    shape = quaternions.shape
    flat = np.ascontiguousarray(quaternions).reshape(shape[0], -1, 4)
    share = np.full(flat.shape[:2], 1.0 / shape[0]) if weights is None else weights.reshape(flat.shape[:2])
    share = np.ascontiguousarray(share)
    mean = np.empty(flat.shape[1:])
    _begin(mean, flat, share)
    _descend(mean, flat, share)
    return mean.reshape(shape[1:])
