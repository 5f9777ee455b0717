"""The tracking controller: from measured state and reference to motor torques, once per control period."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pft_exec.control.avoidance import Avoidance, Nearness
from pft_exec.control.command import Command
from pft_exec.control.compliance import Compliance
from pft_exec.control.friction import friction_torque
from pft_exec.control.gravity_compensation import GravityCompensation, guiding_torque, stop_damping
from pft_exec.control.objectives import REGULARIZATION, Objective, tool_objective
from pft_exec.control.period_kernel import compose, conclude, draw_to
from pft_exec.control.quadratic_program import QuadraticProgram, Solution, softness, with_constraint
from pft_exec.control.reference import JointReference, Reference, holding
from pft_exec.control.secondary import room_for, secondary_acceleration
from pft_exec.control.sidestep import Ahead, Sidestep
from pft_exec.control.solvers import Solver, load_solver
from pft_exec.control.tool_target import ToolTarget, tool_target
from pft_exec.control.weight import WeightEstimate, weight_torque
from pft_exec.exceptions import ControlError
from pft_exec.geometry import Array
from pft_exec.model import Arm, ArmDynamics, Obstacle

POSTURE_STIFFNESS = 100.0
"""1/s^2; of the joints about their reference, in what the tool leaves open; critically damped."""
BLENDING_TIME = 0.075
"""s; friction feed-forward comes in and the damping of teaching goes out over this time."""
ACTIVE = 1e-9
"""A multiplier above this makes its row active."""
_Concluded = tuple[Array, NDArray[np.bool_], dict[str, float]]
"""Torque (n,), N m, active bounds and rows (2n,), and what each objective costs."""


class TrackingController:
    """Follow a reference with a tube's compliance.

    Parameters
    ----------
    arm : Arm
    control_period : float, s
        For which each command is held.
    solver : str or Solver
        "daqp", "osqp", any other that qpsolvers has installed, or one of the caller's own.
    self_collision : bool
        Whether links keep off the robot's body and off each other; obstacles are for `avoid`.
    weigh : bool
        Whether a weight that the model does not know is estimated and held; see `WeightEstimate`.

    Raises
    ------
    ControlError
        If the control period is not positive.
    UnknownMethodError
        If there is no such solver.
    """

    def __init__(
        self,
        arm: Arm,
        control_period: float = 0.001,
        solver: str | Solver = "daqp",
        self_collision: bool = False,
        weigh: bool = True,
    ) -> None:
        if not control_period > 0.0:
            raise ControlError(f"the control period must be positive, s; got {control_period}.")
        self.arm = arm
        self.control_period = control_period
        self._solver: Solver = load_solver(solver) if isinstance(solver, str) else solver
        limits = arm.limits
        self._box = np.stack([limits.torque, limits.lower, limits.upper, limits.velocity, limits.acceleration])
        self._avoidance = Avoidance(arm, self_collision) if self_collision else None
        self._self_collision = self_collision
        self._weight = WeightEstimate(arm) if weigh else None
        self._fallback = GravityCompensation(arm, stop_damping(arm), control_period)
        self._reference: Reference | None = None
        self._compliance: Compliance | None = None
        self._since = 0.0
        self._blend_since = 0.0
        self._before, self._carried_since = arm, -np.inf
        self._ahead: Ahead = holding(0.0 * limits.lower)
        self._has_room = False
        self._sidestep: Sidestep | None = None

    def follow(
        self,
        reference: Reference,
        compliance: Compliance,
        since: float,
        blend: bool = True,
        ahead: Ahead | None = None,
    ) -> None:
        """Follow another reference from a time on.

        Parameters
        ----------
        reference : Reference
            Its clock begins at `since`.
        compliance : Compliance
        since : float, s
        blend : bool
            Whether the arm floated until now: friction feed-forward then comes in, and what helped the hand
            goes out, over `BLENDING_TIME`. False goes on from tracking.
        ahead : callable or None
            From a time, s, to where the reference will be then, as far as it is known: for a reference whose clock is
            not the controller's. None asks the reference itself.
        """
        self._ahead = (lambda time: reference(time - since)) if ahead is None else ahead
        self._has_room = bool(compliance.deviation.any())
        self._reference, self._compliance, self._since = reference, compliance, since
        self._blend_since = since if blend else -np.inf
        if blend and self._weight is not None:
            self._weight.expect()

    @property
    def unknown_mass(self) -> float:
        """Mass, kg, that the tool carries besides the model's, as far as it is known."""
        return 0.0 if self._weight is None else self._weight.mass

    def avoid(self, obstacles: Sequence[Obstacle], time: float = 0.0) -> None:
        """Keep off these obstacles from now on, and off no others.

        Parameters
        ----------
        obstacles : sequence of Obstacle
            In the robot's base frame, as they are at `time`; each is taken to move on at its velocity. Cheap enough
            to be called every control period. What the arm must touch is left out.
        time : float, s
        """
        if self._avoidance is None:
            self._avoidance = Avoidance(self.arm, self._self_collision)
        self._avoidance.watch(obstacles, time)
        if self._sidestep is None:
            self._sidestep = Sidestep(self.arm, self._avoidance.moved)
        self._sidestep.watch(obstacles, time)

    def carry(self, arm: Arm, since: float = -np.inf) -> None:
        """Go on with another model of the same arm: a payload was grasped or released.

        Parameters
        ----------
        arm : Arm
            Such as `arm.with_payload(mass)`.
        since : float, s
            When; the change of the weight to hold comes in over `BLENDING_TIME` from then on. Without it, at once.

        Raises
        ------
        ConfigurationError
            If the model has other joints.
        """
        arm.check_configuration(self.arm.limits.lower)
        self._before, self.arm, self._carried_since = self.arm, arm, since
        self._fallback.carry(arm)
        if self._weight is not None:
            self._weight.restart(arm)

    def update(self, time: float, q: Array, v: Array) -> Command:
        """Command for one control period; whatever is measured and whatever the solver does, a command comes back.

        Parameters
        ----------
        time : float, s
        q, v : (n,), rad, rad/s
            Measured.
        """
        if self._reference is None or self._compliance is None:
            return self._stop(time, q, v, "nothing to follow")
        if not math.isfinite(q.dot(v)):  # of any number that is not finite, neither is the product
            return self._stop(time, q, v, "measured state not finite")
        reference = self._reference(time - self._since)
        dynamics = self.arm.dynamics(q, v)
        tool = tool_target(self.arm, reference)
        known = self._known_load(time, reference, dynamics, q, v)
        load = known if self._weight is None else known + weight_torque(self._weight.update(time, v), dynamics.jacobian)
        error = tool.error(dynamics)
        aside = secondary_acceleration(self.arm.limits, q, dynamics.jacobian)
        aim, missed = self._stepped_aside(time, reference.phase, tool, error, dynamics, self._compliance)
        tracking = self._tracking(self._compliance, reference.phase, aim, missed, dynamics, aside)
        posture = posture_acceleration(reference, q, v, aside)
        near = None if self._avoidance is None else self._avoidance.near(self.arm, q, v, time)
        program = self._program(tracking, posture, dynamics, load, q, v, near)
        begin = perf_counter()
        solution = self._solver.solve(program)
        solve_time = perf_counter() - begin
        if not (solution.found and math.isfinite(solution.x.dot(solution.x))):
            found = "an answer that is not a number, called " if solution.found else ""
            return self._stop(time, q, v, f"no solution: {found}{solution.status}")
        concluded = self._conclude(solution, tracking, posture, dynamics, load)
        told = {"solve_time": solve_time} if near is None else {"solve_time": solve_time, **_closeness(near, solution)}
        command = _command(concluded, solution, reference, tool, error, told)
        self._remember(time, (q, v), dynamics, known, command)
        return command

    def _stepped_aside(
        self,
        time: float,
        phase: float,
        tool: ToolTarget,
        error: Array,
        dynamics: ArmDynamics,
        compliance: Compliance,
    ) -> tuple[ToolTarget, Array]:
        """The tool target beside what is in the way, and the error (12,) from it."""
        if self._sidestep is None or not self._has_room:
            return tool, error
        shift = self._sidestep.update(time, self.control_period, phase, error[:3], compliance, self._ahead)
        if shift is None:
            return tool, error
        aim = tool.shifted(shift)
        return aim, aim.error(dynamics)

    def _known_load(self, time: float, reference: JointReference, dynamics: ArmDynamics, q: Array, v: Array) -> Array:
        """What the motors must hold besides inertia, as far as the model knows, (n,), N m."""
        load: Array = dynamics.bias - self.arm.counterbalance(q)
        load += self._blended(time, reference.velocity, v, dynamics)
        is_carried = time - self._carried_since >= BLENDING_TIME
        return load if is_carried else load + self._weight_to_come(time, q)

    def _remember(
        self, time: float, state: tuple[Array, Array], dynamics: ArmDynamics, known: Array, command: Command
    ) -> None:
        """Keep what the estimate of the weight needs; not while a change of payload comes in."""
        if self._weight is None:
            return
        if time - self._carried_since < BLENDING_TIME:
            self._weight.forget()
            return
        if time - self._blend_since < BLENDING_TIME:  # friction acts in full, whatever of it is fed forward
            friction = friction_torque(self.arm.friction, command.velocity)
            known = dynamics.bias - self.arm.counterbalance(state[0]) + friction
        self._weight.remember(time, state[1], dynamics, known - command.torque)

    def _program(
        self,
        tracking: Objective,
        posture: Array,
        dynamics: ArmDynamics,
        load: Array,
        q: Array,
        v: Array,
        near: Nearness | None,
    ) -> QuadraticProgram:
        """Objectives within the limits; what keeps the arm off obstacles stands beside the torque's rows."""
        aims, period = (tracking.H, tracking.c), self.control_period
        H, c, lower, upper = compose(aims, posture, REGULARIZATION, load, self._box, period, q, v)
        program = QuadraticProgram(H, c, dynamics.mass_matrix, lower, upper, softness(len(q), ((len(q), False),)))
        return program if near is None else with_constraint(program, near.constraint)

    def _conclude(
        self, solution: Solution, tracking: Objective, posture: Array, dynamics: ArmDynamics, load: Array
    ) -> _Concluded:
        """What a solution asks of the motors, and what it costs."""
        aims, limit = (tracking.H, tracking.c), self.arm.limits.torque
        x, mass_matrix = solution.x, dynamics.mass_matrix
        torque, active, following, keeping = conclude(
            x, solution.multipliers, aims, posture, REGULARIZATION, mass_matrix, load, limit, ACTIVE
        )
        return torque, active, {"tracking": following + tracking.constant, "posture": keeping}

    def _weight_to_come(self, time: float, q: Array) -> Array:
        """Part (n,), N m, of a change of payload that is not yet held."""
        x = (time - self._carried_since) / BLENDING_TIME
        rest: Array = (1.0 - _smooth_step(min(x, 1.0))) * (self._before.gravity(q) - self.arm.gravity(q))
        return rest

    def _blended(self, time: float, reference_velocity: Array, v: Array, dynamics: ArmDynamics) -> Array:
        """Friction feed-forward coming in and what helped the hand going out, (n,), N m."""
        forward = friction_torque(self.arm.friction, reference_velocity)
        x = (time - self._blend_since) / BLENDING_TIME
        if x >= 1.0:
            return forward
        share = _smooth_step(x)
        guiding = guiding_torque(self.arm.friction, v, dynamics, self.control_period)
        blended: Array = share * forward + (1.0 - share) * guiding
        return blended

    def _tracking(
        self,
        compliance: Compliance,
        phase: float,
        tool: ToolTarget,
        error: Array,
        dynamics: ArmDynamics,
        aside: Array,
    ) -> Objective:
        """Follow the tool target with a gain and a weight; step aside (n,), rad/s^2, where the weight leaves room."""
        if not aside.any():
            return tool.objective(compliance, phase, error, dynamics)
        gain, weight = compliance.at(phase)
        weight, wanted = tool.weight_in_base(weight), tool.corrected(gain, error)
        wanted = wanted + room_for(dynamics.jacobian @ aside, weight)
        return tool_objective(dynamics.jacobian, dynamics.jacobian_drift, wanted, weight)

    def _stop(self, time: float, q: Array, v: Array, status: str) -> Command:
        if self._weight is not None:
            self._weight.forget()
        return replace(self._fallback.update(time, q, v, status), fallback=True)


