"""Transitions beside a narrow tube: they do not move away from it first, in the same time or less, limits kept."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.evaluation.benchmarks.joining import random_starts
from pft_exec.handoff import plan_transition, transition
from pft_exec.handoff.near_tube import RISE, rise
from pft_exec.handoff.transition import SLOW


class Case:
    """One state beside a moving target of a tube."""

    def __init__(self, arm, start):
        self.state = start.q, start.v, np.zeros(7)
        self.limits = arm.limits
        self._arm, self._start = arm, start

    def target(self, time):
        reference = self._start.target.at(time)
        return reference.configuration, reference.velocity, reference.acceleration

    def deviation(self, time, q):
        return self._start.place.metric.deviation(self._arm, self._start.target.at(time), q)

    def plan(self, **settings):
        return plan_transition(self.state, self.target, self.limits, **settings)

    def rise(self, plan):
        return rise(plan.at, plan.duration, self.deviation, 60)


@pytest.fixture(scope="module")
def cases(arm):
    return [Case(arm, start) for start in random_starts(arm, 400, 0)]


@pytest.fixture(scope="module")
def hard(cases):
    """Those whose transition by ruckig alone rises, or is slow."""
    plans = [(case, case.plan()) for case in cases]
    found = [(case, plan) for case, plan in plans if case.rise(plan) > 0.3 or plan.duration > SLOW]
    assert len(found) >= 5
    return found


def test_none_moves_away_from_its_tube_first(cases):
    for case in cases:
        plan = case.plan(deviation=case.deviation)
        assert plan.found
        assert case.rise(plan) <= 0.3


def test_what_moved_away_or_was_slow_is_replaced_within_the_limits(hard):
    for case, quickest in hard:
        plan = case.plan(deviation=case.deviation)
        assert case.rise(quickest) > RISE or plan.duration <= quickest.duration
        times = np.arange(0.0, plan.duration, 1e-3)
        q, v, a = (np.array(part) for part in zip(*(plan.at(time) for time in times), strict=True))
        limits = case.limits
        assert (q >= limits.lower).all()
        assert (q <= limits.upper).all()
        assert (np.abs(v) <= limits.velocity).all()
        assert (np.abs(a) <= 1.01 * limits.acceleration).all()
        assert (np.abs(np.diff(a, axis=0)) <= 1.2e-3 * limits.jerk).all()  # between its own ends, the target's adds
        np.testing.assert_allclose(np.diff(q, axis=0), 0.5e-3 * (v[1:] + v[:-1]), atol=1e-7)


def test_it_begins_at_the_state_and_ends_on_the_target(hard):
    for case, _ in hard:
        plan = case.plan(deviation=case.deviation)
        for got, expected in zip(plan.at(1e-12), case.state, strict=True):
            np.testing.assert_allclose(got, expected, atol=1e-6)
        for got, expected in zip(plan.at(plan.duration * (1.0 - 1e-12)), case.target(plan.duration), strict=True):
            np.testing.assert_allclose(got, expected, atol=1e-6)


def test_where_ruckigs_serves_it_is_taken_as_it_is(cases, monkeypatch):
    monkeypatch.setattr(transition, "plan_near_tube", None)
    easy = [case for case in cases if case.rise(case.plan()) <= 0.1 and case.plan().duration <= SLOW]
    assert len(easy) > 0.9 * len(cases)
    for case in easy[:50]:
        with_tube, alone = case.plan(deviation=case.deviation), case.plan()
        assert with_tube.duration == alone.duration
        np.testing.assert_array_equal(with_tube.at(0.1)[0], alone.at(0.1)[0])


def test_where_no_program_has_an_answer_ruckigs_transition_stays(hard, monkeypatch):
    monkeypatch.setattr(transition, "plan_near_tube", lambda *_: None)
    for case, quickest in hard:
        assert case.plan(deviation=case.deviation).duration == quickest.duration


def test_a_target_that_is_not_finite_later_is_a_reason_not_to(cases):
    case = cases[0]
    spoiled = lambda t: tuple(part if t < 0.1 else np.nan * part for part in case.target(t))  # noqa: E731
    plan = plan_transition(case.state, spoiled, case.limits, deviation=case.deviation)
    assert not plan.found
    assert plan.reason
