"""One suite for every solver: known answers, agreement with an oracle, and calm in the face of nonsense."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.control import Constraint, Objective, assemble, load_solver
from pft_exec.control.solvers.qpsolvers import QpsolversSolver
from pft_exec.exceptions import UnknownMethodError
from tests.control.programs import conflicting, control_program, impossible, known

EXACT = {"daqp": 1e-8, "quadprog": 1e-8, "osqp": 5e-4}  # N m, rad/s^2 or whatever the program's rows are in
TORQUE_ERROR = {"daqp": (1e-8, 1e-8), "osqp": (1e-3, 2e-2)}  # N m: in nine of ten programs, and in the worst
SOLVERS = sorted(EXACT)


@pytest.fixture(params=SOLVERS)
def solver(request):
    return load_solver(request.param)


def test_known_primal_and_dual_are_found(solver):
    program, x, multipliers = known()
    solution = solver.solve(program)
    assert solution.found
    np.testing.assert_allclose(solution.x, x, atol=max(1e-5, EXACT[solver.name]))
    np.testing.assert_allclose(solution.multipliers, multipliers, atol=max(1e-5, EXACT[solver.name]))
    assert solution.stationarity(program) <= 1e-4
    assert program.violation(solution.x) <= EXACT[solver.name]


def test_soft_rows_give_way_to_hard_ones(solver):
    program, x = conflicting()
    solution = solver.solve(program)
    assert solution.found
    np.testing.assert_allclose(solution.x, x, atol=1e-2)
    assert program.violation(solution.x) <= EXACT[solver.name]
    assert program.violation(solution.x, soft=True) == pytest.approx(1.5, abs=1e-2)


def test_a_row_that_is_made_hard_in_place_is_hard_from_then_on(solver):
    """What a solver remembers of one program must not answer for another."""
    program, x = conflicting()
    program = replace(program, soft=program.soft.copy())
    np.testing.assert_allclose(solver.solve(program).x, x, atol=1e-2)
    program.soft[:] = False
    assert not solver.solve(program).found


def test_rows_without_a_bound_on_one_side_are_ordinary(solver):
    program, x, _ = known()
    open_below = replace(program, lower=np.array([-10.0, -10.0, -np.inf]))
    np.testing.assert_allclose(solver.solve(open_below).x, x, atol=max(1e-5, EXACT[solver.name]))


def test_contradicting_hard_rows_are_a_value_and_the_next_program_is_solved(solver):
    assert not solver.solve(impossible()).found
    program, x, _ = known()
    np.testing.assert_allclose(solver.solve(program).x, x, atol=max(1e-5, EXACT[solver.name]))


@pytest.mark.parametrize("part", ["H", "c", "G", "lower", "upper"])
def test_not_a_number_is_never_a_success_and_leaves_no_trace(solver, part):
    program, x, _ = known()
    solver.solve(program)
    spoiled = np.array(getattr(program, part))
    spoiled.flat[0] = np.nan
    solution = solver.solve(replace(program, **{part: spoiled}))
    assert not solution.found
    assert "not finite" in solution.status
    np.testing.assert_allclose(solver.solve(program).x, x, atol=max(1e-5, EXACT[solver.name]))


def test_crossed_bounds_are_never_a_success(solver):
    program, _, _ = known()
    assert not solver.solve(replace(program, lower=program.upper + 1.0)).found


@pytest.mark.parametrize("name", sorted(TORQUE_ERROR))
def test_control_programs_agree_with_the_oracle(arm, start, name):
    """Torques of random control periods, soft bounds often in conflict, are those that quadprog finds."""
    generator = np.random.default_rng(7)
    solver, oracle = load_solver(name), load_solver("quadprog")
    errors = []
    for _ in range(120):
        program = control_program(arm, start, generator)
        solution, exact = solver.solve(program), oracle.solve(program)
        assert solution.found
        assert exact.found
        errors.append(np.max(np.abs(program.G @ (solution.x - exact.x))))
        assert program.violation(solution.x) <= EXACT[name]
    usual, worst = TORQUE_ERROR[name]
    assert np.percentile(errors, 90) <= usual
    assert max(errors) <= worst


def test_an_unknown_solver_is_refused_with_the_nearest_name():
    with pytest.raises(UnknownMethodError, match=r"no solver is named 'dapq'\. Did you mean 'daqp'"):
        load_solver("dapq")


def test_exceptions_of_a_library_become_a_value():
    """A solver that qpsolvers does not have raises inside; what comes out is a solution that was not found."""
    program, _, _ = known()
    solution = QpsolversSolver("no such solver").solve(program)
    assert not solution.found
    assert "no such solver" in solution.status


def test_several_constraints_are_stacked_in_order():
    rows = [Constraint(np.ones((1, 2)), np.zeros(1), np.ones(1)), Constraint(np.eye(2), -np.ones(2), np.ones(2), True)]
    program = assemble(Objective(np.eye(2), np.zeros(2)), (-np.ones(2), np.ones(2)), rows)
    assert program.G.shape == (3, 2)
    np.testing.assert_array_equal(program.soft, [True, True, False, True, True])
    np.testing.assert_array_equal(program.lower, [-1.0, -1.0, 0.0, -1.0, -1.0])
    np.testing.assert_array_equal(program.row_values(np.array([1.0, 2.0])), [1.0, 2.0, 3.0, 1.0, 2.0])


def test_osqp_keeps_its_workspace_while_rows_come_and_go(arm, start):
    """Obstacles add soft rows and take them away; the answers are the oracle's all the same."""
    generator = np.random.default_rng(9)
    solver, oracle = load_solver("osqp"), load_solver("daqp")
    for count in (0, 1, 3, 0, 2):
        program = control_program(arm, start, generator)
        rows = generator.normal(size=(count, 7))
        more = replace(
            program,
            G=np.vstack([program.G, rows]),
            lower=np.concatenate([program.lower, -5.0 * np.ones(count)]),
            upper=np.concatenate([program.upper, np.full(count, np.inf)]),
            soft=np.concatenate([program.soft, np.ones(count, dtype=bool)]),
        )
        solution = solver.solve(more)
        assert solution.found
        assert solution.multipliers.shape == more.lower.shape
        np.testing.assert_allclose(more.G[:7] @ solution.x, more.G[:7] @ oracle.solve(more).x, atol=2e-2)


def test_osqp_refuses_a_cost_that_is_not_convex():
    program, _, _ = known()
    assert "not convex" in load_solver("osqp").solve(replace(program, H=-program.H)).status


def test_osqp_takes_no_more_iterations_than_a_period_has_time_for_and_says_who_answered_instead(arm, start):
    """Random conflicts: soft rows that cannot hold, and programs that have nothing in common with the one before."""
    from pft_exec.control.solvers.osqp import ITERATIONS

    generator = np.random.default_rng(17)
    solver, exact = load_solver("osqp"), load_solver("daqp")
    told = {True: 0, False: 0}
    for _ in range(150):
        program = control_program(arm, start, generator)
        solution, right = solver.solve(program), exact.solve(program)
        assert solution.found
        assert solution.iterations <= ITERATIONS
        is_rescued = "daqp" in solution.status
        told[is_rescued] += 1
        np.testing.assert_allclose(program.G @ solution.x, program.G @ right.x, atol=0.0 if is_rescued else 1e-2)
    assert told[False] > 2 * told[True] > 0
