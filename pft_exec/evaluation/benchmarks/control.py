"""Control: how long the quadratic program, the controller and a whole period take, and how well the tool tracks.

Times are the least of some rounds over the same programs and states, each on its own: what the computer does besides
is not the controller's. Median and 99th percentile are over programs and states.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from pft_exec.evaluation.benchmarks.periods import pairs_near, period_row
from pft_exec.evaluation.benchmarks.stopwatch import Tables
from pft_exec.evaluation.protocol import Progress
from pft_exec.geometry import Array, Pose

if TYPE_CHECKING:
    from pft_exec.control import JointTrajectory, QuadraticProgram, Solution
    from pft_exec.learning import FlowTube
    from pft_exec.model import Arm, Obstacle

SOLVERS = ("daqp", "osqp", "quadprog")
ROUNDS = 5
TIGHT = 0.2
"""Share of the torque limits in the run whose programs have limits at work."""
SHARE = 0.5
"""Share of the tube's time that is recorded."""
PUSH = 20.0
"""N; of the push in the recorded run."""
BALLS = 6
"""Around the hand and the forearm: 20 pairs and more are near."""
FRICTION = 0.3
"""N m; in every joint, of the tracking rows."""
WARM = 10
"""Programs and states at the beginning that are not counted."""


def time_control(seed: int, progress: Progress) -> Tables:
    """Solvers on one run's programs, control periods without and with obstacles, and tracking."""
    from pft_exec.evaluation.benchmarks.plant import arch_trajectory, arch_tube
    from pft_exec.model import load_robot

    arm = load_robot("pr2").arm("right")
    tube = arch_tube(arm)
    trajectory = arch_trajectory(arm, tube)
    progress("recording a run", 0.0)
    free, _ = _recorded(arm, tube, trajectory, 1.0, seed)
    tight, states = _recorded(arm, tube, trajectory, TIGHT, seed)
    tables: Tables = {}
    for title, programs in (("limits not reached", free), (f"torque limits at {TIGHT:.0%}", tight)):
        progress(f"solving, {title}", 0.2)
        tables[f"one quadratic program, {title}"] = [_solver_row(name, programs) for name in SOLVERS]
    progress("control periods", 0.5)
    tables["one control period, the controller alone"] = [
        _tick_row(arm, tube, trajectory, states, balls) for balls in (0, BALLS)
    ]
    progress("control periods in the world", 0.6)
    tables["one control period, all in: sensing, supervisors, force observer and controller"] = [
        period_row(arm, tube, _balls(tube, balls)) for balls in (0, BALLS)
    ]
    progress("tracking", 0.7)
    tables["tracking the arch of 5 s"] = [_tracking_row(arm, tube, *case) for case in _CASES]
    return tables


_CASES = (
    ("perfect model", 0.0, 1.0),
    ("friction 0.3 N m, model 20 % low", FRICTION, 1.25),
    ("same, model 25 % high", FRICTION, 0.8),
)


class _Recording:
    """A solver that keeps what it was asked."""

    name = "recording"

    def __init__(self) -> None:
        from pft_exec.control import load_solver

        self._solver = load_solver("daqp")
        self.programs: list[QuadraticProgram] = []

    def solve(self, program: QuadraticProgram) -> Solution:
        self.programs.append(program)
        return self._solver.solve(program)


def _recorded(
    arm: Arm, tube: FlowTube, trajectory: JointTrajectory, share: float, seed: int
) -> tuple[list[QuadraticProgram], list[tuple[float, Array, Array]]]:
    """Programs, and times and states, of a run with a push, at a share of the torque limits."""
    from pft_exec.control import TrackingController, compute_compliance
    from pft_exec.evaluation.benchmarks.plant import PERIOD, Mismatch, Plant, run

    weaker = arm.with_payload(0.0)
    weaker.limits = replace(arm.limits, torque=share * arm.limits.torque)
    solver = _Recording()
    controller = TrackingController(weaker, PERIOD, solver)
    controller.follow(trajectory.at, compute_compliance(tube), 0.0, blend=False)
    plant = Plant(arm, trajectory.at(0.0).configuration, Mismatch(friction=1.25), seed)
    states: list[tuple[float, Array, Array]] = []
    push = np.array([0.0, PUSH, 0.0])
    run(
        controller,
        plant,
        SHARE * trajectory.duration,
        lambda t: push * float(0.5 <= t < 0.8),
        before=lambda t: states.append((t, plant.q.copy(), plant.v.copy())),
    )
    return solver.programs, states


