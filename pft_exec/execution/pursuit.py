"""The pursuit: a planned take-over carried out, one control period after the other, until something ends it.

One period is: sense, supervise, command, apply, let the reference's time advance, attend. Supervisors look before the
command and may slow the reference down along the tube or end the pursuit; attendants act after the period, such as on
what the tube says of the gripper. How a pursuit ends is a value.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Literal

import numpy as np

from pft_exec.control import (
    Command,
    JointReference,
    Reference,
    TrackingController,
    joined,
    load_solver,
)
from pft_exec.control.tracking import BLENDING_TIME
from pft_exec.execution.candidates import SAMPLES_PER_PERIOD
from pft_exec.execution.control_loop import ControlLoop, Pull
from pft_exec.execution.log import Stage
from pft_exec.execution.takeover import Takeover, beyond_reach
from pft_exec.geometry import Array
from pft_exec.handoff import PacedClock

TOLD_MASS = 0.2
"""kg; an unknown load that is worth telling of: a friction error of a tenth looks like as much."""
HOLD_TIME = 0.4
"""s of rest at the tube's end before a pursuit counts as finished."""

Ending = Literal["finished", "taken_back", "stopped"]


@dataclass(frozen=True, eq=False)
class Instant:
    """One control period of a pursuit, as supervisors and attendants see it.

    Parameters
    ----------
    time : float, s
        Since the run began.
    clock : float, s
        Of the reference, since the take-over; behind the time where the pursuit was slowed down.
    stage : Stage
    configuration, velocity : (n,), rad, rad/s
        As sensed at the beginning of the period.
    command : Command or None
        The last one: for a supervisor the period before (None in the first), for an attendant this period's.
    """

    time: float
    clock: float
    stage: Stage
    configuration: Array
    velocity: Array
    command: Command | None

    @property
    def phase(self) -> float:
        """Place along the tube, in [0, 1], of the last command."""
        return 0.0 if self.command is None else self.command.phase


@dataclass(frozen=True)
class Verdict:
    """What a supervisor wants.

    Parameters
    ----------
    rate : float
        Pace of the reference beside the planned one: 1 goes on, between 0 and 1 slows down along the tube, 0 waits.
    ending : "taken_back", "stopped" or None
        None goes on.
    reason : str
        For people to read.
    """

    rate: float = 1.0
    ending: Ending | None = None
    reason: str = ""


GO_ON = Verdict()
Supervisor = Callable[[Instant], Verdict]
Attendant = Callable[[Instant], None]


@dataclass(frozen=True, eq=False)
class Outcome:
    """How a pursuit ended.

    Parameters
    ----------
    ending : "finished", "taken_back" or "stopped"
    reason : str
        Why, where it did not finish.
    phase : float
        Place along the tube, in [0, 1], where it ended.
    fallbacks : int
        Control periods that had to fall back to gravity compensation.
    command : Command or None
        The last one; None where it ended before the first.
    """

    ending: Ending
    reason: str
    phase: float
    fallbacks: int
    command: Command | None


