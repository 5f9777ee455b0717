"""Every other solver, through qpsolvers: for comparison; most set up anew each time, too slow for a control period."""

from __future__ import annotations

import warnings

import numpy as np
import qpsolvers

from pft_exec.control.quadratic_program import QuadraticProgram, Solution, with_slacks
from pft_exec.control.solvers.solver import checked, not_found

_FAILURES = (qpsolvers.exceptions.QPError, ValueError, ArithmeticError, RuntimeError, TypeError, AssertionError)


def installed() -> tuple[str, ...]:
    """Names that qpsolvers can serve on this machine."""
    return tuple(qpsolvers.available_solvers)


class QpsolversSolver:
    """One of qpsolvers' solvers; soft rows become slack variables.

    Parameters
    ----------
    name : str
        As qpsolvers spells it.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    def solve(self, program: QuadraticProgram) -> Solution:
        """Solve; a failure is a solution with ``found = False``."""
        if not program.is_finite:
            return not_found(program, "not finite")
        whole = with_slacks(program)
        rows, bounds = np.vstack([whole.rows, -whole.rows]), np.concatenate([whole.upper, -whole.lower])
        real = np.isfinite(bounds)
        problem = qpsolvers.Problem(whole.H, whole.c, rows[real], bounds[real])
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # sparse solvers warn that they convert dense matrices
                found = qpsolvers.solve_problem(problem, solver=self.name)
        except _FAILURES as error:
            return not_found(program, f"{self.name}: {error}")
        if not found.found or found.x is None or found.z is None:
            return not_found(program, f"{self.name}: no solution")
        multipliers = np.zeros(len(bounds))
        multipliers[real] = found.z
        above, below = np.split(multipliers, 2)
        return checked(program, Solution(True, found.x[: program.size], above - below, f"{self.name}: found"))
