r"""Stacking: how much each frame is to be believed at each phase of a motion, by leave-one-out prediction.

Relevance says which frames hold the two ends; stacking extends that to the whole path, by prediction instead of spread.
Each demonstration is predicted from the others by several experts (seen from the start, from each object, in the world;
their product of Gaussians; the bent and the scaled path). With the experts' mean error products :math:`C(n)` at step
n, the blend of least error has weights :math:`C^{-1} 1 / (1' C^{-1} 1)`; off-diagonals are halved, because five
demonstrations do not estimate them, and negative weights clipped. What the blend leaves is the covariance of the tube:
of each demonstration with weights that its own errors took no part in, or the residual would be too small. By the same
residual, sets of experts are compared: every expert more costs precision of the weights.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pft_exec.geometry import Array, multiply, quaternion_from_rotation_vector, relative_rotation_vector
from pft_exec.learning.resampling import smoothing

WINDOW = 0.05  # of the motion over which errors are averaged
OFF_DIAGONAL = 0.5  # share of the error products between experts that is believed


def _error_products(errors: Array) -> Array:
    """Products (K, N, E, E) of the errors (E, K, N, 3) of experts, averaged over neighbouring steps."""
    count, steps, experts = errors.shape[1], errors.shape[2], len(errors)
    rows = errors.transpose(1, 2, 0, 3)
    products = (rows @ rows.swapaxes(-1, -2)).reshape(count, steps, -1)
    smoothed: Array = (_smooth(steps) @ products).reshape(count, steps, experts, experts)
    return smoothed


def _smooth(steps: int) -> Array:
    return smoothing(steps, 0.5 * WINDOW * steps)


def _weights(products: Array, floor: float) -> Array:
    """Weights (..., N, E) from mean error products (..., N, E, E)."""
    identity = np.eye(products.shape[-1])
    believed = products * (OFF_DIAGONAL + (1.0 - OFF_DIAGONAL) * identity) + floor**2 * identity
    raw = np.linalg.solve(believed, np.ones((*products.shape[:-1], 1)))[..., 0]
    positive = np.clip(raw, 0.0, None)
    weights: Array = _smooth(products.shape[-3]) @ (positive / positive.sum(axis=-1, keepdims=True))
    return weights


def stack_weights(errors: Array, floor: float) -> Array:
    """Weights (N, E) of E experts at N steps.

    Parameters
    ----------
    errors : (E, K, N, 3)
        Leave-one-out errors, m or rad.
    floor : float
        Error below which experts count as equal, in the same unit.
    """
    return _weights(_error_products(errors).mean(axis=0), floor)


def cross_errors(errors: Array, floor: float, sets: Sequence[Sequence[int]]) -> list[float]:
    """Mean squares of `cross_fitted_errors` of sets of experts; parameters as above."""
    products = _error_products(errors)
    return [
        float(
            np.mean(_cross_fitted(products[..., np.array(chosen)[:, None], chosen], errors[list(chosen)], floor) ** 2)
        )
        for chosen in sets
    ]


def cross_fitted_errors(errors: Array, floor: float) -> Array:
    """Errors (K, N, 3) of the blend for each demonstration, its weights found without it; parameters as above."""
    return _cross_fitted(_error_products(errors), errors, floor)


def _cross_fitted(products: Array, errors: Array, floor: float) -> Array:
    others = (products.sum(axis=0) - products) / max(len(products) - 1, 1)
    blended: Array = np.einsum("kne,ekni->kni", _weights(others, floor), errors)
    return blended


def blend_positions(weights: Array, predictions: Array) -> Array:
    """Blend (M, N, 3) of predictions (E, M, N, 3) by weights (N, E)."""
    blended: Array = np.einsum("ne,emni->mni", weights, predictions)
    return blended


def blend_turns(weights: Array, predictions: Array) -> Array:
    """Blend (M, N, 4) of orientations (E, M, N, 4) by weights (N, E): the mean in the tangent of the weightiest."""
    steps = np.arange(weights.shape[0])
    blended: Array = predictions[weights.argmax(axis=1), :, steps].swapaxes(0, 1)
    for _ in range(2):
        tangent = relative_rotation_vector(blended[None], predictions)
        blended = multiply(blended, quaternion_from_rotation_vector(blend_positions(weights, tangent)))
    return blended
