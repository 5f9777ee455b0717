"""Solvers of the quadratic program, behind one call: `QuadraticProgram` in, `Solution` out, never an exception.

What each does with bad data differs (some call NaN a success, some stay broken for the next problem), so every adapter
refuses a program that is not finite and looks at the answer before it passes it on.
"""

from __future__ import annotations

from typing import Protocol

import daqp
import numpy as np

from pft_exec.control.quadratic_program import SOFTNESS, QuadraticProgram, Solution
from pft_exec.exceptions import UnknownMethodError

_SOFT_ROW = 8  # DAQP's flag of a row that may be violated


class Solver(Protocol):
    """Anything with a name that turns a program into a solution."""

    name: str

    def solve(self, program: QuadraticProgram) -> Solution:
        """Solve; a failure is a solution with ``found = False``."""
        ...


class DaqpSolver:
    """DAQP, a dual active-set method: exact, 6 to 10 microseconds for seven variables; soft rows are its own."""

    name = "daqp"

    def solve(self, program: QuadraticProgram) -> Solution:
        """Solve; a failure is a solution with ``found = False``."""
        if not program.is_finite:
            return not_found(program, "not finite")
        sense = np.where(program.soft, _SOFT_ROW, 0).astype(np.intc)
        x, _, flag, info = daqp.solve(
            program.H, program.c, program.G, program.upper, program.lower, sense, rho_soft=SOFTNESS
        )
        if flag not in (1, 2):
            return not_found(program, f"daqp exit flag {flag}")
        return checked(program, Solution(True, x, info["lam"], f"daqp exit flag {flag}", info["iterations"]))


def not_found(program: QuadraticProgram, status: str) -> Solution:
    """The solution that says that there is none."""
    nothing = np.full(len(program.lower), np.nan)
    return Solution(False, nothing[: program.size], nothing, status)


def checked(program: QuadraticProgram, solution: Solution) -> Solution:
    """The solution, unless it is not finite."""
    if np.isfinite(solution.x).all():
        return solution
    return not_found(program, f"{solution.status}, but not finite")


def load_solver(name: str) -> Solver:
    """A solver by name: "daqp" (default), "osqp" (persistent and warm-started), or any that qpsolvers has installed.

    Raises
    ------
    UnknownMethodError
        If there is none of that name; the message names the nearest.
    """
    if name == "daqp":
        return DaqpSolver()
    raise UnknownMethodError("solver", name, ["daqp"])
