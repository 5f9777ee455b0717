"""Assistance: a person begins a motion, the robot recognizes it, takes over and finishes it; the person stays master.

While the hand leads, every sample goes to the recognizer, the policy decides, and the leading motion is made ready.
While the robot has the arm, a force that is felt in the joints gives it back at once; recognition then begins anew.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from pft_exec.exceptions import ControlError, UnreachableError
from pft_exec.execution.autonomous import SOFTNESS, about_run, end_figures, judge_end, told
from pft_exec.execution.candidates import Candidates
from pft_exec.execution.companion import Companion
from pft_exec.execution.control_loop import ControlLoop, Observer
from pft_exec.execution.faults import Fault
from pft_exec.execution.hand.person import Answer, Person, TakeBackPlan
from pft_exec.execution.log import ExecutionLog, Stage
from pft_exec.execution.pursuit import Outcome
from pft_exec.execution.refusal import refusal_here
from pft_exec.execution.safety.force_watch import ForceWatch
from pft_exec.execution.safety.stopping import stop
from pft_exec.execution.safety.watch import pursue
from pft_exec.execution.safety.yielding import CALM, Calm, Yielding
from pft_exec.execution.surroundings import Surroundings
from pft_exec.execution.takeover import Takeover, plan_takeover
from pft_exec.execution.timeliness import undisturbed, warm_up
from pft_exec.geometry import Array, geodesic_distance
from pft_exec.handoff import PolicySettings
from pft_exec.handoff.take_back import THRESHOLD
from pft_exec.learning import MotionLibrary
from pft_exec.simulation import Push, World

LET_GO = 0.15
"""s for which a hand's force fades out when it lets go."""

PUSH = (0.6, 1.5)
"""s: a force that ends so soon after it took the arm back, and after which the arm so soon rests, was only a push."""
GATHERING = 0.6
"""s for which the arm must rest until then: a person who has taken hold may pause, and begins slowly."""


