"""Taking over: planned once, a jerk-limited transition onto the tube and the tube to its end.

What `execute` does from a standstill and `assist` in the middle of a person's motion; a `Pursuit` carries it out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pft_exec.control import Compliance, JointReference, compute_compliance, plan_joint_trajectory
from pft_exec.control.joint_trajectory import JointTrajectory
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.geometry import Array
from pft_exec.handoff import JointState, Transition, plan_transition
from pft_exec.learning.flow_tube import FlowTube

REACH = (0.02, 0.1)
"""m, rad; a tube from which the arm's nearest path strays farther is beyond its reach."""


@dataclass(frozen=True, eq=False)
class Takeover:
    """A plan to finish a motion: where the joints go, and when the transition meets them.

    Parameters
    ----------
    trajectory : JointTrajectory
        Image of the tube in joint space, from the phase of the take-over on.
    transition : Transition
    label : str
    reason : str
        Why it cannot be done; empty where it can.
    """

    trajectory: JointTrajectory
    transition: Transition
    label: str
    reason: str

    @property
    def duration(self) -> float:
        """Until the tube's end is reached, s."""
        return max(self.trajectory.duration, self.transition.duration)

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


def plan_takeover(loop: ControlLoop, tube: FlowTube, phase: float, pace: float, acceleration: Array) -> Takeover:
    """Plan to finish a tube from where the arm is now.

    Parameters
    ----------
    loop : ControlLoop
    tube : FlowTube
        World frame.
    phase : float
        Where along the tube the motion is now.
    pace : float
        Speed relative to the tube's own.
    acceleration : (n,), rad/s^2
        As last commanded.
    """
    q, v = loop.sense()
    in_base = tube.transformed(loop.world.base.inverse())
    trajectory = plan_joint_trajectory(loop.arm, in_base, q, phase, pace)
    transition = plan_transition((q, v, acceleration), lambda t: _state(trajectory.at(t)), loop.arm.limits)
    reason = "" if transition.found else transition.reason
    if trajectory.position_error > REACH[0] or trajectory.rotation_error > REACH[1]:
        reason = (
            f"the tube of {tube.label!r} is beyond the reach of arm {loop.name!r}: the arm comes no nearer than "
            f"{1e3 * trajectory.position_error:.0f} mm and {trajectory.rotation_error:.2f} rad"
        )
    return Takeover(trajectory, transition, tube.label, reason)


def tube_compliance(loop: ControlLoop, tube: FlowTube, softness: float) -> Compliance:
    """Gains and weights, base frame, of a tube in the world frame; computed once per tube.

    Parameters
    ----------
    loop : ControlLoop
    tube : FlowTube
    softness : float, s^4/m^2
        See `pft_exec.control.compute_compliance`.
    """
    return compute_compliance(tube.transformed(loop.world.base.inverse()), softness)
