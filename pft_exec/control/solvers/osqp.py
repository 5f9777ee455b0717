r"""OSQP, an operator-splitting method [Stellato2020]_, as workspaces that live from one control period to the next.

How many iterations it takes is a matter of scale, and accelerations, torques and distances have none in common. With
:math:`H = L L^T`, it is given

.. math:: \min_y \tfrac12 \lVert y + L^{-1} c \rVert^2
    \quad\text{s.t.}\quad D^{-1} l \le D^{-1} A L^{-T} y \le D^{-1} u,

where D makes all rows of length one: the cost never changes but in its linear part, and a tolerance means the same in
every row. Soft rows are first held as if they were hard, which they can be in all but a few periods; where it fails, a
second workspace has a slack for each. After a failure a workspace answers with stale data, so it is set up anew.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import osqp
from numba import njit
from numpy.typing import NDArray
from scipy import sparse

from pft_exec.control.quadratic_program import SOFTNESS, QuadraticProgram, Solution
from pft_exec.control.solvers.solver import checked, not_found
from pft_exec.geometry import Array

TOLERANCE = 1e-6
"""Absolute, in rows of length one; relative, a tenth of it."""
ITERATIONS = 4000
FIRST_ITERATIONS = 200
"""As many are tried with soft rows held as hard ones."""
_SPARE = 8  # rows are added in such steps, so that obstacles that come and go do not change the structure
_INFINITE = 1e30  # OSQP's


class OsqpSolver:
    """OSQP, persistent."""

    name = "osqp"

    def __init__(self) -> None:
        self._workspaces: dict[tuple[int, int, int], _Workspace] = {}

    def solve(self, program: QuadraticProgram) -> Solution:
        """Solve; a failure is a solution with ``found = False``."""
        if not program.is_finite:
            return not_found(program, "not finite")
        scaled = _scaled(program)
        if scaled is None:
            return not_found(program, "osqp: the cost is not convex")
        for slack in (0, int(program.soft.sum())):
            found = self._attempt(program, scaled, slack)
            if found.found:
                return found
        return found

    def _attempt(self, program: QuadraticProgram, scaled: _Scaled, slack: int) -> Solution:
        """Solve with soft rows held as hard ones (0 slacks), or with a slack for each of them."""
        rows = len(scaled.lower)
        key = (program.size, -(-rows // _SPARE) * _SPARE, slack)
        if key not in self._workspaces:
            self._workspaces[key] = _Workspace(*key)
        workspace = self._workspaces[key]
        result = workspace.solve(scaled, np.flatnonzero(program.soft) if slack else np.empty(0, dtype=np.intp))
        status = f"osqp: {result.info.status}"
        if result.info.status_val != osqp.SolverStatus.OSQP_SOLVED:
            del self._workspaces[key]
            return not_found(program, status)
        x = scaled.back @ result.x[: program.size]
        return checked(program, Solution(True, x, result.y[:rows] / scaled.length, status, result.info.iter))


@dataclass(frozen=True, eq=False)
class _Scaled:
    """A program in the coordinates of its cost; `back` (n, n) leads to the original ones, `length` (n + m,) is D."""

    c: Array
    rows: Array
    lower: Array
    upper: Array
    back: Array
    length: Array


def _scaled(program: QuadraticProgram) -> _Scaled | None:
    c, rows, back, length = _scale(program.H, program.c, program.G)
    if not math.isfinite(c.sum() + rows.sum()):
        return None
    lower, upper = _limits(program.lower, program.upper, length)
    return _Scaled(c, rows, lower, upper, back, length)


@njit(cache=True)
def _scale(H: Array, c: Array, G: Array) -> tuple[Array, Array, Array, Array]:
    """Linear cost (n,), rows (n + m, n) of length one, way back (n, n) and lengths (n + m,); NaN if not convex."""
    n, m = len(c), len(G)
    back = _way_back(_factor(H))
    rows, length = np.zeros((n + m, n)), np.ones(n + m)
    linear = np.zeros(n)
    for j in range(n):
        for k in range(j + 1):
            linear[j] += back[k, j] * c[k]
            rows[k, j] = back[k, j]
            for i in range(m):
                rows[n + i, j] += G[i, k] * back[k, j]
    for i in range(n + m):
        square = np.sum(rows[i] ** 2)
        if square > 0.0:
            length[i] = np.sqrt(square)
            rows[i] /= length[i]
    return linear, rows, back, length


@njit(cache=True)
def _factor(H: Array) -> Array:
    """Lower triangular L (n, n) with ``L L^T = H``; NaN where H is not positive definite."""
    n = len(H)
    factor = np.zeros((n, n))
    for j in range(n):
        for i in range(j, n):
            total = H[i, j]
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            if i > j:
                factor[i, j] = total / factor[j, j]
            else:
                factor[i, j] = np.sqrt(total) if total > 0.0 else np.nan
    return factor


@njit(cache=True)
def _way_back(factor: Array) -> Array:
    """Upper triangular inverse (n, n) of a transposed lower triangular factor (n, n)."""
    n = len(factor)
    back = np.zeros((n, n))
    for column in range(n):
        for i in range(column, -1, -1):
            total = 1.0 if i == column else 0.0
            for k in range(i + 1, column + 1):
                total -= factor[k, i] * back[k, column]
            back[i, column] = total / factor[i, i]
    return back


@njit(cache=True)
def _limits(lower: Array, upper: Array, length: Array) -> tuple[Array, Array]:
    """Bounds in rows of length one; what is infinite is so in OSQP's way."""
    low, high = np.empty(len(lower)), np.empty(len(lower))
    for i in range(len(lower)):
        low[i] = max(lower[i] / length[i], -_INFINITE)
        high[i] = min(upper[i] / length[i], _INFINITE)
    return low, high


