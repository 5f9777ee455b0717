r"""Damping that a torque held for a control period bears: it never gives energy to a motion, however light the joint.

A torque :math:`-D v`, computed once and held for a period h, changes the speed of an inertia M by
:math:`-h M^{-1} D v`. Where an eigenvalue of :math:`h M^{-1} D` is above 1 the motion reverses, above 2 it comes back
faster than it was; one period of delay halves that. Taken implicitly, as the torque of the speed that it leads to
(:math:`v^+ = v - h M^{-1} D v^+`), with c = 1, the damping is

.. math:: D_h = D\,(M + c\,h\,D)^{-1} M = (D^{-1} + c\,h\,M^{-1})^{-1}, \qquad c = 1 / s.

It is symmetric and positive semidefinite, tends to D for short periods and to :math:`M / (c h)` for long
ones, and every eigenvalue of :math:`h M^{-1} D_h` is below :math:`s = 1/c`. The kinetic energy changes in a period by

.. math:: \Delta E = -h\,v^T D_h v + \tfrac12 h^2\,v^T D_h M^{-1} D_h v \le -(1 - \tfrac{s}{2})\,h\,v^T D_h v \le 0

for any D, M and h. One period of delay leaves the roots of :math:`z^2 - z + \lambda`, :math:`\lambda < s`: within the
unit circle for s = 1, and without swinging for s = 1/4. That is taken.

Derivation ours; that a sampled and held damping is passive only below a bound: [Colgate1997]_.
"""

from __future__ import annotations

import numpy as np

from pft_exec.geometry import Array

STABLE_SHARE = 0.25
"""s, the share of any speed that damping takes away in a period at most: with a period of delay, more swings."""


def held_damping(mass_matrix: Array, damping: Array, period: float) -> Array:
    """What of a damping a torque held for a period bears, (n, n), N m s/rad.

    Parameters
    ----------
    mass_matrix : (n, n), kg m^2
        Positive definite.
    damping : (n, n), N m s/rad
        Symmetric, positive semidefinite.
    period : float, s
    """
    held: Array = damping @ np.linalg.solve(mass_matrix + (period / STABLE_SHARE) * damping, mass_matrix)
    return held