def _command(
    concluded: _Concluded,
    solution: Solution,
    reference: JointReference,
    tool: ToolTarget,
    error: Array,
    told: Mapping[str, Any],
) -> Command:
    torque, active, costs = concluded
    size = len(torque)
    return Command(
        torque=torque,
        acceleration=solution.x,
        configuration=reference.configuration,
        velocity=reference.velocity,
        reference_acceleration=reference.acceleration,
        position=tool.position,
        quaternion=tool.quaternion,
        phase=reference.phase,
        error=error[:6],
        torque_active=active[size:],
        bound_active=active[:size],
        status=solution.status,
        fallback=False,
        iterations=solution.iterations,
        costs=costs,
        **told,
    )


def _closeness(near: Nearness, solution: Solution) -> dict[str, Any]:
    """What a command says of the pairs that are near."""
    active = np.abs(solution.multipliers[-len(near.distance) :]) > ACTIVE
    return {"distance": float(near.distance.min()), "apart_active": near.names(active)}


def posture_acceleration(reference: JointReference, q: Array, v: Array, aside: Array) -> Array:
    """Joint accelerations (n,), rad/s^2, that draw the joints to their reference, critically damped, and aside (n,)."""
    state = reference.configuration, reference.velocity, reference.acceleration
    acceleration: Array = draw_to(*state, q, v, aside, POSTURE_STIFFNESS)
    return acceleration


def _smooth_step(x: float) -> float:
    """From 0 at x <= 0 to 1 at x = 1, flat at both."""
    x = max(x, 0.0)
    return x**2 * (3.0 - 2.0 * x)