class Pursuit:
    """Carry out a take-over: transition, tube, rest.

    Parameters
    ----------
    loop : ControlLoop
    takeover : Takeover
        Without a `reason`.
    solver : str
        Of the quadratic program.
    floating : bool
        Whether the arm floated until now; then friction feed-forward and damping are blended.
    supervisors : sequence of Supervisor
        Asked in turn before each command; the slowest rate counts, and the first ending.
    attendants : sequence of Attendant
        Called in turn after each period.
    pull : callable or None
        The hand, as long as it has not quite let go.
    fading : (n,), N m, or None
        Torque that acted until now beside what a floating arm needs; it fades out.
    """

    def __init__(
        self,
        loop: ControlLoop,
        takeover: Takeover,
        *,
        solver: str = "daqp",
        floating: bool = False,
        supervisors: Sequence[Supervisor] = (),
        attendants: Sequence[Attendant] = (),
        pull: Pull | None = None,
        fading: Array | None = None,
    ) -> None:
        self.loop = loop
        self._fading, self._begin = fading, loop.time
        self.takeover = takeover
        self.clock = PacedClock()
        self._supervisors: tuple[Supervisor, ...] = (self._get_on, *supervisors)
        self._attendants, self._pull = tuple(attendants), pull
        self._fallbacks = 0
        self._command: Command | None = None
        working = loop.injector.solver(load_solver(solver))
        is_careful = loop.surroundings is not None
        self._controller = TrackingController(loop.arm, loop.world.control_period, working, is_careful)
        self._reference = joined(takeover.transition.at, takeover.transition.duration, takeover.trajectory.at)
        self._foreseen = joined(takeover.transition.at, takeover.transition.duration, takeover.trajectory.foreseen)
        self._controller.follow(self._paced, takeover.compliance, loop.time, blend=floating, ahead=self._ahead)
        if self.stage is not Stage.TRANSITION:  # there already: nothing to join
            self._note_join()

    def run(self) -> Outcome:
        """Go on to the end, whichever it is."""
        outcome = None
        while outcome is None:
            outcome = self.period()
        return outcome

    def period(self) -> Outcome | None:
        """One control period; an outcome ends the pursuit, and where it is not "finished", nothing was applied."""
        if self.clock.time >= self.takeover.duration + HOLD_TIME:
            return self._outcome("finished", "")
        started = perf_counter()
        q, v = self.loop.sense()
        verdict = self._supervise(self._instant(q, v))
        if verdict.ending is not None:
            return self._outcome(verdict.ending, verdict.reason)
        if self.loop.arm is not self._controller.arm:
            self._controller.carry(self.loop.arm, self.loop.time)
        if self.loop.surroundings is not None and self.loop.surroundings.is_due:
            self._controller.avoid(self.loop.surroundings.look(), self.loop.time)
        command = self._faded(self._controller.update(self.loop.time, q, v))
        stage = self.stage
        self.loop.apply(command, stage, perf_counter() - started, self._pull, self.clock.rate)
        self._note(command)
        self.clock.advance(self.loop.world.control_period, verdict.rate)
        if stage is Stage.TRANSITION and self.stage is not stage:
            self._note_join()
        for attend in self._attendants:
            attend(self._instant(q, v))
        return None

    @property
    def stage(self) -> Stage:
        """Of the period that comes now."""
        if self.clock.time < self.takeover.transition.duration:
            return Stage.TRANSITION
        return Stage.TUBE if self.clock.time < self.takeover.duration else Stage.HOLD

    def _paced(self, _: float) -> JointReference:
        """The reference now, at the pace of the clock."""
        return paced(self._reference, self.clock)

    def _ahead(self, time: float) -> JointReference:
        """The reference at a time of the run, s, to come, at the present pace and as far as its path is known."""
        return self._foreseen(self.clock.time + self.clock.rate * max(time - self.loop.time, 0.0))

    def _instant(self, q: Array, v: Array) -> Instant:
        return Instant(self.loop.time, self.clock.time, self.stage, q, v, self._command)

    def _supervise(self, instant: Instant) -> Verdict:
        """All supervisors' verdicts in one: the slowest rate, the first ending."""
        rate = 1.0
        for supervise in self._supervisors:
            verdict = supervise(instant)
            if verdict.ending is not None:
                return verdict
            rate = min(rate, verdict.rate)
        return GO_ON if rate == 1.0 else Verdict(max(rate, 0.0))

    def _faded(self, command: Command) -> Command:
        """A command with what is left of the torque that acted before the pursuit."""
        left = 1.0 - (self.loop.time - self._begin) / BLENDING_TIME
        if self._fading is None or left <= 0.0:
            return command
        limit = self.loop.arm.limits.torque
        return replace(command, torque=np.clip(command.torque + left * self._fading, -limit, limit))

    def _get_on(self, _: Instant) -> Verdict:
        """Extend the joint path; what comes later may turn out to be out of reach, or too fast for the planned pace."""
        trajectory = self.takeover.trajectory
        trajectory.path.extend(SAMPLES_PER_PERIOD)
        reason = beyond_reach(trajectory.path, self.takeover.label, self.loop.name)
        return Verdict(ending="stopped", reason=reason) if reason else Verdict(trajectory.slower)

    def _note(self, command: Command) -> None:
        self._command = command
        if command.fallback:
            self._fallbacks += 1
            if self._fallbacks == 1:
                self.loop.log.event(self.loop.time, "fallback", command.status)

    def _note_join(self) -> None:
        join, label = self.takeover.transition.duration, self.takeover.label
        self.loop.log.event(self.loop.time, "joined", f"the tube of {label!r} {join:.3f} s after the take-over")
        unknown = self._controller.unknown_mass
        if abs(unknown) >= TOLD_MASS:
            self.loop.log.event(self.loop.time, "payload", f"{unknown:.2f} kg that no model knows of are held")

    def _outcome(self, ending: Ending, reason: str) -> Outcome:
        phase = 0.0 if self._command is None else self._command.phase
        return Outcome(ending, reason, phase, self._fallbacks, self._command)


def paced(reference: Reference, clock: PacedClock) -> JointReference:
    """A reference where its clock is now, velocity and acceleration at the clock's rate."""
    planned = reference(clock.time)
    if clock.rate == 1.0 and clock.change == 0.0:
        return planned
    return JointReference(
        planned.configuration,
        clock.rate * planned.velocity,
        clock.rate**2 * planned.acceleration + clock.change * planned.velocity,
        planned.phase,
    )
