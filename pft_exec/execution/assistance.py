"""Assistance: a person begins a motion, the robot recognizes it, takes over and finishes it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from pft_exec.control import GravityCompensation
from pft_exec.execution.autonomous import SOFTNESS, about_run, end_figures, judge_end, told
from pft_exec.execution.control_loop import ControlLoop, Observer
from pft_exec.execution.hand_path import Hand, lead_motion
from pft_exec.execution.log import ExecutionLog, Stage
from pft_exec.execution.pursuit import Pursuit
from pft_exec.execution.stopping import stop
from pft_exec.execution.takeover import Takeover, plan_takeover, tube_compliance
from pft_exec.execution.watch import attendants_of, supervisors_of
from pft_exec.geometry import geodesic_distance
from pft_exec.handoff import Decision, PolicySettings, TakeoverPolicy
from pft_exec.learning import FlowTube, MotionLibrary
from pft_exec.recognition import Belief, OnlineRecognizer
from pft_exec.simulation import Push, World

Answer = Callable[[tuple[str, ...], Belief], str | None]
"""The person's answer to "which of these?": a label, or None for neither."""

PACE_RANGE = (0.5, 1.5)
"""How much slower or faster than taught the person's pace may carry over."""
RETRY = 0.1
"""s after which a take-over that could not be planned is tried again."""
SETTLING = 0.5
"""s that the hand rests at its end before a motion nobody took over counts as over."""


def assist(
    world: World,
    library: MotionLibrary,
    label: str,
    arm: str | None = None,
    *,
    pushes: Sequence[Push] = (),
    seed: int | None = None,
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
    seed : int or None
        None is the world's. Of the hand: its curvature, pace, pauses and tremor.
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
    hand = lead_motion(world, label, loop.name, world.seed if seed is None else seed)
    scene, start = world.scene, world.tool(loop.name)
    tubes = library.flow_tubes(scene, start)
    person = _Person(hand, OnlineRecognizer(tubes, method), TakeoverPolicy(settings), answer or _truthful(label))
    takeover = _guide(loop, person, tubes)
    details = {
        "asked": float(person.asked),
        "take_over_time": loop.time,
        "take_over_share": hand.share(loop.time),
    }
    if takeover is None:
        reason = f"the hand finished by itself: {person.reason}"
        return loop.log.finish(False, reason, details=details, **about_run(loop))
    tube = tubes[takeover.label]
    compliance = tube_compliance(loop, tube, softness)
    outcome = Pursuit(
        loop,
        takeover,
        compliance,
        solver=solver,
        floating=True,
        supervisors=supervisors_of(loop, tube),
        attendants=attendants_of(loop, tube),
    ).run()
    if outcome.ending != "finished":
        stop(loop, outcome.reason)
    verdict = judge_end(loop, tubes.get(label, tube), scene, start)
    details |= {**end_figures(loop, tube), **takeover.jumps(), "join_time": takeover.transition.duration}
    details["tube_goal_error"] = float(np.linalg.norm(tube.end.position - hand.goal.position))
    details["tube_goal_rotation"] = float(geodesic_distance(tube.end.quaternion, hand.goal.quaternion))
    success = verdict.success and outcome.ending == "finished"
    return loop.log.finish(success, told(verdict, outcome), label=tube.label, details=details, **about_run(loop))


@dataclass
class _Person:
    """Who leads, and what the robot makes of it.

    Parameters
    ----------
    hand : Hand
    recognizer : OnlineRecognizer
    policy : TakeoverPolicy
    answer : callable
    asked : int
        Questions so far.
    reason : str
        Why the robot has not taken over.
    """

    hand: Hand
    recognizer: OnlineRecognizer
    policy: TakeoverPolicy
    answer: Answer
    asked: int = 0
    reason: str = "nothing was recognized"
    _declined: bool = False
    _not_before: float = 0.0

    def decide(self, loop: ControlLoop, belief: Belief, tubes: Mapping[str, FlowTube]) -> Takeover | None:
        """Decide after a belief; a plan where the robot takes over now."""
        decision = self.policy.update(belief, loop.time)
        self.reason = decision.reason
        if decision.kind == "ask":
            self.asked += 1
            reply = self.answer(decision.labels, belief)
            loop.log.event(loop.time, "ask", f"{decision.reason}; the answer is {reply!r}")
            self.policy.answer(reply)
        elif decision.kind == "decline":
            self._decline(loop, decision.reason)
        elif decision.kind == "take_over" and loop.time >= self._not_before:
            return self._take_over(loop, decision, belief, tubes)
        return None

    def _take_over(
        self, loop: ControlLoop, decision: Decision, belief: Belief, tubes: Mapping[str, FlowTube]
    ) -> Takeover | None:
        tube = tubes[decision.label]
        takeover = plan_takeover(loop, tube, *_place_and_pace(tube, belief), np.zeros(len(loop.arm.joint_names)))
        if takeover.reason:
            self.reason, self._not_before = takeover.reason, loop.time + RETRY
            self._decline(loop, takeover.reason)
            return None
        loop.log.event(loop.time, "take_over", decision.reason)
        return takeover

    def _decline(self, loop: ControlLoop, reason: str) -> None:
        """Log why the robot does not take over, the first time."""
        if not self._declined:
            loop.log.event(loop.time, "decline", reason)
        self._declined = True


def _guide(loop: ControlLoop, person: _Person, tubes: Mapping[str, FlowTube]) -> Takeover | None:
    """The hand leads, the arm floats, until the robot takes over or the hand is done."""
    floating = GravityCompensation(loop.arm)
    while loop.time < person.hand.duration + SETTLING:
        if loop.is_sample_due():
            belief = _recognize(loop, person.recognizer)
            takeover = person.decide(loop, belief, tubes)
            if takeover is not None:
                return takeover
        started = perf_counter()
        command = floating.update(loop.time, *loop.sense())
        loop.apply(command, Stage.GUIDED, perf_counter() - started, person.hand.pull)
    return None


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
