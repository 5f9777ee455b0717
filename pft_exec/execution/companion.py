"""The companion: goes with a person's motion, recognizes it, and decides when to take over, to ask and to decline.

It sees samples of the tool, the gripper and the objects, and nothing of the person.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pft_exec.exceptions import ControlError
from pft_exec.execution.candidates import Candidates
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.faults import Sample
from pft_exec.execution.grasping import GRIPPER_CLOSED, GRIPPER_WIDTH, handles_objects
from pft_exec.execution.safety.scene_watch import SceneWatch
from pft_exec.execution.takeover import Takeover, plan_takeover
from pft_exec.handoff import Decision, PolicySettings, TakeoverPolicy
from pft_exec.learning import FlowTube
from pft_exec.recognition import Belief, OnlineRecognizer

PACE_RANGE = (0.5, 1.5)
"""How much slower or faster than taught the person's pace may carry over."""
RETRY = 0.1
"""s after which a take-over that could not be planned is tried again."""

STRAYS, LATE_PHASE = 0.02, 0.9
"""m, and in [0, 1]: a transition that would lead the tool so much farther from the tube than it was waits for a
better moment, as long as the hand still leads and the motion is not this far on."""
SOON = 0.05
"""s after which a better moment is looked for."""

GRASPING = 0.12
"""s after a take-back that the hand takes to pull the tool from the robot's way onto its own."""


