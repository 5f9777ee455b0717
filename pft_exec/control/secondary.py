r"""Secondary aims: away from joint limits and singularities, where the tube leaves room for it.

Two accelerations of the joints: from each limit that is near, and up the smallest singular value :math:`\sigma` of the
Jacobian where that is small. With singular vectors u, w its gradient is
:math:`\partial\sigma / \partial q_i = u^T (\partial J / \partial q_i)\, w`. The joints follow them fully in what
leaves the tool where it is (they are added to the posture's acceleration), and the tool follows in the directions in
which its tube is wide: with the tracking weight W, largest eigenvalue 1 on a lever of 1/8 m, the share (I - W)^2 of
the tool acceleration that they make is added to the wanted one. Against the tube's own stiffness K it then rests at a
distance of that acceleration over K: millimetres where it is narrow, up to a deviation where it is wide. Derivation
ours.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from pft_exec.control.compliance import LEVER
from pft_exec.control.separation import cross
from pft_exec.geometry import Array
from pft_exec.geometry.definite import factorize
from pft_exec.model import JointLimits

MARGIN = 0.15
"""rad from a soft limit at which the aim begins; taught motions keep more (measured)."""
DEXTERITY = 0.05
"""m (rotation on a 1/8 m lever); smallest singular value below which the aim begins; taught motions keep more."""
STRENGTH = 6.0
"""rad/s^2; at a limit, or in a singularity: what the slowest joint may accelerate at."""
_LEVERS = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])


def secondary_acceleration(limits: JointLimits, q: Array, jacobian: Array) -> Array:
    """Acceleration (n,), rad/s^2, away from limits and singularities; zero where none is near.

    Parameters
    ----------
    limits : JointLimits
    q : (n,), rad
    jacobian : (6, n), linear then angular, base frame
    """
    acceleration = _off_limits(q, limits.lower, limits.upper)
    if _is_near_singular(jacobian, _LEVERS, DEXTERITY):
        dexterity, gradient = _dexterity_gradient(np.ascontiguousarray(jacobian), _LEVERS)
        steepness = max(float(np.linalg.norm(gradient)), 1e-9)
        acceleration += STRENGTH * max(1.0 - dexterity / DEXTERITY, 0.0) * gradient / steepness
    return acceleration


def room_for(acceleration: Array, weight: Array) -> Array:
    """Share (6,) of a tool acceleration (6,), base frame, that a tracking weight (6, 6) leaves room for."""
    free = np.eye(6) - weight / np.outer(_LEVERS, _LEVERS)
    share: Array = (free @ (free @ (_LEVERS * acceleration))) / _LEVERS
    return share


@njit(cache=True)
def _off_limits(q: Array, lower: Array, upper: Array) -> Array:
    """Acceleration (n,), rad/s^2, away from the limits that are near."""
    acceleration = np.empty(len(q))
    for k in range(len(q)):
        below = min(max(1.0 - (q[k] - lower[k]) / MARGIN, 0.0), 1.0)
        above = min(max(1.0 - (upper[k] - q[k]) / MARGIN, 0.0), 1.0)
        acceleration[k] = STRENGTH * (below**2 - above**2)
    return acceleration


@njit(cache=True)
def _is_near_singular(jacobian: Array, levers: Array, least: float) -> bool:
    """Whether the smallest singular value is below `least`: ``J J^T - least^2`` is not definite then."""
    square = -(least**2) * np.eye(6)
    for i in range(6):
        for j in range(i + 1):
            for k in range(jacobian.shape[1]):
                square[i, j] += levers[i] * jacobian[i, k] * levers[j] * jacobian[j, k]
    return not factorize(square)


@njit(cache=True)
def _dexterity_gradient(jacobian: Array, levers: Array) -> tuple[float, Array]:
    """Smallest singular value of a Jacobian (6, n), rotation on its lever, and its gradient (n,)."""
    n = jacobian.shape[1]
    scaled = np.empty((6, n))
    for i in range(6):
        scaled[i] = levers[i] * jacobian[i]
    values, vectors = np.linalg.eigh(scaled @ np.ascontiguousarray(scaled.T))
    u = np.ascontiguousarray(vectors[:, 0])
    smallest = np.sqrt(max(values[0], 0.0))
    w = np.ascontiguousarray(scaled.T) @ u / max(smallest, 1e-9)
    gradient = np.zeros(n)
    for i in range(n):
        axis = np.ascontiguousarray(jacobian[3:, i])
        for k in range(n):
            if i <= k:
                linear = cross(axis, np.ascontiguousarray(jacobian[:3, k]))
            else:
                linear = cross(np.ascontiguousarray(jacobian[3:, k]), np.ascontiguousarray(jacobian[:3, i]))
            angular = cross(axis, np.ascontiguousarray(jacobian[3:, k])) if i < k else np.zeros(3)
            gradient[i] += w[k] * (np.dot(u[:3], linear) + levers[3] * np.dot(u[3:], angular))
    return smallest, gradient
