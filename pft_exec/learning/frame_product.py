"""Product of the Gaussians that frames see, compiled: small matrices at each step of each scene."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, fastmath=False)
def scatters(residual, leave_out):  # type: ignore[no-untyped-def]
    """Scatters (F, M, N, 3, 3) of residuals (F, K, N, 3) about their mean; M = K, each without its own, or 1."""
    frames, count, steps = residual.shape[0], residual.shape[1], residual.shape[2]
    total = np.zeros((frames, count if leave_out else 1, steps, 3, 3))
    for f in range(frames):
        for n in range(steps):
            for k in range(count):
                a = residual[f, k, n]
                for i in range(3):
                    for j in range(3):
                        total[f, 0, n, i, j] += a[i] * a[j]
            if not leave_out:
                continue
            for k in range(count - 1, -1, -1):
                a = residual[f, k, n]
                for i in range(3):
                    for j in range(3):
                        total[f, k, n, i, j] = total[f, 0, n, i, j] - count / (count - 1) * a[i] * a[j]
    return total


@njit(cache=True, fastmath=False)
def _invert(a, out):  # type: ignore[no-untyped-def]
    """Inverse of a symmetric matrix (3, 3) by cofactors."""
    out[0, 0] = a[1, 1] * a[2, 2] - a[1, 2] * a[1, 2]
    out[0, 1] = a[0, 2] * a[1, 2] - a[0, 1] * a[2, 2]
    out[0, 2] = a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]
    out[1, 1] = a[0, 0] * a[2, 2] - a[0, 2] * a[0, 2]
    out[1, 2] = a[0, 1] * a[0, 2] - a[0, 0] * a[1, 2]
    out[2, 2] = a[0, 0] * a[1, 1] - a[0, 1] * a[0, 1]
    determinant = a[0, 0] * out[0, 0] + a[0, 1] * out[0, 1] + a[0, 2] * out[0, 2]
    out[1, 0], out[2, 0], out[2, 1] = out[0, 1], out[0, 2], out[1, 2]
    for i in range(3):
        for j in range(3):
            out[i, j] /= determinant


@njit(cache=True, fastmath=False)
def _turn(turn, matrix, half, out):  # type: ignore[no-untyped-def]
    """``turn @ matrix @ turn.T`` (3, 3)."""
    for i in range(3):
        for j in range(3):
            half[i, j] = turn[i, 0] * matrix[0, j] + turn[i, 1] * matrix[1, j] + turn[i, 2] * matrix[2, j]
    for i in range(3):
        for j in range(3):
            out[i, j] = half[i, 0] * turn[j, 0] + half[i, 1] * turn[j, 1] + half[i, 2] * turn[j, 2]


@njit(cache=True, fastmath=False)
def fuse(means, covariances, turns):  # type: ignore[no-untyped-def]
    """Product of Gaussians (M, N, 3): means (F, M, N, 3), world axes; covariances (F, M or 1, N, 3, 3), own axes.

    `turns` (F, M, 3, 3) take the axes of each frame to the world's.
    """
    scenes, steps = means.shape[1], means.shape[2]
    fused = np.empty((scenes, steps, 3))
    total, weighted = np.empty((3, 3)), np.empty(3)
    inverse, half, turned = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for m in range(scenes):
        own = m if covariances.shape[1] > 1 else 0
        for n in range(steps):
            total[:] = 0.0
            weighted[:] = 0.0
            for f in range(means.shape[0]):
                _invert(covariances[f, own, n], inverse)
                _turn(turns[f, m], inverse, half, turned)
                for i in range(3):
                    for j in range(3):
                        total[i, j] += turned[i, j]
                        weighted[i] += turned[i, j] * means[f, m, n, j]
            _invert(total, inverse)
            for i in range(3):
                fused[m, n, i] = inverse[i, 0] * weighted[0] + inverse[i, 1] * weighted[1] + inverse[i, 2] * weighted[2]
    return fused
