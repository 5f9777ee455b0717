"""Stacking, compiled: the products of the experts' errors, the weights that follow, and the blend by them.

Matrices of a few experts at each step of each demonstration: too small for a library of linear algebra.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, fastmath=False)
def error_products(errors):  # type: ignore[no-untyped-def]
    """Inner products (N, K, E (E + 1) / 2) of errors (E, K, N, 3): the lower triangles, row after row."""
    experts, count, steps = errors.shape[0], errors.shape[1], errors.shape[2]
    products = np.empty((steps, count, experts * (experts + 1) // 2))
    for k in range(count):
        for e in range(experts):
            for f in range(e + 1):
                for n in range(steps):
                    a, b = errors[e, k, n], errors[f, k, n]
                    products[n, k, e * (e + 1) // 2 + f] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return products


@njit(cache=True, fastmath=False)
def _factorize(products, off_diagonal, floor, factor):  # type: ignore[no-untyped-def]
    """Cholesky factor (E, E), lower triangle, of the products that are believed."""
    for e in range(len(factor)):
        for f in range(e + 1):
            value = products[e * (e + 1) // 2 + f]
            value = off_diagonal * value if f < e else value + floor * floor
            for i in range(f):
                value -= factor[e, i] * factor[f, i]
            factor[e, f] = value / factor[f, f] if f < e else np.sqrt(value)


@njit(cache=True, fastmath=False)
def _solve_for_ones(factor, solution):  # type: ignore[no-untyped-def]
    experts = len(factor)
    for e in range(experts):
        value = 1.0
        for i in range(e):
            value -= factor[e, i] * solution[i]
        solution[e] = value / factor[e, e]
    for e in range(experts - 1, -1, -1):
        value = solution[e]
        for i in range(e + 1, experts):
            value -= factor[i, e] * solution[i]
        solution[e] = value / factor[e, e]


@njit(cache=True, fastmath=False)
def least_error_weights(products, experts, off_diagonal, floor):  # type: ignore[no-untyped-def]
    """Weights (N, K, E), non-negative, of sum 1, from mean error products as `error_products` orders them."""
    steps, count = products.shape[0], products.shape[1]
    weights = np.empty((steps, count, experts))
    factor = np.zeros((experts, experts))
    for n in range(steps):
        for k in range(count):
            _factorize(products[n, k], off_diagonal, floor, factor)
            _solve_for_ones(factor, weights[n, k])
            total = 0.0
            for e in range(experts):
                weights[n, k, e] = max(weights[n, k, e], 0.0)
                total += weights[n, k, e]
            for e in range(experts):
                weights[n, k, e] /= total
    return weights


@njit(cache=True, fastmath=False)
def blend(weights, values):  # type: ignore[no-untyped-def]
    """Sums (K, N, 3) of values (E, K, N, 3) by weights (N, K, E), or (N, 1, E) for all K alike."""
    experts, count, steps = values.shape[0], values.shape[1], values.shape[2]
    own = weights.shape[1] > 1
    blended = np.zeros((count, steps, 3))
    for e in range(experts):
        for k in range(count):
            for n in range(steps):
                weight = weights[n, k if own else 0, e]
                for i in range(3):
                    blended[k, n, i] += weight * values[e, k, n, i]
    return blended