class _Workspace:
    """One OSQP problem of n variables, some rows, spare ones among them, and a slack for some."""

    def __init__(self, size: int, rows: int, slack: int) -> None:
        self._size, self._rows, self._slack = size, rows, slack
        self._matrix = np.zeros((size, rows))  # transposed: OSQP stores columns
        self._linear = np.zeros(size + slack)
        self._lower, self._upper = np.full(rows, -_INFINITE), np.full(rows, _INFINITE)
        self._problem: osqp.OSQP | None = None
        self._soft = np.empty(0, dtype=np.intp)

    def solve(self, scaled: _Scaled, soft: NDArray[np.intp]) -> osqp.OSQP:
        """Result of a program of this size, warm-started at the last one."""
        count = len(scaled.lower)
        self._matrix[:, :count] = scaled.rows.T
        self._linear[: self._size] = scaled.c
        self._lower[:count], self._upper[:count] = scaled.lower, scaled.upper
        self._matrix[:, count:] = 0.0
        self._lower[count:], self._upper[count:] = -_INFINITE, _INFINITE
        if self._problem is None or not np.array_equal(soft, self._soft):
            self._soft = soft
            self._problem = self._set_up()
        else:
            values = self._values()
            self._problem.update(q=self._linear, Ax=values, l=self._lower, u=self._upper)
        return self._problem.solve(raise_error=False)

    def _values(self) -> Array:
        values: Array = self._matrix.ravel()
        return values if not self._slack else np.concatenate([values, np.full(self._slack, math.sqrt(SOFTNESS))])

    def _set_up(self) -> osqp.OSQP:
        """Every entry that can ever be other than zero is in the sparse structure."""
        size, rows, slack = self._size, self._rows, self._slack
        index = np.concatenate([np.tile(np.arange(rows), size), self._soft])
        start = np.concatenate([rows * np.arange(size + 1), rows * size + 1 + np.arange(slack)])
        matrix = sparse.csc_matrix((self._values().copy(), index, start), shape=(rows, size + slack))
        problem = osqp.OSQP()
        settings = {
            "eps_abs": TOLERANCE,
            "eps_rel": 0.1 * TOLERANCE,
            "max_iter": ITERATIONS if slack else FIRST_ITERATIONS,
            "check_termination": 5,
            "scaling": 0,
            "polishing": False,
            "verbose": False,
        }
        cost = sparse.eye(size + slack, format="csc")
        problem.setup(cost, self._linear, matrix, self._lower, self._upper, **settings)
        return problem
