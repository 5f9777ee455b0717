"""Assistance: a person begins a motion, the robot recognizes it, takes over and finishes it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from pft_exec.control import GravityCompensation
from pft_exec.execution.autonomous import SOFTNESS, about_run, end_figures, judge_end
from pft_exec.execution.control_loop import ControlLoop, Observer
from pft_exec.execution.hand_path import Hand, lead_motion
from pft_exec.execution.log import ExecutionLog, Stage
from pft_exec.execution.takeover import finish, plan_takeover
from pft_exec.geometry import geodesic_distance
from pft_exec.handoff import Decision, PolicySettings, TakeoverPolicy
from pft_exec.learning import FlowTube, MotionLibrary
from pft_exec.recognition import Belief, OnlineRecognizer
from pft_exec.simulation import Push, World

Answer = Callable[[tuple[str, ...], Belief], str | None]
"""The person's answer to "which of these?": a label, or None for neither."""

PACE_RANGE = (0.5, 1.5)
"""How much slower or faster than taught the person's pace may carry over."""
SETTLING = 0.5
"""s that the hand rests at its end before a motion nobody took over counts as over."""


def assist(
    world: World,
    library: MotionLibrary,
    label: str,
    arm: str | None = None,
    *,
    pushes: Sequence[Push] = (),
    seed: int = 0,
    settings: PolicySettings | None = None,
    answer: Answer | None = None,
    method: str = "phase",
    softness: float = SOFTNESS,
    solver: str = "daqp",
    observer: Observer | None = None,
) -> ExecutionLog:
    """Let the synthetic hand begin a motion in the world's present scene; recognize it, take over, finish it.

    Parameters
    ----------
    world : World
    library : MotionLibrary
        As the arm makes its motions: mirrored (`MotionLibrary.mirrored`) where the other arm was taught.
    label : str
        What the hand begins. Neither recognizer nor policy nor controller sees it.
    arm : str or None
        None is the only arm, else "right".
    pushes : sequence of Push
    seed : int
        Of the hand: its curvature, pace, pauses and tremor.
    settings : PolicySettings or None
        When to take over, ask and decline.
    answer : callable or None
        Asked when two motions stay close; None is the synthetic hand, who says truthfully which of the two it makes.
    method : str
        Of the recognizer.
    softness : float, s^4/m^2
        See `pft_exec.control.compute_compliance`.
    solver : str
        Of the quadratic program.
    observer : callable or None
        Called with the world after every control period.

    Returns
    -------
    ExecutionLog
        `label` is the motion that was taken over, empty where none was; `success` is the task's predicate on the
        motion that the hand began.

    Raises
    ------
    UnknownMotionError
        If the task has no such motion.
    UnreachableError
        Before anything moves, if the arm cannot make the motion in this scene.
    """
    loop = ControlLoop(world, arm, pushes, observer)
    hand = lead_motion(world, label, loop.name, seed)
    scene, start = world.scene, world.tool(loop.name)
    tubes = library.flow_tubes(scene, start)
    recognizer = OnlineRecognizer(tubes, method)
    guided = _guide(loop, hand, recognizer, TakeoverPolicy(settings), answer or _truthful(label))
    details = {"asked": float(guided.asked), "take_over_time": loop.time, "take_over_share": hand.share(loop.time)}
    if guided.decision is None or guided.decision.kind != "take_over":
        reason = "the hand finished by itself: the robot did not take over" + (
            f" ({guided.decision.reason})" if guided.decision else ""
        )
        return loop.log.finish(False, reason, details=details, **about_run(loop))
    tube = tubes[guided.decision.label]
    takeover = plan_takeover(loop, tube, *_place_and_pace(tube, guided.belief), np.zeros(len(loop.arm.joint_names)))
    if takeover.reason:
        loop.log.event(loop.time, "decline", takeover.reason)
        return loop.log.finish(False, takeover.reason, label=tube.label, details=details, **about_run(loop))
    unbroken = finish(loop, takeover, tube, softness=softness, solver=solver, floating=True)
    truth = tubes.get(label, tube)
    verdict = judge_end(loop, truth, scene, start)
    details |= {**end_figures(loop, tube), **takeover.jumps(), "join_time": takeover.transition.duration}
    details["tube_goal_error"] = float(np.linalg.norm(tube.end.position - hand.goal.position))
    details["tube_goal_rotation"] = float(geodesic_distance(tube.end.quaternion, hand.goal.quaternion))
    reason = verdict.reason if unbroken else f"{verdict.reason}; a control period fell back"
    return loop.log.finish(verdict.success, reason, label=tube.label, details=details, **about_run(loop))


@dataclass(frozen=True)
class _Guided:
    """How the guided part ended: the last belief, the last decision (None: nothing was decided), questions asked."""

    belief: Belief
    decision: Decision | None
    asked: int


def _guide(
    loop: ControlLoop, hand: Hand, recognizer: OnlineRecognizer, policy: TakeoverPolicy, answer: Answer
) -> _Guided:
    """The hand leads, the arm floats, until the policy takes over or the hand is done."""
    floating = GravityCompensation(loop.arm)
    asked, declined = 0, False
    belief, decision = _recognize(loop, recognizer), None
    while loop.time < hand.duration + SETTLING:
        if loop.is_sample_due() and loop.time > 0.0:
            belief = _recognize(loop, recognizer)
            decision = policy.update(belief, loop.time)
            if decision.kind == "ask":
                asked += 1
                reply = answer(decision.labels, belief)
                loop.log.event(loop.time, "ask", f"{decision.reason}; the answer is {reply!r}")
                policy.answer(reply)
            elif decision.kind == "take_over":
                loop.log.event(loop.time, "take_over", decision.reason)
                return _Guided(belief, decision, asked)
            elif decision.kind == "decline" and not declined:
                declined = True
                loop.log.event(loop.time, "decline", decision.reason)
        started = perf_counter()
        command = floating.update(loop.time, *loop.sense())
        loop.apply(command, Stage.GUIDED, perf_counter() - started, hand.pull)
    return _Guided(belief, decision, asked)


def _recognize(loop: ControlLoop, recognizer: OnlineRecognizer) -> Belief:
    """Hand the present sample to the recognizer, and log what it believes."""
    tool = loop.world.tool(loop.name)
    gripper = {"gripper": loop.world.gripper(loop.name)}
    belief = recognizer.update(loop.time, tool.position, tool.quaternion, gripper)
    loop.log.belief(loop.time, belief.probability, belief.unknown)
    return belief


def _place_and_pace(tube: FlowTube, belief: Belief) -> tuple[float, float]:
    """Phase of the motion that is taken over, and the person's pace beside the tube's."""
    phase = min(max(belief.phase[tube.label], 0.0), 1.0)
    left = float(tube.time[-1] - np.interp(phase, tube.phase, tube.time))
    pace = left / max(belief.time_to_completion[tube.label], 1e-3)
    return phase, float(np.clip(pace, *PACE_RANGE))


def _truthful(label: str) -> Answer:
    """A person who makes `label` and says so when asked."""
    return lambda labels, _: label if label in labels else None
