"""The benchmark of the hand-off: its floors hold on a few states, and the alternative beside it is worse."""

from __future__ import annotations

import pytest

from pft_exec.evaluation.benchmarks import assisted_seams, handoff
from pft_exec.evaluation.protocol import silent


@pytest.fixture(scope="module")
def tables():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(handoff, "STATES", 40)
        patch.setattr(handoff, "LOOPS", 2)
        patch.setattr(handoff, "PUSHES", 3)
        patch.setattr(assisted_seams, "RUNS", 2)
        return list(handoff.measure_handoff(0, silent).values())


def test_every_state_joins_its_tube_without_a_jump_and_switching_directly_jumps(tables):
    planned, alone, direct = tables[0]
    assert planned["found %"] == 100.0
    assert planned["p99"] <= 0.7
    assert planned["jump rad"] <= 1e-6
    assert planned["jump rad/s"] <= 1e-6
    assert planned["jump rad/s2 / (jerk x period)"] <= 1.0
    assert planned["Mahalanobis rise, largest"] <= 0.3
    assert planned["Mahalanobis rise, largest"] <= alone["Mahalanobis rise, largest"]
    assert direct["jump rad"] > 0.05


def test_the_torque_steps_little_at_the_seams_and_much_without_a_transition(tables):
    rows = {(row["plant"], row["way"]): row for row in tables[1]}
    for (_, way), row in rows.items():
        if way == "transition":
            assert row["torque step, largest"] <= 0.5
        else:
            assert row["torque step, largest"] > 5.0
    assert rows["perfect", "transition"]["at the join, largest"] <= 0.5


def test_a_hand_that_lets_go_slowly_makes_no_larger_step(tables):
    for row in tables[2]:
        assert row["taken over"] == "2 of 2"
        assert row["torque step, largest"] <= 0.5


def test_a_force_that_begins_at_the_seam_does_little(tables):
    assert all(row["torque step, largest"] <= 0.75 for row in tables[3])


def test_a_strong_push_takes_back_in_time_and_a_weak_one_never(tables):
    for row in tables[4]:
        if row["push"].startswith(("20 N", "40 N")):
            assert row["taken back %"] == 100.0
            assert row["free ms, median"] <= 20.0
            assert row["free ms, longest"] <= (40.0 if "noise" in row["push"] else 20.0)
            assert row["of slow joints"] <= 0.5
            assert row["beyond the push"] <= 0.5
        else:
            assert row["taken back %"] == 0.0