@undisturbed()
def assist(
    world: World,
    library: MotionLibrary,
    label: str,
    arm: str | None = None,
    *,
    pushes: Sequence[Push] = (),
    faults: Sequence[Fault] = (),
    seed: int | None = None,
    settings: PolicySettings | None = None,
    answer: Answer | None = None,
    take_backs: Sequence[TakeBackPlan] = (),
    take_back: float = THRESHOLD,
    let_go: float = LET_GO,
    pace: float = 1.0,
    method: str = "phase",
    softness: float = SOFTNESS,
    solver: str = "daqp",
    avoid: Sequence[str] = (),
    substitute: Mapping[str, str] | None = None,
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
    faults : sequence of Fault
        To be injected; see `pft_exec.execution.faults`.
    settings : PolicySettings or None
        When to take over, ask and decline.
    answer : callable or None
        Asked when two motions stay close; None is the synthetic hand, who says truthfully which of the two it makes.
    take_backs : sequence of TakeBackPlan
        When the hand takes hold again after a take-over, and for which motion.
    take_back : float, N
        Force at the tool, felt in the joints, from which the arm is the person's again.
    let_go : float, s
        For which the hand's force fades out after a take-over.
    pace : float
        Speed relative to the person's own.
    method : str
        Of the recognizer.
    softness : float, s^4/m^2
        See `pft_exec.control.compute_compliance`.
    solver : str
        Of the quadratic program.
    avoid : sequence of str
        Objects and furniture of the task to keep off while the robot has the arm; as in `execute`.
    substitute : {name: name}, optional
        Taught object to the one that takes its place: the hand moves about that one, every motion of the library is
        looked for there, and the end is judged on it.
    observer : callable or None
        Called with the world after every control period.

    Returns
    -------
    ExecutionLog
        `label` is the motion that was taken over last, empty where none was; `success` is the task's predicate on the
        motion that the hand began last.

    Raises
    ------
    UnknownMotionError
        If the task has no such motion.
    ControlError
        If the pace is not positive.
    UnreachableError
        Before anything moves, if the arm cannot make the motion in this scene; with the nearest placement that would
        do, where it is the placement that is at fault.
    MissingObjectError
        If the task has no object that is to be avoided, or the scene none that is to take another's place.
    """
    if not pace > 0.0:
        raise ControlError(f"pace must be positive; got {pace}.")
    loop = ControlLoop(world, arm, pushes, observer, faults)
    if avoid:
        loop.surroundings = Surroundings(world, loop.name, avoid)
    warm_up(loop, solver)
    seed, swaps = world.seed if seed is None else seed, substitute or {}
    try:
        person = Person(loop, label, seed, answer=answer, fade=let_go, plans=take_backs, substitute=swaps)
    except UnreachableError as error:
        raise refusal_here(world, label, loop.name, str(error), swaps) from error
    candidates = Candidates(loop, library, world.scene, world.tool(loop.name), softness, swaps)
    companion = Companion(loop, candidates, person.answer, settings=settings, method=method, pace=pace)
    return _Assistance(loop, person, companion, ForceWatch(loop, take_back), solver).run()


class _Interrupted:
    """A motion that a force at the tool has interrupted: a person who leads from there, or only a push.

    Parameters
    ----------
    takeover : Takeover
    outcome : Outcome
    time : float, s
        When it was interrupted.
    """

    def __init__(self, takeover: Takeover, outcome: Outcome, time: float) -> None:
        self.takeover, self.outcome = takeover, outcome
        self._begin = self._pushed = time
        self._calm = Calm(time, GATHERING)

    def is_over(self, time: float, force: Array, v: Array) -> bool:
        """Whether it was only a push: soon after, nobody moves the arm; force (3,), N, joint speeds (n,), rad/s."""
        if np.linalg.norm(force) > CALM[0]:
            self._pushed = time
        is_calm = self._calm.update(time, force, v)
        return is_calm and self._pushed - self._begin < PUSH[0] and time - self._pushed < PUSH[1]


@dataclass
class _Assistance:
    """One run: who has the arm, until the motion is finished, stopped, or the hand has made it alone.

    Parameters
    ----------
    loop : ControlLoop
    person : Person
    companion : Companion
        What recognizes and decides.
    force : ForceWatch
    solver : str
        Of the quadratic program.
    details : {name: float}
        Figures of the run.
    """

    loop: ControlLoop
    person: Person
    companion: Companion
    force: ForceWatch
    solver: str
    details: dict[str, float] = field(default_factory=dict)
    _brake: Array = field(default_factory=lambda: np.zeros(1))

    def run(self) -> ExecutionLog:
        """Guide and pursue in turn."""
        takeover, outcome, fallbacks = self._guide(None), None, 0
        while takeover is not None:
            self.person.let_go(self.loop.time)
            outcome = pursue(
                self.loop,
                takeover,
                self.force,
                solver=self.solver,
                floating=True,
                person=self.person,
                fading=-self._brake,
            )
            fallbacks += outcome.fallbacks
            self.details |= {
                **takeover.jumps(),
                "join_time": takeover.transition.duration,
                "fallbacks": float(fallbacks),
            }
            if outcome.ending != "taken_back":
                return self._ended(takeover, outcome)
            self._give_back(outcome)
            takeover = self._guide(_Interrupted(takeover, outcome, self.loop.time))
        return self._led_to_the_end()

    def _guide(self, interrupted: _Interrupted | None) -> Takeover | None:
        """The hand leads, the arm floats, until the robot takes over or the hand is done."""
        loop, floating = self.loop, Yielding(self.loop.arm, self.loop.world.control_period)
        command = None if interrupted is None else interrupted.outcome.command
        floating.begin(loop.time, command)
        while not self.person.is_done(loop.time):
            started = perf_counter()
            q, v = loop.sense()
            if loop.guard.is_lost:
                break
            self.force.feel(q, v, command)
            takeover = self.companion.attend()
            if takeover is None and interrupted is not None:
                force = self.force.beyond_friction(q, v)
                takeover = self._go_on(interrupted) if interrupted.is_over(loop.time, force, v) else None
            if takeover is not None:
                self._note_guidance()
                return takeover
            if loop.arm is not floating.arm:
                floating.carry(loop.arm)
            command = floating.update(loop.time, q, v)
            self._brake = floating.brake
            loop.apply(command, Stage.GUIDED, perf_counter() - started, self.person.pull)
        self._note_guidance()
        return None

    def _go_on(self, interrupted: _Interrupted) -> Takeover | None:
        """Nobody leads: it was a push, and the motion goes on where it was; None where that cannot be."""
        before, phase = interrupted.takeover, interrupted.outcome.phase
        takeover = plan_takeover(self.loop, before.candidate, phase, before.trajectory.time_law.rate)
        if takeover.reason:
            return None
        self.loop.log.event(self.loop.time, "take_over", f"nobody leads: {takeover.label!r} goes on")
        return takeover

    def _give_back(self, outcome: Outcome) -> None:
        """The person takes the arm back: recognition begins anew from here."""
        self.loop.log.event(self.loop.time, "take_back", outcome.reason)
        self.details["taken_back"] = self.details.get("taken_back", 0.0) + 1.0
        self.companion.begin_anew()

    def _note_guidance(self) -> None:
        time = self.loop.time
        self.details |= {
            "asked": float(self.companion.asked),
            "take_over_time": time,
            "take_over_share": self.person.share(time),
        }

    def _led_to_the_end(self) -> ExecutionLog:
        guard = self.loop.guard
        reason = guard.reason if guard.is_lost else f"the hand finished by itself: {self.companion.reason}"
        if guard.is_lost:
            stop(self.loop, reason)
        return self.loop.log.finish(False, reason, details=self.details, **about_run(self.loop))

    def _ended(self, takeover: Takeover, outcome: Outcome) -> ExecutionLog:
        """The log of a run whose last motion was finished or stopped."""
        loop, person, tube = self.loop, self.person, takeover.tube
        if outcome.ending != "finished":
            stop(loop, outcome.reason)
        meant = self.companion.candidates.tubes.get(person.label, tube)
        verdict = judge_end(loop, meant, person.scene, person.start, person.substitute)
        goal = person.hand.goal
        self.details |= end_figures(loop, tube)
        self.details["tube_goal_error"] = float(np.linalg.norm(tube.end.position - goal.position))
        if tube.quaternion is not None:
            self.details["tube_goal_rotation"] = float(geodesic_distance(tube.end.quaternion, goal.quaternion))
        return loop.log.finish(
            verdict.success and outcome.ending == "finished",
            told(verdict, outcome),
            label=tube.label,
            details=self.details,
            **about_run(loop),
        )
