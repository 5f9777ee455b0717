"""Objectives: their gradient and value are those of the least-squares problem they stand for."""

from __future__ import annotations

import numpy as np

from pft_exec.control import posture_objective, tool_objective


def value(objective, x):
    return 0.5 * x @ objective.H @ x + objective.c @ x


def test_tool_objective_is_the_weighted_square_up_to_a_constant():
    generator = np.random.default_rng(0)
    J, drift, wanted = generator.normal(size=(6, 7)), generator.normal(size=6), generator.normal(size=6)
    root = generator.normal(size=(6, 6))
    W = root @ root.T
    objective = tool_objective(J, drift, wanted, W)

    def square(x):
        error = J @ x + drift - wanted
        return 0.5 * error @ W @ error

    a, b = generator.normal(size=7), generator.normal(size=7)
    np.testing.assert_allclose(value(objective, a) - value(objective, b), square(a) - square(b), rtol=1e-10)


def test_posture_decides_what_the_tool_leaves_open():
    """With a light posture objective the tool reaches its acceleration and the rest follows the posture."""
    generator = np.random.default_rng(1)
    J, wanted, posture = generator.normal(size=(6, 7)), generator.normal(size=6), generator.normal(size=7)
    total = tool_objective(J, np.zeros(6), wanted, np.eye(6)) + posture_objective(posture)
    x = np.linalg.solve(total.H, -total.c)
    nothing = np.linalg.svd(J)[2][-1]
    np.testing.assert_allclose(J @ x, wanted, atol=1e-3)
    np.testing.assert_allclose(nothing @ x, nothing @ posture, atol=1e-6)
