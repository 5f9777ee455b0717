"""The witness: whose doing it is that a joint passes a limit."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.evaluation.witness import GIVE, Witness
from pft_exec.model import load_robot

ARM = load_robot("pr2").arm("right")
JOINT = 1


class Plant:
    """A world in which one joint is where it is said to be, and its motor does what is said."""

    def __init__(self, beyond: float, effort: float) -> None:
        q = ARM.configuration("teach").copy()
        q[JOINT] = ARM.limits.hard_upper[JOINT] + beyond
        torque = ARM.gravity(q) - ARM.counterbalance(q)
        torque[JOINT] += effort
        self._state, self._torque = (q, np.zeros(7)), torque

    def true_state(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        assert name == "right"
        return self._state

    def torque(self, name: str) -> np.ndarray:
        assert name == "right"
        return self._torque


def seen(beyond: float, effort: float) -> Witness:
    witness = Witness("right", ARM)
    witness.look(Plant(beyond, effort))
    return witness


def test_a_motor_that_presses_a_joint_beyond_its_end_trespasses() -> None:
    assert seen(0.003, 1.0).trespass == pytest.approx(0.003)


def test_a_joint_that_is_pressed_against_its_end_while_its_motor_resists_does_not() -> None:
    witness = seen(0.003, -1.0)
    assert witness.beyond == pytest.approx(0.003)
    assert witness.trespass == 0.0


def test_nothing_presses_a_joint_far_beyond_its_end_unnoticed() -> None:
    assert seen(GIVE + 0.001, -1.0).trespass == pytest.approx(GIVE + 0.001)


def test_within_the_limits_nothing_trespasses() -> None:
    assert seen(-0.01, 1.0).trespass == 0.0
