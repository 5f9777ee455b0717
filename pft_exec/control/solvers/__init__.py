"""Solvers of the quadratic program, behind one call: `QuadraticProgram` in, `Solution` out, never an exception.

What each does with bad data differs: some call NaN a success, some stay broken for the next problem, some answer with
the previous one. So every adapter refuses a program that is not finite, looks at the answer before it passes it on, and
keeps its library's exceptions to itself. One suite of tests holds for all of them.
"""

from __future__ import annotations

from pft_exec.control.solvers.daqp import DaqpSolver
from pft_exec.control.solvers.solver import Solver
from pft_exec.exceptions import UnknownMethodError

__all__ = ["DaqpSolver", "Solver", "load_solver"]


def load_solver(name: str) -> Solver:
    """A solver by name: "daqp" (default), "osqp" (persistent, warm-started), or any other that qpsolvers has installed.

    Raises
    ------
    UnknownMethodError
        If there is none of that name; the message names the nearest.
    """
    if name == "daqp":
        return DaqpSolver()
    if name == "osqp":
        from pft_exec.control.solvers.osqp import OsqpSolver

        return OsqpSolver()
    from pft_exec.control.solvers.qpsolvers import QpsolversSolver, installed

    if name not in installed():
        raise UnknownMethodError("solver", name, ["daqp", "osqp", *installed()])
    return QpsolversSolver(name)
