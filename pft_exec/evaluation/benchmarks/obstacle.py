"""Obstacle: what the arm keeps of its distance, and who gives way, around a ball on the tube, at rest and moving.

One placement with the alternatives beside it, then random ones at several speeds, from every side. The rule of what
counts: a random ball is left out only where the tube has no room to go round it, which is where no sidestep along the
tube's wide axis, of up to 2.5 deviations and of the same number throughout, keeps the whole arm off the ball at every
instant of the motion and of the rest after it. (Sidesteps that change on the way, at up to 0.3 m/s, leave out the very
same balls; measured on 200.) What is left out sweeps through the place of hand or forearm on both sides, or through the
tube's narrow ends while the hand is there; a controller that waited could still pass some of them. Also from those the
arm keeps its distance, but not always its tube.
How many were left out is told in the table; none is left out by what a controller makes of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pft_exec.evaluation.benchmarks.stopwatch import Tables
from pft_exec.evaluation.protocol import Progress
from pft_exec.exceptions import InvalidSceneError
from pft_exec.geometry import Array, Pose

if TYPE_CHECKING:
    from pft_exec.control import Compliance, JointTrajectory, TrackingController
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
SPEEDS = (0.0, 0.05, 0.1, 0.2, 0.3)
"""m/s; of the balls that are placed at random."""
DRAWS = 500
"""Balls that are drawn for one that the tube has room to go round; one in four to one in eight has (measured)."""
PLACEMENTS = 8
"""So many at each speed."""
PHASES, ACROSS = (0.35, 0.65), 0.03
"""Where along the tube a random ball is met, and how far beside its mean, m."""
STEPS = np.linspace(-2.5, 2.5, 21)
"""Deviations of the tube by which a sidestep is tried."""
INSTANTS = 30
"""At which it is looked at."""
ROOM = 0.032
"""m; that a sidestep leaves between arm and ball: the controller's `SAFE_DISTANCE` and a little more."""
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
    round_it = _Round(arm)
    tables[f"balls of {1e2 * RADIUS:.0f} cm placed at random, where the tube has room to go round them"] = [
        round_it.row(speed, seed, compliance, progress) for speed in SPEEDS
    ]
    tables["the same, not avoided"] = [{"gains": "tube's gains", **_row(arm, compliance, 0.0, seed, is_blind=True)}]
    return tables


def _row(arm: Arm, compliance: Compliance, speed: float, seed: int, is_blind: bool = False) -> dict[str, Any]:
    from pft_exec.evaluation.benchmarks.plant import arch_trajectory, arch_tube

    tube = arch_tube(arm)
    trajectory = arch_trajectory(arm, tube)
    ball = _ball(tube.position[len(tube) // 2], speed, trajectory.duration)
    return _passed(arm, trajectory, compliance, ball, seed, is_blind)


def _passed(
    arm: Arm, trajectory: JointTrajectory, compliance: Compliance, ball: Obstacle, seed: int, is_blind: bool = False
) -> dict[str, Any]:
    """Figures of one run along the tube, past a ball."""
    from pft_exec.control import TrackingController
    from pft_exec.evaluation.benchmarks.plant import PERIOD, Mismatch, Plant

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


class _Round:
    """Random balls with room to go round them, and what becomes of them."""

    def __init__(self, arm: Arm) -> None:
        from pft_exec.control import Avoidance
        from pft_exec.evaluation.benchmarks.plant import arch_trajectory, arch_tube

        self.arm, self.tube = arm, arch_tube(arm)
        self.trajectory = arch_trajectory(arm, self.tube)
        self._witness = Avoidance(arm, self_collision=False)
        self._times = np.linspace(0.0, self.trajectory.duration + HOLD, INSTANTS)
        self._steps = [self._stepped(float(time)) for time in self._times]

    def _stepped(self, time: float) -> list[Array]:
        """Configurations (n,), rad, aside from the reference by each of the steps, at a time, s."""
        reference = self.trajectory.at(time)
        index = min(round(reference.phase * (len(self.tube) - 1)), len(self.tube) - 1)
        aside = np.zeros(6)
        aside[1] = np.sqrt(self.tube.covariance[index, 1, 1])
        per_step = np.linalg.pinv(self.arm.jacobian(reference.configuration)) @ aside
        return [reference.configuration + step * per_step for step in STEPS]

    def has_room(self, ball: Obstacle) -> bool:
        """Whether one of the steps keeps the arm off a ball at every instant."""
        left = np.ones(len(STEPS), dtype=bool)
        for time, configurations in zip(self._times, self._steps, strict=True):
            self._witness.watch([replace(ball, pose=ball.after(float(time)))], 0.0)
            for step in np.flatnonzero(left):
                q = configurations[step]
                near = self._witness.near(self.arm, q, 0.0 * q, 0.0)
                left[step] = near is None or float(near.distance.min()) > ROOM
            if not left.any():
                return False
        return True

    def ball(self, speed: float, rng: np.random.Generator) -> tuple[Obstacle, int]:
        """A ball that the motion meets, with a velocity in any direction, and how many were drawn for it.

        Raises
        ------
        InvalidSceneError
            If the tube has room for none of `DRAWS`.
        """
        from pft_exec.model import Obstacle, Sphere

        for drawn in range(1, DRAWS + 1):
            index = round(rng.uniform(*PHASES) * (len(self.tube) - 1))
            met, direction = self.tube.position[index].copy(), rng.standard_normal(3)
            met[1] += rng.uniform(-ACROSS, ACROSS)
            velocity = np.concatenate([speed * direction / np.linalg.norm(direction), np.zeros(3)])
            start = met - float(self.tube.time[index]) * velocity[:3]
            ball = Obstacle("ball", Sphere(RADIUS), Pose(start), velocity)
            if self.has_room(ball):
                return ball, drawn
        raise InvalidSceneError(f"the tube has no room to go round any of {DRAWS} balls of {speed:g} m/s.")

    def row(self, speed: float, seed: int, compliance: Compliance, progress: Progress) -> dict[str, Any]:
        """Worst and usual figures over the placements at a speed, m/s."""
        rng = np.random.default_rng([seed, 41, round(1e3 * speed)])
        seen, drawn = [], 0
        for k in range(PLACEMENTS):
            progress(f"balls placed at random, {speed:g} m/s", k / PLACEMENTS)
            ball, count = self.ball(speed, rng)
            drawn += count
            seen.append(_passed(self.arm, self.trajectory, compliance, ball, seed + k))
        column = {name: np.array([figures[name] for figures in seen]) for name in seen[0]}
        return {
            "m/s": speed,
            "balls": PLACEMENTS,
            "left out, no room": drawn - PLACEMENTS,
            "all floors kept %": 100.0 * float(np.mean([_keeps_floors(figures) for figures in seen])),
            "distance mm, least": float(column["distance mm"].min()),
            "off axis mm, median": float(np.median(column["off axis mm"])),
            "off axis, largest": float(column["off axis mm"].max()),
            "end error mm, median": float(np.median(column["end error mm"])),
            "end error, largest": float(column["end error mm"].max()),
        }


def _keeps_floors(figures: dict[str, Any]) -> bool:
    """Whether the arm keeps 2 cm off the ball, 10 mm of the tube off its wide axis, and 4 mm at its end."""
    kept: bool = figures["distance mm"] >= 20.0 and figures["off axis mm"] <= 10.0 and figures["end error mm"] <= 4.0
    return kept


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
