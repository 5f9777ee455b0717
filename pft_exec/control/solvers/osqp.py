r"""OSQP, an operator-splitting method [Stellato2020]_, as workspaces that live from one control period to the next.

How many iterations it takes is a matter of scale, and accelerations, torques and distances have none in common. With
:math:`H = L L^T`, it is given

.. math:: \min_y \tfrac12 \lVert y + L^{-1} c \rVert^2
    \quad\text{s.t.}\quad D^{-1} l \le D^{-1} A L^{-T} y \le D^{-1} u,

where D makes all rows of length one: the cost never changes but in its linear part, and a tolerance means the same in
every row. Soft rows are held as if they were hard, which they can be in all but a few periods. Where they cannot, or
where it takes more iterations than a control period has time for, DAQP answers, which knows soft rows and is exact; the
status says so. The workspace then begins at zero again; after any other failure it answers with stale data, so it is
set up anew.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import osqp
from numba import njit
from scipy import sparse

from pft_exec.control.quadratic_program import QuadraticProgram, Solution
from pft_exec.control.solvers.daqp import DaqpSolver
from pft_exec.control.solvers.solver import checked, not_found
from pft_exec.geometry import Array

TOLERANCE = 1e-6
"""Absolute, in rows of length one; relative, a tenth of it."""
ITERATIONS = 80
"""At most: with them and DAQP's answer a program takes less than 200 microseconds (`benchmark control`)."""
_FIRST_STEP = 0.1  # OSQP's own step size, before it adapts it
_SPARE = 8  # rows are added in such steps, so that obstacles that come and go do not change the structure
_INFINITE = 1e30  # OSQP's
_USABLE = (
    osqp.SolverStatus.OSQP_MAX_ITER_REACHED,
    osqp.SolverStatus.OSQP_PRIMAL_INFEASIBLE,
    osqp.SolverStatus.OSQP_PRIMAL_INFEASIBLE_INACCURATE,
    osqp.SolverStatus.OSQP_SOLVED_INACCURATE,
)
"""After these a workspace is sound: its data were finite, there was no time or no answer."""


class OsqpSolver:
    """OSQP, persistent."""

    name = "osqp"

    def __init__(self) -> None:
        self._workspaces: dict[tuple[int, int], _Workspace] = {}
        self._exact = DaqpSolver()

    def solve(self, program: QuadraticProgram) -> Solution:
        """Solve; a failure is a solution with ``found = False``."""
        if not program.is_finite:
            return not_found(program, "not finite")
        scaled = _scaled(program)
        if scaled is None:
            return not_found(program, "osqp: the cost is not convex")
        found = self._attempt(program, scaled)
        if found.found:
            return found
        exact = self._exact.solve(program)
        return replace(exact, status=f"{found.status}; {exact.status}")

    def _attempt(self, program: QuadraticProgram, scaled: _Scaled) -> Solution:
        """Solve with soft rows held as hard ones."""
        rows = len(scaled.lower)
        key = (program.size, -(-rows // _SPARE) * _SPARE)
        if key not in self._workspaces:
            self._workspaces[key] = _Workspace(*key)
        workspace = self._workspaces[key]
        result = workspace.solve(scaled)
        status = f"osqp: {result.info.status}"
        if result.info.status_val != osqp.SolverStatus.OSQP_SOLVED:
            if result.info.status_val in _USABLE:
                workspace.begin_anew()
            else:
                del self._workspaces[key]
            return not_found(program, status)
        x = scaled.back @ result.x
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
    """One OSQP problem of n variables and some rows, spare ones among them."""

    def __init__(self, size: int, rows: int) -> None:
        self._size, self._rows = size, rows
        self._matrix = np.zeros((size, rows))  # transposed: OSQP stores columns
        self._lower, self._upper = np.full(rows, -_INFINITE), np.full(rows, _INFINITE)
        self._problem: osqp.OSQP | None = None

    def solve(self, scaled: _Scaled) -> osqp.OSQP:
        """Result of a program of this size, warm-started at the last one."""
        count = len(scaled.lower)
        self._matrix[:, :count] = scaled.rows.T
        self._lower[:count], self._upper[:count] = scaled.lower, scaled.upper
        self._matrix[:, count:] = 0.0
        self._lower[count:], self._upper[count:] = -_INFINITE, _INFINITE
        if self._problem is None:
            self._problem = self._set_up(scaled.c)
        else:
            self._problem.update(q=scaled.c, Ax=self._matrix.ravel(), l=self._lower, u=self._upper)
        return self._problem.solve(raise_error=False)

    def begin_anew(self) -> None:
        """Forget the last answer and the step size that led to it."""
        if self._problem is not None:
            self._problem.warm_start(x=np.zeros(self._size), y=np.zeros(self._rows))
            self._problem.update_settings(rho=_FIRST_STEP)

    def _set_up(self, linear: Array) -> osqp.OSQP:
        """Every entry that can ever be other than zero is in the sparse structure."""
        size, rows = self._size, self._rows
        index, start = np.tile(np.arange(rows), size), rows * np.arange(size + 1)
        matrix = sparse.csc_matrix((self._matrix.ravel().copy(), index, start), shape=(rows, size))
        problem = osqp.OSQP()
        settings = {
            "eps_abs": TOLERANCE,
            "eps_rel": 0.1 * TOLERANCE,
            "max_iter": ITERATIONS,
            "check_termination": 5,
            "rho": _FIRST_STEP,
            "scaling": 0,
            "polishing": False,
            "verbose": False,
        }
        problem.setup(sparse.eye(size, format="csc"), linear, matrix, self._lower, self._upper, **settings)
        return problem