def _solver_row(name: str, programs: Sequence[QuadraticProgram]) -> dict[str, Any]:
    from pft_exec.control import load_solver

    oracle = load_solver("daqp")
    least = np.full(len(programs), np.inf)
    for _ in range(ROUNDS):
        solver = load_solver(name)
        for k, program in enumerate(programs):
            begin = perf_counter()
            solver.solve(program)
            least[k] = min(least[k], perf_counter() - begin)
    solver = load_solver(name)
    found = [(program, solver.solve(program), oracle.solve(program)) for program in programs]
    return {
        "solver": name,
        **_times(least),
        "solved": all(solution.found for _, solution, _ in found),
        "torque error N m": max(float(np.abs(p.G @ (s.x - exact.x)).max()) for p, s, exact in found),
        "limits at work": float(np.mean([(np.abs(exact.multipliers) > 1e-9).any() for _, _, exact in found])),
    }


def _times(seconds: Array) -> dict[str, float]:
    counted = 1e6 * seconds[WARM:]
    return {"median us": float(np.median(counted)), "p99 us": float(np.percentile(counted, 99))}


def _tick_row(
    arm: Arm, tube: FlowTube, trajectory: JointTrajectory, states: Sequence[tuple[float, Array, Array]], balls: int
) -> dict[str, Any]:
    from pft_exec.control import TrackingController, compute_compliance
    from pft_exec.evaluation.benchmarks.plant import PERIOD

    compliance = compute_compliance(tube)
    least = np.full(len(states), np.inf)
    for _ in range(ROUNDS):
        controller = TrackingController(arm, PERIOD)
        controller.follow(trajectory.at, compliance, 0.0, blend=False)
        controller.avoid(_balls(tube, balls))
        for k, (time, q, v) in enumerate(states):
            begin = perf_counter()
            controller.update(time, q, v)
            least[k] = min(least[k], perf_counter() - begin)
    near = [pairs_near(arm, _balls(tube, balls), q, self_collision=False) for _, q, _ in states[::50]]
    return {"obstacles": balls, "pairs near": float(np.median(near)), **_times(least)}


def _balls(tube: FlowTube, count: int) -> list[Obstacle]:
    """Balls in a ring about the middle of the tube, near the hand and the forearm but out of the way."""
    from pft_exec.model import Obstacle, Sphere

    angles = 2.0 * np.pi * np.arange(count) / max(count, 1)
    ring = 0.22 * np.stack([np.cos(angles), 0.0 * angles, np.sin(angles)], axis=1) - np.array([0.0, 0.1, 0.0])
    middle = tube.position[len(tube) // 2]
    return [Obstacle(f"ball {k}", Sphere(0.03), Pose(middle + place)) for k, place in enumerate(ring)]


def _tracking_row(arm: Arm, tube: FlowTube, name: str, coulomb: float, factor: float) -> dict[str, Any]:
    from pft_exec.control import TrackingController, compute_compliance
    from pft_exec.evaluation.benchmarks.plant import PERIOD, Mismatch, Plant, arch_trajectory, run, with_friction

    model = with_friction(arm, coulomb)
    trajectory = arch_trajectory(model, tube)
    row: dict[str, Any] = {"case": name}
    for solver in ("daqp", "osqp"):
        controller = TrackingController(model, PERIOD, solver)
        controller.follow(trajectory.at, compute_compliance(tube), 0.0, blend=False)
        plant = Plant(model, trajectory.at(0.0).configuration, Mismatch(friction=factor))
        done = run(controller, plant, trajectory.duration)
        row[f"{solver} mm"] = 1e3 * _rms(done.error[:, :3])
        row[f"{solver} mrad"] = 1e3 * _rms(done.error[:, 3:])
    return row


def _rms(error: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(error**2, axis=1))))
