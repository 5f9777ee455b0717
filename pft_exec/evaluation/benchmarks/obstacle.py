"""Obstacle: what the arm keeps of its distance, and who gives way, around a ball on the tube, at rest and moving."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pft_exec.evaluation.benchmarks.stopwatch import Tables
from pft_exec.evaluation.protocol import Progress
from pft_exec.geometry import Array, Pose

if TYPE_CHECKING:
    from pft_exec.control import Compliance, TrackingController
    from pft_exec.evaluation.benchmarks.plant import Run
    from pft_exec.model import Arm, Obstacle

RADIUS = 0.04
"""m; of the ball."""
BESIDE = 0.01
"""m; how far beside the middle of the tube it is when the tool should pass there."""
SPEED = 0.1
"""m/s; of a ball that crosses the tube, up or down, so that it leaves the tube's end free."""
SEEN_EVERY = 0.02
"""s; how often a moving ball is looked at."""
HOLD = 0.8
"""s of rest after the motion."""


def measure_obstacle(seed: int, progress: Progress) -> Tables:
    """Smallest distance, off-axis deviation and end error around a ball, with constant gains and equal weights."""
    from pft_exec.control import compute_compliance, constant_compliance
    from pft_exec.evaluation.benchmarks.plant import arch_tube
    from pft_exec.model import load_robot

    arm = load_robot("pr2").arm("right")
    compliance, constant = compute_compliance(arch_tube(arm)), constant_compliance(400.0)
    count = len(compliance.time)
    cases = {
        "tube's gains and weights": compliance,
        "tube's gains, equal weights": replace(compliance, weight=np.repeat(constant.weight[:1], count, axis=0)),
        "constant 400 /s2, tube's weights": replace(compliance, gain=np.repeat(constant.gain[:1], count, axis=0)),
        "constant 400 /s2, equal weights": constant,
    }
    ways = {"at rest": 0.0, "crossing upwards": SPEED, "crossing downwards": -SPEED}
    tables: Tables = {}
    for place, (way, speed) in enumerate(ways.items()):
        progress(f"a ball {way}", place / len(ways))
        tables[f"ball of {1e2 * RADIUS:.0f} cm on the tube, {way}"] = [
            {"gains": name, **_row(arm, gains, speed, seed)} for name, gains in cases.items()
        ]
    tables["the same, not avoided"] = [{"gains": "tube's gains", **_row(arm, compliance, 0.0, seed, is_blind=True)}]
    return tables


def _row(arm: Arm, compliance: Compliance, speed: float, seed: int, is_blind: bool = False) -> dict[str, Any]:
    from pft_exec.control import TrackingController
    from pft_exec.evaluation.benchmarks.plant import PERIOD, Mismatch, Plant, arch_trajectory, arch_tube

    tube = arch_tube(arm)
    trajectory = arch_trajectory(arm, tube)
    ball = _ball(tube.position[len(tube) // 2], speed, trajectory.duration)
    controller = TrackingController(arm, PERIOD)
    controller.follow(trajectory.at, compliance, 0.0, blend=False)
    look = (lambda _: None) if is_blind else _looking(controller, ball)
    plant = Plant(arm, trajectory.at(0.0).configuration, Mismatch(friction=1.25), seed)
    done, distance = _watched(controller, plant, ball, trajectory.duration + HOLD, look)
    limit = arm.limits.torque
    return {
        "distance mm": 1e3 * distance,
        "off axis mm": 1e3 * float(np.hypot(done.error[:, 0], done.error[:, 2]).max()),
        "across mm": 1e3 * float(np.abs(done.error[:, 1]).max()),
        "end error mm": 1e3 * float(np.linalg.norm(done.error[-1, :3])),
        "torque share": float(max(np.max(np.abs(command.torque) / limit) for command in done.commands)),
    }


def _ball(middle: Array, speed: float, duration: float) -> Obstacle:
    """A ball that is beside the middle of the tube half-way through the motion; where it is at the beginning."""
    from pft_exec.model import Obstacle, Sphere

    velocity = np.array([0.0, 0.0, speed, 0.0, 0.0, 0.0])
    start = middle + np.array([0.0, BESIDE, 0.0]) - 0.5 * duration * velocity[:3]
    return Obstacle("ball", Sphere(RADIUS), Pose(start), velocity)


def _looking(controller: TrackingController, ball: Obstacle) -> Callable[[float], None]:
    """Tell the controller where the ball is, now and then."""
    every = max(1, round(SEEN_EVERY / controller.control_period))

    def look(time: float) -> None:
        if round(time / controller.control_period) % every == 0:
            controller.avoid([replace(ball, pose=ball.after(time))], time)

    return look


def _watched(
    controller: TrackingController, plant: Any, ball: Obstacle, duration: float, look: Callable[[float], None]
) -> tuple[Run, float]:
    """A run, and the smallest true distance of the arm from the ball, m."""
    from pft_exec.control import Avoidance
    from pft_exec.evaluation.benchmarks.plant import run

    witness = Avoidance(controller.arm, self_collision=False)
    witness.watch([ball], 0.0)
    nearest = [np.inf]

    def watch(time: float) -> None:
        look(time)
        witness.watch([replace(ball, pose=ball.after(time))], time)
        near = witness.near(controller.arm, plant.q, plant.v, time)
        nearest[0] = min(nearest[0], np.inf if near is None else float(near.distance.min()))

    return run(controller, plant, duration, before=watch), nearest[0]
