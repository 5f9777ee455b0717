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
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pft_exec.geometry import Array
from pft_exec.learning.smoothing import smoothed
from pft_exec.learning.stacking_kernel import blend, error_products, least_error_weights
from pft_exec.learning.turning import turn_between, turn_by

WINDOW = 0.05  # of the motion over which errors are averaged
OFF_DIAGONAL = 0.5  # share of the error products between experts that is believed


def _smoothed(values: Array) -> Array:
    """Values (N, ...) averaged over neighbouring steps."""
    return smoothed(values, 0.5 * WINDOW * len(values))


@dataclass(frozen=True, eq=False)
class ExpertErrors:
    """What E experts said of K demonstrations that they were not shown, less how these were.

    Parameters
    ----------
    errors : (E, K, N, 3), m or rad
    floor : float
        Error below which experts count as equal, in the same unit.
    """

    errors: Array
    floor: float

    @cached_property
    def products(self) -> Array:
        """Products (N, K, E (E + 1) / 2) of the errors, averaged over neighbouring steps: the lower triangles."""
        return _smoothed(error_products(np.ascontiguousarray(self.errors)))

    def of(self, chosen: Sequence[int]) -> ExpertErrors:
        """The errors of some of the experts, in the order that they have."""
        some = ExpertErrors(self.errors[list(chosen)], self.floor)
        pairs = [e * (e + 1) // 2 + f for i, e in enumerate(chosen) for f in chosen[: i + 1]]
        some.__dict__["products"] = np.ascontiguousarray(self.products[..., pairs])
        return some

    def _weights(self, products: Array) -> Array:
        return _smoothed(
            least_error_weights(np.ascontiguousarray(products), len(self.errors), OFF_DIAGONAL, self.floor)
        )

    def weights(self) -> Array:
        """Weights (N, E) of the blend of least error."""
        return self._weights(self.products.mean(axis=1, keepdims=True))[:, 0]

    @cached_property
    def cross_fitted(self) -> Array:
        """Errors (K, N, 3) of the blend for each demonstration, its weights found without it."""
        count = self.products.shape[1]
        others = (self.products.sum(axis=1, keepdims=True) - self.products) / max(count - 1, 1)
        blended: Array = blend(self._weights(others), np.ascontiguousarray(self.errors))
        return blended

    def cross_fitted_square(self) -> float:
        """Mean square of `cross_fitted`, by which sets of experts are compared."""
        return float(np.mean(self.cross_fitted**2))


def blend_positions(weights: Array, predictions: Array) -> Array:
    """Blend (M, N, 3) of predictions (E, M, N, 3) by weights (N, E)."""
    blended: Array = blend(weights[:, None], np.ascontiguousarray(predictions))
    return blended


def blend_turns(weights: Array, predictions: Array) -> Array:
    """Blend (M, N, 4) of orientations (E, M, N, 4) by weights (N, E): the mean in the tangent of the weightiest."""
    steps = np.arange(weights.shape[0])
    blended: Array = predictions[weights.argmax(axis=1), :, steps].swapaxes(0, 1)
    for _ in range(2):
        blended = turn_by(blended, blend_positions(weights, turn_between(blended[None], predictions)))
    return blended
