"""What the arm does about each fault, on both robots and at both control rates: what the README's table says of it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pft_exec.evaluation.assisted_rollouts import task_library
from pft_exec.evaluation.rollouts import LEAST_STRENGTH, Plan, Rollout, run_plan
from pft_exec.evaluation.witness import Witness
from pft_exec.execution import ExecutionLog, TakeBackPlan, assist, prepare
from pft_exec.execution.faults import Fault
from pft_exec.simulation import Mismatch, World

ALONE = Plan(0, "pr2", "raise", (0.0,) * 7, Mismatch(), ())
LED = {
    "pr2": replace(ALONE, label="reach", task="tabletop"),
    "wam": replace(ALONE, robot="wam", label="anchor_left_right", task="anchor"),
}
AT = 0.4
"""s; in the middle of a motion that the robot makes alone."""
ANSWERS = {
    "none": (None, "finished", "on", ""),
    "solver_fails": (Fault("solver_fails", AT), "finished", "slower", "fell back"),
    "solver_nan": (Fault("solver_nan", AT), "finished", "slower", "fell back"),
    "solver_fails for long": (Fault("solver_fails", AT, 0.2), "stopped", "slower", "the solver found nothing"),
    "solver_nan for long": (Fault("solver_nan", AT, 0.2), "stopped", "slower", "not a number"),
    "encoder_spike": (Fault("encoder_spike", AT, seed=1), "finished", "slower", ""),
    "encoder_jump": (Fault("encoder_jump", AT, seed=1), "stopped", "slower", "jumped by 0.200 rad"),
    "encoder_nan": (Fault("encoder_nan", AT, seed=1), "stopped", "slower", "reports no number"),
    "encoder_frozen": (Fault("encoder_frozen", AT), "stopped", "slower", "repeat their last reading"),
    "encoder_frozen from the start": (Fault("encoder_frozen", 0.0), "stopped", "slower", "repeat their last reading"),
    "push of 10 N": (Fault("push", AT, 0.3, 10.0, seed=1), "finished", "on", ""),
    "push of 20 N": (Fault("push", AT, 0.3, 20.0, seed=1), "finished", "aside", ""),
    "push of 40 N": (Fault("push", AT, 0.3, 40.0, seed=1), "finished", "aside", ""),
    "payload": (Fault("payload", AT), "finished", "on", ""),
    "saturation": (Fault("saturation", AT, size=LEAST_STRENGTH["wam"]), "finished", "on", ""),
    "beyond_reach": (Fault("beyond_reach", 0.0), "refused", "on", "beyond the reach"),
}
"""What happens, how it ends, how it gets there, and what the reason says."""
LEFT_OUT = ("sample_late", "sample_repeated", "sample_out_of_order", "sample_nan", "object_lost", "object_jump")

rates = pytest.mark.parametrize("control_period", [1e-3, 2e-3])
robots = pytest.mark.parametrize("robot", ["pr2", "wam"])
led = pytest.mark.parametrize(("robot", "control_period"), [("pr2", 1e-3), ("wam", 2e-3)])


def run(plan: Plan, fault: Fault | None) -> tuple[Rollout, ExecutionLog]:
    """Run a plan with a fault; no rule may be broken, and each stop has its reason in the log."""
    judged, log = run_plan(replace(plan, faults=() if fault is None else (fault,)))
    assert judged.broken_rules == ()
    assert log is not None
    assert (log.event("fault") is None) == (fault is None)
    if judged.ending != "finished":
        assert log.event("stop").detail == judged.reason
    return judged, log


@pytest.mark.slow
@robots
@rates
@pytest.mark.parametrize("name", ANSWERS)
def test_a_fault_while_the_robot_has_the_arm(robot: str, control_period: float, name: str) -> None:
    fault, ending, went, reason = ANSWERS[name]
    judged, _ = run(replace(ALONE, robot=robot, control_period=control_period), fault)
    assert (judged.ending, judged.went) == (ending, went), judged.reason
    assert reason in judged.reason


@pytest.mark.slow
@led
@pytest.mark.parametrize("kind", LEFT_OUT)
def test_a_fault_of_samples_or_camera_while_a_hand_leads_changes_nothing(
    robot: str, control_period: float, kind: str
) -> None:
    judged, log = run(replace(LED[robot], control_period=control_period), Fault(kind, 1.0, seed=1))
    assert judged.ending == "finished"
    assert log.success, log.reason
    assert log.label == LED[robot].label


@pytest.mark.slow
@led
@pytest.mark.parametrize(
    ("fault", "reason"),
    [
        (Fault("encoder_jump", 1.0, seed=1), "jumped by 0.200 rad"),
        (Fault("encoder_frozen", 1.0), "repeat their last reading"),
        (Fault("encoder_frozen", 0.0), "repeat their last reading"),
    ],
)
def test_an_arm_that_is_not_seen_is_not_led_on(robot: str, control_period: float, fault: Fault, reason: str) -> None:
    """It stops within a tenth of a second: blind, it can swing under the hand far beyond its velocity limit."""
    judged, log = run(replace(LED[robot], control_period=control_period), fault)
    assert judged.ending == "stopped"
    assert reason in judged.reason
    assert log.event("stop").time - fault.start < 0.1
    assert log.event("take_over") is None


@pytest.mark.slow
def test_the_person_takes_back_what_was_wrongly_recognized() -> None:
    library = task_library("pr2", "tabletop")
    wrong = Fault("wrong_recognition", 0.0, 2.2, name="go_home")
    with World("pr2", "tabletop", seed=0, control_period=2e-3) as world:
        prepare(world, "reach", seed=0)
        witness = Witness("right", world.arm("right"))
        plans = [TakeBackPlan("reach", after=0.4)]
        log = assist(world, library, "reach", seed=0, faults=[wrong], take_backs=plans, observer=witness.look)
    assert "go_home" in log.event("take_over").detail
    assert log.event("take_back") is not None
    assert log.label == "reach"
    assert log.success, log.reason
    assert witness.torque <= 1.0 + 1e-9
    assert witness.driven <= 1.0
