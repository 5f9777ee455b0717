r"""From a tube to torques: the executor, once per control period.

A tube says where the tool should be and how much that matters. Three things are made of it once: the joint trajectory
(`plan_joint_trajectory`), the gains and weights (`compute_compliance`), and, at a take-over, a transition that leads
onto it (`pft_exec.handoff`). Then, each control period, the `TrackingController` solves

.. math::
    \min_{\ddot q}\; \tfrac12 \lVert J \ddot q + \dot J \dot q - \ddot x_r + K_p e + K_d \dot e \rVert^2_W
        + \tfrac{\lambda}{2} \lVert \ddot q - \ddot q_p \rVert^2
    \quad\text{s.t.}\quad
    \underline a(q, \dot q) \le \ddot q \le \overline a(q, \dot q),\quad
    -\tau_m \le M \ddot q + h \le \tau_m

with tool reference :math:`x_r`, gains K and weight W from the tube's covariance (`compliance`), posture acceleration
:math:`\ddot q_p` (`objectives`), braking-distance bounds that keep position, velocity and acceleration limits and give
way to torque (`limits`), and in h gravity, Coriolis, counterbalance and friction feed-forward. The motor torque is
:math:`M \ddot q + h`. What cannot be solved falls back to damped gravity compensation, which is also how the arm floats
while it is taught (`GravityCompensation`). Nothing raises inside a control period.

Obstacles are rows on the distance (`avoidance`). On which side of them to pass is chosen ahead of the encounter, where
the tube is wide, and shifts :math:`x_r` (`sidestep`).

Further objectives add to the sum, further constraints to the rows; a solver is a name (`solvers`).
"""

from pft_exec.control.avoidance import Avoidance
from pft_exec.control.command import Command
from pft_exec.control.compliance import Compliance, compute_compliance, constant_compliance, operational_stiffness
from pft_exec.control.gravity_compensation import GravityCompensation, stop_damping
from pft_exec.control.joint_trajectory import JointTrajectory, plan_joint_trajectory
from pft_exec.control.limits import Constraint, acceleration_bounds, torque_constraint
from pft_exec.control.objectives import Objective, posture_objective, tool_objective
from pft_exec.control.payload import PayloadEstimate, estimate_payload
from pft_exec.control.quadratic_program import QuadraticProgram, Solution, assemble
from pft_exec.control.reference import JointReference, Reference, holding, joined
from pft_exec.control.rolling_trajectory import RollingTrajectory, SmoothTube, TakenUp, smooth_tube
from pft_exec.control.solvers import Solver, load_solver
from pft_exec.control.tracking import TrackingController
from pft_exec.control.tube_metric import TubeMetric

__all__ = [
    "Avoidance",
    "Command",
    "Compliance",
    "Constraint",
    "GravityCompensation",
    "JointReference",
    "JointTrajectory",
    "Objective",
    "PayloadEstimate",
    "QuadraticProgram",
    "Reference",
    "RollingTrajectory",
    "SmoothTube",
    "Solution",
    "Solver",
    "TakenUp",
    "TrackingController",
    "TubeMetric",
    "acceleration_bounds",
    "assemble",
    "compute_compliance",
    "constant_compliance",
    "estimate_payload",
    "holding",
    "joined",
    "load_solver",
    "operational_stiffness",
    "plan_joint_trajectory",
    "posture_objective",
    "stop_damping",
    "smooth_tube",
    "tool_objective",
    "torque_constraint",
]
