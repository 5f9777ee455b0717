"""Yielding: how an arm's torque goes over to floating, and when nobody moves an arm any more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.control import GravityCompensation
from pft_exec.execution.safety.yielding import FADE_RATE, FREE, MASKED, Calm, Yielding
from pft_exec.model import load_robot

STILL = np.zeros(3), np.zeros(7)


@pytest.mark.parametrize("lasting", [0.3, 0.6])
def test_it_is_calm_once_force_and_motion_have_been_small_for_long_enough(lasting: float) -> None:
    calm = Calm(0.0, lasting)
    assert not calm.update(lasting - 0.01, *STILL)
    assert calm.update(lasting, *STILL)


@pytest.mark.parametrize(
    "disturbed", [(np.array([0.0, 0.0, 9.0]), np.zeros(7)), (np.zeros(3), np.full(7, 0.06))], ids=["force", "motion"]
)
def test_a_force_or_a_motion_begins_the_time_anew(disturbed: tuple[np.ndarray, np.ndarray]) -> None:
    calm = Calm(0.0, 0.3)
    assert not calm.update(0.2, *disturbed)
    assert not calm.update(0.4, *STILL)
    assert calm.update(0.5, *STILL)


PERIOD = 0.001


@pytest.mark.parametrize("pressed", [0.0, 20.0], ids=["no push", "20 N m"])
def test_what_pulled_goes_at_a_rate_and_the_sooner_the_harder_a_person_pushes(pressed: float) -> None:
    arm = load_robot("pr2").arm("right")
    q = 0.5 * (arm.limits.lower + arm.limits.upper)
    still, felt = np.zeros(len(q)), np.full(len(q), pressed)
    held = replace(GravityCompensation(arm).update(0.0, q, still), torque=arm.gravity(q) - arm.counterbalance(q) + 10.0)
    yielding = Yielding(arm, PERIOD)
    yielding.begin(0.0, held)
    step = FADE_RATE * PERIOD + MASKED * pressed
    within = np.flatnonzero(arm.limits.torque > np.abs(held.torque))
    before, periods = held.torque, 0
    while not yielding.is_free:
        torque = yielding.update(PERIOD * periods, q, still, felt).torque
        periods += 1
        assert np.all(np.abs(torque - before)[within] <= step + 1e-9)
        before = torque
    assert periods == int(np.ceil((10.0 - FREE) / step))
