"""Taking over: planned once, a jerk-limited transition onto the tube and the tube to its end.

What `execute` does from a standstill and `assist` in the middle of a person's motion; a `Pursuit` carries it out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pft_exec.control import Compliance, JointReference, RollingTrajectory, TakenUp
from pft_exec.execution.candidates import Candidate
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.geometry import Array
from pft_exec.handoff import JointState, Transition, plan_transition
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.model import Arm

REACH = (0.02, 0.1)
"""m, rad; a tube from which the arm's nearest path strays farther is beyond its reach."""
_LOOKS = 12  # at a transition, to see how far it strays
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
        away = [
            arm.forward(self.transition.at(time)[0]).position
            - arm.forward(self.trajectory.at(time).configuration).position
            for time in np.linspace(0.0, self.transition.duration, _LOOKS)
        ]
        distance: Array = np.linalg.norm(away, axis=1)
        return distance

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
        pass over what the motion begins with.
    """
    q, v = loop.sense()
    commanded = np.zeros(len(q)) if acceleration is None else acceleration
    path = candidate.path(phase)
    path.extend_until(candidate.tube_time(phase))
    trajectory = TakenUp(path, candidate.tube_time(phase), pace, starting)
    limits = replace(loop.arm.limits, velocity=SPEED_SHARE * loop.arm.limits.velocity)
    transition = plan_transition((q, v, commanded), lambda t: _state(trajectory.at(t)), limits)
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
