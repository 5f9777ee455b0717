"""The person: a synthetic one who begins a motion, lets go, answers, and may take the arm back for another motion.

It stands on the side of the physics: the recognizer, the policy and the controllers see nothing of it but what its hand
does to the tool.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pft_exec.demonstration import Scene
from pft_exec.exceptions import ControlError, UnreachableError
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.hand.hand_path import Hand, lead_motion
from pft_exec.execution.pursuit import Instant
from pft_exec.geometry import Array, Pose
from pft_exec.recognition import Belief

Answer = Callable[[tuple[str, ...], Belief], str | None]
"""The person's answer to "which of these?": a label, or None for neither."""

SETTLING = 0.5
"""s that the hand rests at its end before a motion nobody took over counts as over."""


@dataclass(frozen=True)
class TakeBackPlan:
    """When a synthetic person takes the arm back, and what they make of it.

    Parameters
    ----------
    label : str
        The motion that the hand makes from there.
    after : float, s
        Time after a take-over.
    phase : float
        Place along the tube that must have been passed too, in [0, 1].

    Raises
    ------
    ControlError
        If the time is negative or the phase outside [0, 1].
    """

    label: str
    after: float = 0.5
    phase: float = 0.0

    def __post_init__(self) -> None:
        if not (self.after >= 0.0 and 0.0 <= self.phase <= 1.0):
            raise ControlError(
                f"a person takes back at a time of at least 0 s and a phase in [0, 1]; got {self.after}, {self.phase}."
            )


class Person:
    """A synthetic person at the tool of one arm.

    Parameters
    ----------
    loop : ControlLoop
    label : str
        The motion that the hand begins.
    seed : int
    answer : callable or None
        None says truthfully which of two motions it makes.
    fade : float, s
        For which the hand's force fades out where the robot takes over.
    plans : sequence of TakeBackPlan
        One for each time that the arm is taken back, in order.
    substitute : {name: name}, optional
        Object that the task names to the one that the hand takes in its place.

    Raises
    ------
    UnreachableError
        If the arm cannot be led through the motion.
    UnknownMotionError
        If the task has no such motion.
    """

    def __init__(
        self,
        loop: ControlLoop,
        label: str,
        seed: int,
        *,
        answer: Answer | None = None,
        fade: float = 0.0,
        plans: Sequence[TakeBackPlan] = (),
        substitute: Mapping[str, str] | None = None,
    ) -> None:
        for plan in plans:
            loop.world.task.motion(plan.label)
        self._loop, self._seed, self._fade = loop, seed, fade
        self._plans = list(plans)
        self._answer = answer
        self.substitute = dict(substitute or {})
        self._taken_over = np.inf
        self.grips = 0
        self._grip(label)

    def _grip(self, label: str) -> None:
        loop = self._loop
        seed = self._seed + 7919 * self.grips
        self.hand: Hand = lead_motion(loop.world, label, loop.name, seed, substitute=self.substitute)
        self.label = label
        self.begin = loop.time
        self.scene: Scene = loop.world.scene
        self.start: Pose = loop.world.tool(loop.name)
        self.holds = True
        self.grips += 1

    def pull(self, time: float) -> Array:
        """Force, N, and torque, N m, (6,), on the tool at a time of the run, s, world frame."""
        return self.hand.pull(time - self.begin)

    def share(self, time: float) -> float:
        """Share of the motion that the hand has made by a time of the run, s."""
        return self.hand.share(time - self.begin)

    def is_done(self, time: float) -> bool:
        """Whether the hand has made its motion to the end, s, and rests."""
        return time - self.begin >= self.hand.duration + SETTLING

    def let_go(self, time: float) -> None:
        """The robot has taken over: the hand lets go."""
        if not self.holds:
            return
        self.hand.guide.let_go(time - self.begin, self._fade)
        self.holds, self._taken_over = False, time

    def answer(self, labels: tuple[str, ...], belief: Belief) -> str | None:
        """Answer which of some motions it is."""
        if self._answer is not None:
            return self._answer(labels, belief)
        return self.label if self.label in labels else None

    def attend(self, now: Instant) -> None:
        """Take hold of the tool again where it was planned: the hand begins its next motion from where the tool is."""
        if self.holds or not self._plans:
            return
        plan = self._plans[0]
        if now.time - self._taken_over < plan.after or now.phase < plan.phase:
            return
        self._plans.pop(0)
        try:
            self._grip(plan.label)
        except UnreachableError as error:
            self._loop.log.event(now.time, "person", f"cannot take back: {error}")
        else:
            self._loop.log.event(now.time, "grip", f"the hand takes hold again for {plan.label!r}")
