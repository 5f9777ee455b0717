"""Whole control periods as the control loop runs them: sensing, supervisors, force observer, controller; in the world.

The same run is bit for bit the same in the simulated world, so each period's time is the least of some runs: what the
computer does besides is not the loop's. What is timed is what a log calls the tick: from the sensed state to the
command, the look at the surroundings included where one is due.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np

from pft_exec.execution.surroundings import Surroundings
from pft_exec.geometry import Array
from pft_exec.model import solve_inverse_kinematics

if TYPE_CHECKING:
    from pft_exec.execution import ExecutionLog
    from pft_exec.learning import FlowTube
    from pft_exec.model import Arm, Obstacle
    from pft_exec.simulation import World

ROUNDS = 3
PERIOD = 0.002
"""s; control period."""
WARM = 20
"""Periods at the beginning that are not counted."""
_EVERY = 50  # periods between those whose near pairs are counted


class _StandingAround(Surroundings):
    """Obstacles that are seen whenever it is time to look, and are in nobody's way."""

    def __init__(self, world: World, arm: str, obstacles: Sequence[Obstacle]) -> None:
        super().__init__(world, arm, (), other_arms=False)
        self._obstacles = tuple(obstacles)

    def look(self) -> tuple[Obstacle, ...]:
        """All of them, in the robot's base frame."""
        super().look()
        return self._obstacles


def period_row(arm: Arm, tube: FlowTube, obstacles: Sequence[Obstacle]) -> dict[str, Any]:
    """Times of the periods along a tube beside some obstacles, and how many pairs were near.

    Parameters
    ----------
    arm : Arm
        The PR2's right one.
    tube : FlowTube
        Base frame.
    obstacles : sequence of Obstacle
        Base frame. With any, the arm keeps off the robot's own parts too, as with `execute(avoid=...)`.
    """
    start = solve_inverse_kinematics(arm, tube.start, arm.configuration("work")).configuration
    logs = [_run(tube, start, obstacles) for _ in range(ROUNDS)]
    least: Array = 1e6 * reduce(np.minimum, [log.tick for log in logs])[WARM:]
    pairs = [pairs_near(arm, obstacles, q) for q in logs[0].configuration[::_EVERY]]
    return {
        "obstacles": len(obstacles),
        "pairs near": float(np.median(pairs)),
        "median us": float(np.median(least)),
        "p99 us": float(np.percentile(least, 99)),
    }


def _run(tube: FlowTube, start: Array, obstacles: Sequence[Obstacle]) -> ExecutionLog:
    """One run along the tube from a configuration (n,), rad, supervised and felt as every run is."""
    from pft_exec.execution.autonomous import SOFTNESS, STARTING
    from pft_exec.execution.candidates import Candidate
    from pft_exec.execution.control_loop import ControlLoop
    from pft_exec.execution.safety.force_watch import ForceWatch
    from pft_exec.execution.safety.watch import pursue
    from pft_exec.execution.takeover import plan_takeover
    from pft_exec.execution.timeliness import undisturbed, warm_up
    from pft_exec.simulation import World

    with World("pr2", "tabletop", control_period=PERIOD) as world, undisturbed():
        world.place("right", start)
        loop = ControlLoop(world, "right")
        if obstacles:
            loop.surroundings = _StandingAround(world, loop.name, obstacles)
        warm_up(loop)
        takeover = plan_takeover(loop, Candidate(loop, tube, SOFTNESS), 0.0, starting=STARTING)
        outcome = pursue(loop, takeover, ForceWatch(loop), solver="daqp", floating=False)
        return loop.log.finish(outcome.ending == "finished", outcome.reason)


def pairs_near(arm: Arm, obstacles: Sequence[Obstacle], q: Array, self_collision: bool = True) -> int:
    """How many pairs of bodies are within 25 cm, 12 of the robot's own, at a configuration (n,), rad.

    Most of them need no row yet: of joints that could do anything, every pair needs one.
    """
    from pft_exec.control import Avoidance

    if not obstacles:
        return 0
    able = arm.with_payload(0.0)
    able.limits = replace(arm.limits, acceleration=np.full(len(q), 1e9))
    avoidance = Avoidance(able, self_collision)
    avoidance.watch(obstacles, 0.0)
    near = avoidance.near(able, q, np.zeros_like(q), 0.0)
    return 0 if near is None else len(near.distance)
