"""DAQP, a dual active-set method [Arnstrom2022]_: exact, and 6 to 10 microseconds for seven variables; the default."""

from __future__ import annotations

import daqp
import numpy as np
from numpy.typing import NDArray

from pft_exec.control.quadratic_program import SOFTNESS, QuadraticProgram, Solution
from pft_exec.control.solvers.solver import checked, not_found

_SOFT_ROW = 8  # DAQP's flag of a row that may be violated
_SUCCESS = (1, 2)  # optimal; optimal with soft rows at work


class DaqpSolver:
    """DAQP; soft rows are its own."""

    name = "daqp"

    def __init__(self) -> None:
        self._soft: NDArray[np.bool_] = np.empty(0, dtype=bool)
        self._sense: NDArray[np.intc] = np.empty(0, dtype=np.intc)

    def solve(self, program: QuadraticProgram) -> Solution:
        """Solve; a failure is a solution with ``found = False``."""
        if not program.is_finite:
            return not_found(program, "not finite")
        if program.soft is not self._soft or program.soft.flags.writeable:  # programs of the same rows share it
            self._soft, self._sense = program.soft, _SOFT_ROW * program.soft.astype(np.intc)  # no other type will do
        x, _, flag, info = daqp.solve(
            program.H, program.c, program.G, program.upper, program.lower, self._sense, rho_soft=SOFTNESS
        )
        if flag not in _SUCCESS:
            return not_found(program, f"daqp: exit flag {flag}")
        return checked(program, Solution(True, x, info["lam"], f"daqp: exit flag {flag}", info["iterations"]))
