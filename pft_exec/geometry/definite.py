"""Small systems of linear equations with a symmetric positive definite matrix, compiled: within control periods."""

from __future__ import annotations

import numpy as np
from numba import njit

from pft_exec.geometry.rotation import Array

_LEAST_PIVOT = 1e-30


@njit(cache=True)
def factorize(lower: Array) -> bool:
    """Put the Cholesky factor in place of the lower half of a symmetric matrix (n, n); False: it is not definite."""
    for j in range(len(lower)):
        for k in range(j):
            lower[j, j] -= lower[j, k] * lower[j, k]
        if not lower[j, j] > _LEAST_PIVOT:
            return False
        lower[j, j] = np.sqrt(lower[j, j])
        for i in range(j + 1, len(lower)):
            for k in range(j):
                lower[i, j] -= lower[i, k] * lower[j, k]
            lower[i, j] /= lower[j, j]
    return True


@njit(cache=True)
def substitute_forward(lower: Array, vector: Array) -> None:
    """Put ``L^-1 x`` in place of x (n,), with a factor L."""
    for j in range(len(vector)):
        for k in range(j):
            vector[j] -= lower[j, k] * vector[k]
        vector[j] /= lower[j, j]


@njit(cache=True)
def substitute_back(lower: Array, vector: Array) -> None:
    """Put ``L^-T x`` in place of x (n,), with a factor L."""
    for j in range(len(vector) - 1, -1, -1):
        for i in range(j + 1, len(vector)):
            vector[j] -= lower[i, j] * vector[i]
        vector[j] /= lower[j, j]
