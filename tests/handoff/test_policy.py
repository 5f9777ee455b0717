"""The take-over policy: certain for a while, asked when close, declined when unknown, never rash."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.exceptions import ControlError
from pft_exec.handoff import PolicySettings, TakeoverPolicy
from pft_exec.recognition import Belief


def belief(time, probability, unknown=0.01, phase=0.5, flagged=""):
    labels = list(probability)
    best = max(labels, key=probability.get)
    zeros = dict.fromkeys(labels, 0.0)
    return Belief(best, probability, unknown, zeros, dict.fromkeys(labels, phase), zeros, time, flagged)


def kinds(policy, beliefs):
    return [policy.update(each).kind for each in beliefs]


SURE = {"reach": 0.99, "go_home": 0.01}
TORN = {"reach": 0.55, "go_home": 0.45}


def test_it_takes_over_only_after_the_hold_time():
    policy = TakeoverPolicy(PolicySettings(hold_time=0.2, least_time=0.0))
    decisions = [policy.update(belief(0.01 * k, SURE)) for k in range(30)]
    taken = [decision.time for decision in decisions if decision.kind == "take_over"]
    assert min(taken) == pytest.approx(0.2)
    assert decisions[-1].label == "reach"
    assert "'reach'" in decisions[-1].reason


def test_a_break_starts_the_hold_time_anew():
    policy = TakeoverPolicy(PolicySettings(hold_time=0.2, least_time=0.0))
    times = [0.0, 0.1, 0.15, 0.25, 0.34]
    shares = [SURE, SURE, TORN, SURE, SURE]
    assert kinds(policy, [belief(t, p) for t, p in zip(times, shares, strict=True)]) == ["wait"] * 5


def test_another_motion_in_between_starts_the_hold_time_anew():
    policy = TakeoverPolicy(PolicySettings(hold_time=0.2, least_time=0.0))
    other = {"reach": 0.01, "go_home": 0.99}
    assert kinds(policy, [belief(0.0, SURE), belief(0.15, other), belief(0.25, other)]) == ["wait"] * 3


@pytest.mark.parametrize("lacking", [{"least_time": 10.0}, {"least_phase": 0.9}])
def test_little_evidence_is_not_enough_however_sure(lacking):
    policy = TakeoverPolicy(PolicySettings(**lacking))
    assert set(kinds(policy, [belief(0.1 * k, SURE) for k in range(20)])) == {"wait"}


def test_two_motions_that_stay_close_are_asked_about_both_named_more_probable_first():
    policy = TakeoverPolicy(PolicySettings(ask_time=1.0))
    decisions = [policy.update(belief(0.1 * k, TORN)) for k in range(14)]
    asked = [decision for decision in decisions if decision.kind == "ask"]
    assert asked[0].time == pytest.approx(1.0)
    assert asked[0].labels == ("reach", "go_home")
    assert "55%" in asked[0].reason
    assert "45%" in asked[0].reason


def test_doubt_late_in_the_motion_is_asked_about_at_once():
    policy = TakeoverPolicy()
    assert policy.update(belief(0.5, TORN, phase=0.8)).kind == "ask"


def test_the_answer_is_taken_over_and_stays():
    policy = TakeoverPolicy()
    policy.update(belief(0.5, TORN, phase=0.8))
    policy.answer("go_home")
    decision = policy.update(belief(0.51, TORN, phase=0.8))
    assert (decision.kind, decision.label) == ("take_over", "go_home")


def test_neither_is_respected_and_the_same_pair_is_not_asked_about_again():
    policy = TakeoverPolicy()
    policy.update(belief(0.5, TORN, phase=0.8))
    policy.answer(None)
    swapped = {"reach": 0.45, "go_home": 0.55}
    later = [belief(0.6 + 0.1 * k, TORN if k % 2 else swapped, phase=0.8) for k in range(30)]
    assert set(kinds(policy, later)) == {"wait"}


def test_an_unknown_motion_is_declined_and_never_taken_over():
    policy = TakeoverPolicy()
    decisions = [policy.update(belief(0.05 * k, SURE, unknown=0.9)) for k in range(40)]
    assert "take_over" not in {decision.kind for decision in decisions}
    assert decisions[-1].kind == "decline"
    assert "none of the motions (90%)" in decisions[-1].reason


def test_a_motion_that_turns_out_to_be_known_is_taken_over_after_all():
    policy = TakeoverPolicy()
    kinds(policy, [belief(0.05 * k, SURE, unknown=0.9) for k in range(20)])
    assert kinds(policy, [belief(1.0 + 0.05 * k, SURE) for k in range(6)])[-1] == "take_over"


def test_a_sample_left_out_changes_nothing():
    policy = TakeoverPolicy(PolicySettings(hold_time=0.2, least_time=0.0))
    policy.update(belief(0.0, SURE))
    assert policy.update(belief(0.1, TORN, flagged="late")).kind == "wait"
    assert policy.update(belief(0.2, SURE)).kind == "take_over"


def test_reset_forgets_everything():
    policy = TakeoverPolicy(PolicySettings(hold_time=0.0, least_time=0.0))
    policy.answer("reach")
    assert policy.update(belief(0.1, TORN)).kind == "take_over"
    policy.reset()
    assert policy.update(belief(0.2, TORN)).kind == "wait"


def test_a_wrong_motion_that_never_reaches_the_threshold_is_never_taken_over():
    """Random beliefs, a thousand of them, none of which is above the threshold for long."""
    generator, policy = np.random.default_rng(0), TakeoverPolicy()
    for k in range(1000):
        share = generator.uniform(0.5, 0.949)
        decision = policy.update(belief(0.01 * k, {"reach": share, "go_home": 1.0 - share}))
        assert decision.kind != "take_over"


@pytest.mark.parametrize(
    ("setting", "message"),
    [({"threshold": 1.5}, "threshold must be a probability"), ({"hold_time": -1.0}, "hold_time must be a time")],
)
def test_impossible_settings_are_refused(setting, message):
    with pytest.raises(ControlError, match=message):
        PolicySettings(**setting)
