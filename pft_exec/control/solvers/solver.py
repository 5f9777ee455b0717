"""What a solver is: anything with a name that turns a program into a solution."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from pft_exec.control.quadratic_program import QuadraticProgram, Solution


class Solver(Protocol):
    """Solves quadratic programs, one after the other; may keep what helps it with the next."""

    name: str

    def solve(self, program: QuadraticProgram) -> Solution:
        """Solve; a failure is a solution with ``found = False``, never an exception."""
        ...


def not_found(program: QuadraticProgram, status: str) -> Solution:
    """The solution that says that there is none."""
    nothing = np.full(len(program.lower), np.nan)
    return Solution(False, nothing[: program.size], nothing, status)


def checked(program: QuadraticProgram, solution: Solution) -> Solution:
    """The solution, unless it is not finite."""
    if math.isfinite(solution.x.dot(solution.x)):
        return solution
    return not_found(program, f"{solution.status}, but not finite")
