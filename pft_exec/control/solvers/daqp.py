"""DAQP, a dual active-set method [Arnstrom2022]_: exact, and 6 to 10 microseconds for seven variables; the default."""

from __future__ import annotations

import daqp
import numpy as np

from pft_exec.control.quadratic_program import SOFTNESS, QuadraticProgram, Solution
from pft_exec.control.solvers.solver import checked, not_found

_SOFT_ROW = 8  # DAQP's flag of a row that may be violated
_SUCCESS = (1, 2)  # optimal; optimal with soft rows at work


class DaqpSolver:
    """DAQP; soft rows are its own."""

    name = "daqp"

    def solve(self, program: QuadraticProgram) -> Solution:
        """Solve; a failure is a solution with ``found = False``."""
        if not program.is_finite:
            return not_found(program, "not finite")
        sense = _SOFT_ROW * program.soft.astype(np.intc)  # any other integer type is refused
        x, _, flag, info = daqp.solve(
            program.H, program.c, program.G, program.upper, program.lower, sense, rho_soft=SOFTNESS
        )
        if flag not in _SUCCESS:
            return not_found(program, f"daqp: exit flag {flag}")
        return checked(program, Solution(True, x, info["lam"], f"daqp: exit flag {flag}", info["iterations"]))
