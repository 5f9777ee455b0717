r"""The quadratic program of one control period, and what a solver made of it.

.. math::
    \min_x \tfrac12 x^T H x + c^T x \quad\text{subject to}\quad l_b \le x \le u_b \;(\text{soft}),\;
    l_r \le G x \le u_r \;(\text{hard or soft}).

x are the joint accelerations. A *soft* row gives way where the hard ones leave no other choice, at the cost
:math:`s^2 / (2 \epsilon\, a^T H^{-1} a)` of a violation s of row a: relative to the row's own curvature, so that the
softness :math:`\epsilon` has no unit. Where the hard and soft rows can all hold, the violation is of order
:math:`\epsilon` and of no account.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pft_exec.control.limits import Constraint
from pft_exec.control.objectives import Objective
from pft_exec.geometry import Array

SOFTNESS = 1e-6


@dataclass(frozen=True, eq=False)
class QuadraticProgram:
    """Cost, bounds and rows of one quadratic program.

    Parameters
    ----------
    H : (n, n), symmetric, positive definite
    c : (n,)
    lower, upper : (n + m,)
        First of the variables themselves, which are soft, then of the m rows.
    G : (m, n)
    soft : (n + m,), bool
    """

    H: Array
    c: Array
    G: Array
    lower: Array
    upper: Array
    soft: NDArray[np.bool_]

    @property
    def size(self) -> int:
        """Number n of variables."""
        return len(self.c)

    @property
    def is_finite(self) -> bool:
        """Whether cost and rows are finite numbers and no bound is NaN; a solver may call NaN a success."""
        return bool(_is_finite(self.H, self.c, self.G, self.lower, self.upper))

    def row_values(self, x: Array) -> Array:
        """Values (n + m,) that lie between `lower` and `upper` at a solution."""
        return np.concatenate([x, self.G @ x])

    def violation(self, x: Array, soft: bool = False) -> float:
        """Largest amount by which a hard (or soft) row is missed at x."""
        values = self.row_values(x)
        missed = np.maximum(self.lower - values, values - self.upper)
        return float(np.max(missed[self.soft == soft], initial=0.0))


@njit(cache=True)
def _is_finite(H: Array, c: Array, G: Array, lower: Array, upper: Array) -> bool:
    total = 0.0
    for array in (H, c.reshape((1, -1)), G):
        for row in array:
            for value in row:
                total += value
    for k in range(len(lower)):
        if not lower[k] <= upper[k]:
            return False
    return math.isfinite(total)


def assemble(objective: Objective, bounds: tuple[Array, Array], constraints: Sequence[Constraint]) -> QuadraticProgram:
    """Put an objective, soft bounds (n,), (n,) on the variables, and constraints together."""
    return QuadraticProgram(
        objective.H,
        objective.c,
        np.concatenate([row.G for row in constraints]) if len(constraints) > 1 else constraints[0].G,
        np.concatenate([bounds[0], *(row.lower for row in constraints)]),
        np.concatenate([bounds[1], *(row.upper for row in constraints)]),
        softness(len(bounds[0]), tuple((len(row.lower), row.soft) for row in constraints)),
    )


def with_constraint(program: QuadraticProgram, row: Constraint) -> QuadraticProgram:
    """A program with further rows."""
    return QuadraticProgram(
        program.H,
        program.c,
        np.concatenate([program.G, row.G]),
        np.concatenate([program.lower, row.lower]),
        np.concatenate([program.upper, row.upper]),
        softness(program.size, ((len(program.G), False), (len(row.lower), row.soft))),
    )


@lru_cache
def softness(variables: int, rows: tuple[tuple[int, bool], ...]) -> NDArray[np.bool_]:
    """Which bounds and rows are soft, read-only."""
    soft = np.concatenate([np.ones(variables, dtype=bool), *(np.full(count, is_soft) for count, is_soft in rows)])
    soft.flags.writeable = False
    return soft


@dataclass(frozen=True, eq=False)
class HardProgram:
    """A quadratic program of hard rows alone: ``lower <= rows x <= upper``."""

    H: Array
    c: Array
    rows: Array
    lower: Array
    upper: Array


def with_slacks(program: QuadraticProgram) -> HardProgram:
    """The same program with a variable for each soft row: for solvers that know hard rows only.

    Its variables are the n of `program`, then a scaled slack for each of the k soft rows; its rows are the n bounds and
    m rows of `program`, in that order.
    """
    n, soft = program.size, np.flatnonzero(program.soft)
    rows = np.zeros((len(program.lower), n + len(soft)))
    rows[range(n), range(n)] = 1.0
    rows[n:, :n] = program.G
    relaxed = rows[soft, :n]
    curvature = np.sum(relaxed * np.linalg.solve(program.H, relaxed.T).T, axis=1)
    rows[soft, n + np.arange(len(soft))] = np.sqrt(SOFTNESS * curvature)
    H = np.eye(n + len(soft))
    H[:n, :n] = program.H
    c = np.concatenate([program.c, np.zeros(len(soft))])
    return HardProgram(H, c, rows, program.lower, program.upper)


@dataclass(frozen=True, eq=False)
class Solution:
    """What a solver found.

    Parameters
    ----------
    found : bool
        Whether `x` solves the program; False is a value, never an exception.
    x : (n,)
        NaN where nothing was found.
    multipliers : (n + m,)
        Of the rows: positive at an upper bound, negative at a lower one.
    status : str
        The solver's own word.
    iterations : int
    """

    found: bool
    x: Array
    multipliers: Array = field(default_factory=lambda: np.empty(0))
    status: str = ""
    iterations: int = 0

    def stationarity(self, program: QuadraticProgram) -> float:
        """Largest component of ``H x + c + rows^T multipliers``: zero at the optimum."""
        size = program.size
        gradient = program.H @ self.x + program.c + self.multipliers[:size] + program.G.T @ self.multipliers[size:]
        return float(np.max(np.abs(gradient)))
