r"""Objectives of the quadratic program: what the joint accelerations should achieve, each a quadratic cost.

Every function returns an `Objective`; objectives add up. With the tool's acceleration
:math:`\ddot x = J \ddot q + \dot J \dot q`, the tracking objective is

.. math:: \tfrac12 \lVert J \ddot q + \dot J \dot q - \ddot x_d \rVert^2_W ,

and the posture objective, small beside it, decides what the tool leaves open.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from pft_exec.geometry import Array

REGULARIZATION = 1e-5
"""Weight of the posture beside a tracking weight of at most 1: from 1e-4 on, posture pulls the tool along the axes that
the tube leaves wide (13 mm at 1e-4, 60 mm at 1e-2, 9 mm at 1e-5 and below; measured, 10 N push)."""


@dataclass(frozen=True, eq=False)
class Objective:
    r"""A quadratic cost :math:`\tfrac12 x^T H x + c^T x + k` of the joint accelerations.

    Parameters
    ----------
    H : (n, n), symmetric, positive semidefinite
    c : (n,)
    constant : float
        k; decides nothing, but makes the cost of a perfect answer zero.
    """

    H: Array
    c: Array
    constant: float = 0.0

    def __add__(self, other: Objective) -> Objective:
        return Objective(self.H + other.H, self.c + other.c, self.constant + other.constant)

    def cost(self, x: Array) -> float:
        """Cost at accelerations (n,), rad/s^2."""
        return 0.5 * float(self.H.dot(x).dot(x)) + float(self.c.dot(x)) + self.constant


def tool_objective(jacobian: Array, drift: Array, acceleration: Array, weight: Array) -> Objective:
    """Cost of missing a tool acceleration.

    Parameters
    ----------
    jacobian : (6, n), linear then angular, base frame
    drift : (6,), m/s^2, rad/s^2
        Acceleration of the tool at zero joint acceleration.
    acceleration : (6,), m/s^2, rad/s^2
        Wanted, linear then angular, base frame.
    weight : (6, 6), symmetric
        Which directions matter, base frame.
    """
    weighted, missing = jacobian.T @ weight, drift - acceleration
    return Objective(weighted @ jacobian, weighted @ missing, 0.5 * float(missing @ (weight @ missing)))


def posture_objective(acceleration: Array, weight: float = REGULARIZATION) -> Objective:
    """Cost of leaving joint accelerations (n,), rad/s^2, that follow the posture; makes the program strictly convex."""
    constant = 0.5 * weight * float(acceleration @ acceleration)
    return Objective(_diagonal(len(acceleration), weight), -weight * acceleration, constant)


@cache
def _diagonal(size: int, value: float) -> Array:
    """A multiple of the unit matrix, read-only."""
    matrix: Array = value * np.eye(size)
    matrix.flags.writeable = False
    return matrix
