"""Means of rotations that are fast for a handful of quaternions at every step of a path."""

from __future__ import annotations

import numpy as np

from pft_exec.geometry import Array, multiply, quaternion_from_rotation_vector, relative_rotation_vector

ROUNDS = 3  # of the intrinsic mean, from the chordal one; each squares the remaining error


def average(quaternions: Array, weights: Array | None = None) -> Array:
    """Intrinsic mean (..., 4) of unit quaternions (K, ..., 4) (x, y, z, w); signs do not matter.

    Parameters
    ----------
    quaternions : (K, ..., 4)
    weights : (K, ...) or None
        Non-negative, summing to 1 over K; None weighs equally.

    Notes
    -----
    Starts from the chordal mean, the eigenvector of the largest eigenvalue of the summed outer products [Markley2007]_,
    so that it is independent of the order.
    """
    count = len(quaternions)
    share = np.full(quaternions.shape[:-1], 1.0 / count) if weights is None else weights
    outer = np.einsum("k...,k...i,k...j->...ij", share, quaternions, quaternions)
    mean: Array = np.linalg.eigh(outer)[1][..., -1]
    for _ in range(ROUNDS):
        step = np.einsum("k...,k...i->...i", share, relative_rotation_vector(mean[None], quaternions))
        mean = multiply(mean, quaternion_from_rotation_vector(step))
    return mean