class Companion:
    """Recognize and decide, control period by control period, while a person leads.

    Parameters
    ----------
    loop : ControlLoop
    candidates : Candidates
        Of the scene and the start of the motion.
    answer : callable
        Asked which of some motions it is, with the belief; a label, or None for none of them.
    settings : PolicySettings or None
    method : str
        Of the recognizer.
    pace : float
        Speed relative to the person's own.

    Raises
    ------
    ControlError
        If the library has no motion for this scene.
    """

    def __init__(
        self,
        loop: ControlLoop,
        candidates: Candidates,
        answer: Callable[[tuple[str, ...], Belief], str | None],
        *,
        settings: PolicySettings | None = None,
        method: str = "phase",
        pace: float = 1.0,
    ) -> None:
        if not candidates.by_label:
            raise ControlError("none of the library's motions can be made in this scene.")
        self.loop, self.candidates = loop, candidates
        self.asked = 0
        self.reason = "nothing was recognized"
        """Why the robot has not taken over."""
        self._answer, self._method, self._pace = answer, method, pace
        self._policy = TakeoverPolicy(settings)
        self._recognizer = OnlineRecognizer(candidates.tubes, method)
        self._scene_watch = SceneWatch(loop.world.scene)
        self._start = loop.world.tool(loop.name)
        self._belief: Belief | None = None
        self._signals = handles_objects(loop.world.task) and loop.world.has_gripper(loop.name)
        self._declined = self._is_new = False
        self._not_before, self._anew_at = 0.0, np.inf
        self._near: dict[str, float] = {}  # m, by label: the least distance from the tube since its take-over was due

    def begin_anew(self) -> None:
        """Another motion begins, where the tool is once the person has it: tubes from there, nothing known of it."""
        self._anew_at = self.loop.time + GRASPING
        self._policy.reset()
        self._belief, self._is_new, self._declined, self._not_before = None, True, False, 0.0
        self._near.clear()
        self.reason = "nothing was recognized"

    def attend(self) -> Takeover | None:
        """One control period; a plan where the robot takes over now."""
        if self.loop.is_sample_due():
            self._sample()
        belief = self._belief
        if belief is None or self._is_new:
            return None
        self.candidates.by_label[belief.label].lead(belief.phase[belief.label])
        return self._decide(belief) if self.loop.is_sample_due() else None

    def _renew_from_here(self) -> None:
        self._anew_at = np.inf
        self._start = self.loop.tool()
        self._scene_watch = SceneWatch(self.loop.world.scene)
        self.candidates.renew(self._scene_watch.scene, self._start)

    def _sample(self) -> None:
        """Renew the tubes where the scene asks for it, else hand the present sample to the recognizer."""
        if self.loop.time >= self._anew_at:
            self._renew_from_here()
        moved = self._scene_watch.update(
            self.loop.time, self.loop.injector.scene(self.loop.world.scene), self.loop.world.tool(self.loop.name)
        )
        if moved is not None:
            self.loop.log.event(self.loop.time, "scene", "an object was moved: the tubes are made anew")
            self.candidates.renew(moved, self._start)
        if self.candidates.work():
            self._go_on_with_new_tubes()
        if not self._is_new:
            self._recognize()

    def _go_on_with_new_tubes(self) -> None:
        tubes = self.candidates.tubes
        if self._is_new:
            self._recognizer, self._is_new = OnlineRecognizer(tubes, self._method), False
        else:
            self._recognizer.replace(tubes)

    def _recognize(self) -> None:
        world, name = self.loop.world, self.loop.name
        tool = self.loop.tool()
        widths = {} if self.candidates.substitute else {GRIPPER_WIDTH: world.gripper(name)}  # of what was taught
        sample = Sample(self.loop.time, tool.position, tool.quaternion, widths)
        discrete = {GRIPPER_CLOSED: int(world.is_gripper_closed(name))} if self._signals else None
        for seen in self.loop.injector.samples(sample):
            belief = self._recognizer.update(seen.time, seen.position, seen.quaternion, seen.continuous, discrete)
            self._belief = self.loop.injector.belief(belief)
            self.loop.log.belief(self.loop.time, self._belief.probability, self._belief.unknown)

    def _decide(self, belief: Belief) -> Takeover | None:
        decision = self._policy.update(belief)
        self.reason = decision.reason
        if decision.kind == "ask":
            self._ask(decision, belief)
        elif decision.kind == "decline":
            self._decline(decision.reason)
        elif decision.kind == "take_over" and self.loop.time >= self._not_before - 0.5 * self.loop.world.control_period:
            return self._take_over(decision, belief)
        return None

    def _ask(self, decision: Decision, belief: Belief) -> None:
        self.asked += 1
        reply = self._answer(decision.labels, belief)
        self.loop.log.event(self.loop.time, "ask", f"{decision.reason}; the answer is {reply!r}")
        self._policy.answer(reply)

    def _take_over(self, decision: Decision, belief: Belief) -> Takeover | None:
        candidate = self.candidates.by_label[decision.label]
        phase, pace = place_and_pace(candidate.tube, belief)
        candidate.lead(phase)
        if not candidate.is_ready(phase):
            self.reason = f"the path of {decision.label!r} is not ready yet"
            return None
        takeover = plan_takeover(self.loop, candidate, phase, pace * self._pace)
        if takeover.reason:
            self.reason, self._not_before = takeover.reason, self.loop.time + RETRY
            self._decline(takeover.reason)
            return None
        if phase < LATE_PHASE and self._strays(takeover):
            self.reason, self._not_before = f"the way onto {decision.label!r} would stray", self.loop.time + SOON
            return None
        self.loop.log.event(self.loop.time, "take_over", decision.reason)
        return takeover

    def _strays(self, takeover: Takeover) -> bool:
        """Whether the tool would be led away from the tube, or has fallen behind it since this was first asked.

        A hand that pauses is passed by the phase that is thought of it: the distance now is no measure then.
        """
        distance = takeover.distances(self.loop.arm)
        near = min(self._near.get(takeover.label, np.inf), float(distance[0]))
        self._near[takeover.label] = near
        return float(distance.max()) - near > STRAYS

    def _decline(self, reason: str) -> None:
        """Log why the robot does not take over, the first time."""
        if not self._declined:
            self.loop.log.event(self.loop.time, "decline", reason)
        self._declined = True


def place_and_pace(tube: FlowTube, belief: Belief) -> tuple[float, float]:
    """Phase of the motion that is taken over, and the person's pace beside the tube's."""
    phase = min(max(belief.phase[tube.label], 0.0), 1.0)
    left = float(tube.time[-1] - np.interp(phase, tube.phase, tube.time))
    pace = left / max(belief.time_to_completion[tube.label], 1e-3)
    return phase, float(np.clip(pace, *PACE_RANGE))
