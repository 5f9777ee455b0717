"""Taking over: planned once, a jerk-limited transition onto the tube and the tube to its end.

What `execute` does from a standstill and `assist` in the middle of a person's motion; a `Pursuit` carries it out.

A transition that chases a quick tube may cut off what the tube does meanwhile, such as the far end of a swing, for the
tube itself needs most of what the joints can accelerate. It matters more that the tool comes through all the places of
the tube than when. So where the tool's way to the join and the tube's are far apart, whatever the time at which either
is where, the tube's clock begins slower and comes up to its pace as the transition goes on.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from pft_exec.control import Compliance, JointReference, RollingTrajectory, TakenUp
from pft_exec.execution.candidates import BEHIND, Candidate
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.geometry import Array
from pft_exec.handoff import JointState, Transition, plan_transition
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.model import Arm

REACH = (0.02, 0.1)
"""m, rad; a tube from which the arm's nearest path strays farther is beyond its reach."""
_LOOKS = 12  # at a transition, to see how far it strays
_POINTS = 32  # of either way to the join
APART = 0.01
"""m; by how much more than the tool is off the tube now its way to the join may be apart from the tube's."""
ONSETS = (0.75, 0.5)
"""Shares of the pace from which the tube's clock comes up, tried where the ways are too far apart at full pace."""
EASING = 1.0
"""s in which the clock then comes up. Measured in four take-overs of shakes: the ways are apart by 28 to 94 mm at
full pace, by 8 to 20 with the best onset over 0.6 s, by less than 5 with one of these over 1 s; and joins come sooner.
"""
SPEED_SHARE = 0.95
"""Share of each joint's velocity limit that a transition may use; the rest is for the feedback of an arm that is not as
modeled. More than a tube may ask for itself (`joint_trajectory.LIMIT_SHARE`), which it has to meet."""


@dataclass(frozen=True, eq=False)
class Takeover:
    """A plan to finish a motion: where the joints go, and when the transition meets them.

    Parameters
    ----------
    trajectory : TakenUp
        Image of the tube in joint space, from the phase of the take-over on.
    transition : Transition
    candidate : Candidate
        The motion.
    phase : float
        Where the tube is taken up.
    reason : str
        Why it cannot be done; empty where it can.
    """

    trajectory: TakenUp
    transition: Transition
    candidate: Candidate
    phase: float
    reason: str

    @property
    def tube(self) -> FlowTube:
        """Of the motion, world frame."""
        return self.candidate.tube

    @property
    def compliance(self) -> Compliance:
        """Of the tube, base frame."""
        return self.candidate.compliance

    @property
    def label(self) -> str:
        """Of the motion."""
        return self.tube.label

    @property
    def duration(self) -> float:
        """Until the tube's end is reached, s."""
        return max(self.trajectory.duration, self.transition.duration)

    def distances(self, arm: Arm) -> Array:
        """How far the tool will be, m, from where the tube has it, at instants (`_LOOKS`,) from now to the join."""
        times = np.linspace(0.0, self.transition.duration, _LOOKS)
        tool = _places(arm, [self.transition.at(time)[0] for time in times])
        tube = _places(arm, [self.trajectory.at(time).configuration for time in times])
        distance: Array = np.linalg.norm(tool - tube, axis=1)
        return distance

    def detour(self, arm: Arm) -> float:
        """How far the tool's way to the join and the tube's are apart, m, beyond what the tool is off the tube now.

        The Fréchet distance of two curves, on points of them: what the transition passes over counts, where it goes
        besides, and what it goes twice, but not when. The tube's way begins where it was nearest the tool.
        """
        times = np.linspace(0.0, self.transition.duration, _POINTS)
        tool = _places(arm, [self.transition.at(time)[0] for time in times])
        tube = _places(arm, [self.trajectory.at(time).configuration for time in times])
        lately = self._tube_before(arm)
        nearest = int(np.argmin(np.linalg.norm(lately - tool[0], axis=1)))
        apart = np.linalg.norm(tool[:, None] - np.concatenate([lately[nearest:], tube]), axis=2)
        return frechet_distance(apart) - float(apart[0, 0])

    def _tube_before(self, arm: Arm) -> Array:
        """Where the tube had the tool lately, (`_LOOKS`, 3), m: one that has fallen behind is not off it."""
        path, now = self.trajectory.path, self.trajectory.time_law.begin
        lately = np.linspace(max(now - BEHIND, path.begin), now, _LOOKS)
        return _places(arm, [path.reference(theta, 0.0, 0.0).configuration for theta in lately])

    def jumps(self) -> dict[str, float]:
        """Largest jumps of the commanded joints at both seams: position (rad), velocity, acceleration.

        Each is the difference between what is commanded just before and just after the same instant. Before the
        first seam the arm floats: the command is the measured motion, without acceleration.
        """
        arrival = self.trajectory.at(self.transition.duration)
        seams = {"1": (self.transition.start, self.transition.at(0.0)), "2": (self.transition.end, _state(arrival))}
        if self.transition.duration > 0.0:
            seams["2"] = (self.transition.at(self.transition.duration * (1.0 - 1e-12)), _state(arrival))
        names = ("position", "velocity", "acceleration")
        return {
            f"seam_{seam}_{name}": float(np.max(np.abs(after[k] - before[k])))
            for seam, (before, after) in seams.items()
            for k, name in enumerate(names)
        }


