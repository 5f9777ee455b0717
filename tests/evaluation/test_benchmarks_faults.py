"""Random rollouts with faults: drawn from a seed alone, judged by the plant, counted by fault."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pft_exec.evaluation import rollouts
from pft_exec.evaluation.assisted_rollouts import KINDS as ASSISTED_KINDS
from pft_exec.evaluation.benchmarks.faults import measure_faults, read_record, tables_of
from pft_exec.evaluation.rollouts import KINDS, LEAST_STRENGTH, Plan, Rollout, draw_plan
from pft_exec.simulation import Mismatch

STILL = Plan(0, "pr2", "raise", (0.0,) * 7, Mismatch(), ())


def rollout(seed: int = 0, **changes) -> Rollout:
    usual = Rollout(seed, "pr2", ("push",), "finished", "", "on", 0.5, 0.5, -0.3, True, 2.0, 0.001)
    return replace(usual, **changes)


def test_a_seed_alone_draws_a_rollout() -> None:
    plans = [draw_plan(seed) for seed in range(300)]
    assert plans == [draw_plan(seed) for seed in range(300)]
    assert {plan.robot for plan in plans} == {"pr2", "wam"}
    assert {fault.kind for plan in plans for fault in plan.faults if not plan.task} == set(KINDS) - {"none"}
    assert {fault.kind for plan in plans for fault in plan.faults if plan.task} == set(ASSISTED_KINDS) - {"none"}
    weak = [(plan.robot, fault.size) for plan in plans for fault in plan.faults if fault.kind == "saturation"]
    assert all(size >= LEAST_STRENGTH[robot] for robot, size in weak)


@pytest.mark.parametrize(
    ("changes", "rule"),
    [
        ({"torque": 1.001}, "torque"),
        ({"driven": 1.02}, "velocity"),
        ({"trespass": 0.001}, "position"),
        ({"is_finite": False}, "finite"),
        ({"ending": "exception"}, "exception"),
        ({"ending": "stopped", "reason": ""}, "reason"),
    ],
)
def test_each_rule_that_is_broken_is_named(changes: dict[str, object], rule: str) -> None:
    assert rollout().broken_rules == ()
    assert rule in rollout(**changes).broken_rules


def test_tables_count_what_became_of_rollouts() -> None:
    stopped = rollout(1, ending="stopped", reason="joint 3 jumped by 0.2 rad", faults=("encoder_jump", "push"))
    tables = tables_of([rollout(), rollout(2, went="slower"), stopped, rollout(3, torque=2.0)])
    by_fault = {row["fault"]: row for row in tables["rollouts by fault"]}
    assert by_fault["push"]["rollouts"] == by_fault["all"]["rollouts"] == 4
    assert by_fault["push"]["went on"] == 2
    assert by_fault["encoder_jump"]["stopped"] == 1
    assert tables["what must never happen (floor: 0)"][0]["torque beyond limit"] == 1
    assert tables["why they stopped"] == [{"reason": "joint # jumped by # rad", "rollouts": 1}]
    assert [row["seed"] for row in tables["rollouts that broke a rule"]] == [3]


def test_a_study_goes_on_from_its_record_and_forgives_a_line_that_was_cut_off(tmp_path, monkeypatch) -> None:
    run: list[int] = []

    def roll_out(seed: int) -> Rollout:
        run.append(seed)
        return rollout(seed)

    monkeypatch.setattr(rollouts, "roll_out", roll_out)
    record = tmp_path / "rollouts.jsonl"
    measure_faults(7, lambda *_: None, 3, record=record)
    record.write_text(record.read_text()[:-5])
    assert read_record(record) == [rollout(7), rollout(8)]
    tables = measure_faults(7, lambda *_: None, 4, record=record)
    assert run == [7, 8, 9, 9, 10]
    assert tables["what must never happen (floor: 0)"][0]["rollouts"] == 4
    assert read_record(record) == [rollout(seed) for seed in (7, 8, 9, 10)]
