"""Quadratic programs for tests: some with a known answer, many as they come in a control period."""

from __future__ import annotations

import numpy as np

from pft_exec.control import QuadraticProgram, acceleration_bounds, assemble, posture_objective, tool_objective
from pft_exec.control.limits import torque_constraint


def known():
    """Minimize |x - (3, 1)|^2 with x1 + x2 <= 3 (hard) and |x| <= 10: (2.5, 0.5), multiplier 1 of the hard row."""
    return (
        QuadraticProgram(
            H=2.0 * np.eye(2),
            c=np.array([-6.0, -2.0]),
            G=np.array([[1.0, 1.0]]),
            lower=np.array([-10.0, -10.0, -10.0]),
            upper=np.array([10.0, 10.0, 3.0]),
            soft=np.array([True, True, False]),
        ),
        np.array([2.5, 0.5]),
        np.array([0.0, 0.0, 1.0]),
    )


def conflicting():
    """Bounds x <= 1 (soft) against x1 + x2 >= 5 (hard): the bounds give way alike, (2.5, 2.5)."""
    return QuadraticProgram(
        H=2.0 * np.eye(2),
        c=np.zeros(2),
        G=np.array([[1.0, 1.0]]),
        lower=np.array([-10.0, -10.0, 5.0]),
        upper=np.array([1.0, 1.0, 30.0]),
        soft=np.array([True, True, False]),
    ), np.array([2.5, 2.5])


def impossible():
    """Two hard rows that contradict each other."""
    return QuadraticProgram(
        H=np.eye(2),
        c=np.zeros(2),
        G=np.array([[1.0, 0.0], [1.0, 0.0]]),
        lower=np.array([-1.0, -1.0, 2.0, -5.0]),
        upper=np.array([1.0, 1.0, 5.0, 1.0]),
        soft=np.array([True, True, False, False]),
    )


def control_program(arm, start, generator):
    """A program of one control period at a random state, limits often active, with a random tracking weight."""
    limits = arm.limits
    q = np.clip(start + generator.uniform(-0.4, 0.4, 7), limits.lower, limits.upper)
    v = generator.uniform(-0.5, 0.5, 7) * limits.velocity
    dynamics = arm.dynamics(q, v)
    load = dynamics.bias - arm.counterbalance(q)
    scale = 10.0 ** generator.uniform(-1.0, 1.5)
    root = generator.normal(size=(6, 6)) + np.eye(6)
    weight = root @ root.T / np.linalg.eigvalsh(root @ root.T)[-1]
    wanted = scale * generator.normal(size=6)
    objective = tool_objective(dynamics.jacobian, dynamics.jacobian_drift, wanted, weight)
    torque = limits.torque * generator.uniform(0.05, 1.0)
    return assemble(
        objective + posture_objective(scale * generator.normal(size=7)),
        acceleration_bounds(limits, 0.001, q, v),
        [torque_constraint(dynamics.mass_matrix, load, torque)],
    )