@njit(cache=True)
def frechet_distance(apart: Array) -> float:
    """Discrete Fréchet distance of two sequences of points whose distances (K, M) are given, in their unit.

    The least that the longest leash can be when both are walked from end to end and nobody turns back.

    Notes
    -----
    [Eiter1994]_, the recursion over pairs of points.
    """
    longest = apart.copy()
    for i in range(len(apart)):
        for j in range(apart.shape[1]):
            before = math.inf if i + j > 0 else 0.0
            if i > 0:
                before = min(before, longest[i - 1, j])
            if j > 0:
                before = min(before, longest[i, j - 1])
            if i > 0 and j > 0:
                before = min(before, longest[i - 1, j - 1])
            longest[i, j] = max(apart[i, j], before)
    return float(longest[-1, -1])


def _places(arm: Arm, configurations: Sequence[Array]) -> Array:
    """Where the tool is, (M, 3), m, in M configurations (n,)."""
    return np.array([arm.kinematics(q)[0] for q in configurations])


def _state(reference: JointReference) -> JointState:
    return reference.configuration, reference.velocity, reference.acceleration


def plan_takeover(
    loop: ControlLoop,
    candidate: Candidate,
    phase: float,
    pace: float = 1.0,
    acceleration: Array | None = None,
    starting: float = 0.0,
) -> Takeover:
    """Plan to finish a candidate's motion from where the arm is now.

    Parameters
    ----------
    loop : ControlLoop
    candidate : Candidate
        What is known of its joint path must reach as far as a transition takes; else the rest is computed now.
    phase : float
        Where along the tube the motion is now.
    pace : float
        Speed relative to the tube's own.
    acceleration : (n,), rad/s^2, or None
        As last commanded; None: the arm floated.
    starting : float, s
        From a standstill, the time in which the tube comes up to its speed: a transition that chased it instead would
        pass over what the motion begins with. 0: the tube is met in motion.
    """
    q, v = loop.sense()
    state = q, v, np.zeros(len(q)) if acceleration is None else acceleration
    candidate.path(phase).extend_until(candidate.tube_time(phase))
    takeover = _planned(loop, candidate, phase, state, (pace, starting, 0.0))
    if starting > 0.0 or takeover.reason or takeover.detour(loop.arm) <= APART:
        return takeover
    slower = [_planned(loop, candidate, phase, state, (pace, EASING, onset)) for onset in ONSETS]
    possible = [takeover, *(plan for plan in slower if not plan.reason)]
    return min(possible, key=lambda plan: plan.detour(loop.arm))


def _planned(
    loop: ControlLoop, candidate: Candidate, phase: float, state: JointState, clock: tuple[float, float, float]
) -> Takeover:
    """The plan from a state, with a clock of the tube: its pace, the time it comes up in, s, and its onset."""
    path = candidate.path(phase)
    trajectory = TakenUp(path, candidate.tube_time(phase), *clock)
    limits = replace(loop.arm.limits, velocity=SPEED_SHARE * loop.arm.limits.velocity)

    def deviation(time: float, configuration: Array) -> tuple[Array, Array]:
        return candidate.metric.deviation(loop.arm, trajectory.at(time), configuration)

    transition = plan_transition(state, lambda t: _state(trajectory.at(t)), limits, deviation=deviation)
    reason = beyond_reach(path, candidate.label, loop.name) or ("" if transition.found else transition.reason)
    return Takeover(trajectory, transition, candidate, phase, reason)


def beyond_reach(path: RollingTrajectory, label: str, arm: str) -> str:
    """Why a path cannot be followed, as far as it is known; empty where it can."""
    if path.position_error <= REACH[0] and path.rotation_error <= REACH[1]:
        return ""
    return (
        f"the tube of {label!r} is beyond the reach of arm {arm!r}: the arm comes no nearer than "
        f"{1e3 * path.position_error:.0f} mm and {path.rotation_error:.2f} rad"
    )
