"""Random tubes within an arm's reach, and states of the arm beside them, from which a robot may have to take over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pft_exec.control import (
    Compliance,
    RollingTrajectory,
    SmoothTube,
    TakenUp,
    TubeMetric,
    compute_compliance,
    smooth_tube,
)
from pft_exec.demonstration.synthetic import human_path
from pft_exec.exceptions import PFTError
from pft_exec.geometry import Array, Pose, multiply, quaternion_from_rotation_vector
from pft_exec.learning import FlowTube
from pft_exec.model import Arm, solve_inverse_kinematics

SPREAD, TURN = 0.06, 0.2
"""m, rad; how far from the tube the tool may be."""
SPEEDS = (0.5, 1.5)
"""Of the tube's own."""
PHASES = (0.1, 0.7)
"""Between which a state lies."""
REACH = (0.12, 0.12, 0.10)
"""m; half the sides of the box about the working posture's tool in which the tubes lie."""
_SAMPLES = 100


@dataclass(frozen=True, eq=False)
class Place:
    """A tube with all that is made of it once.

    Parameters
    ----------
    tube : FlowTube
        Base frame.
    smooth : SmoothTube
    compliance : Compliance
    path : RollingTrajectory
        Known to its end.
    metric : TubeMetric
        By which transitions are planned.
    precision : (N, 6, 6)
        Of the tube, m and rad, by which they are judged.
    """

    tube: FlowTube
    smooth: SmoothTube
    compliance: Compliance
    path: RollingTrajectory
    metric: TubeMetric
    precision: Array


@dataclass(frozen=True, eq=False)
class Start:
    """A state of the arm beside a tube that moves on.

    Parameters
    ----------
    place : Place
    target : TakenUp
        The tube from where the motion is, at the pace of the state.
    q, v : (n,), rad, rad/s
    """

    place: Place
    target: TakenUp
    q: Array
    v: Array


def random_place(arm: Arm, rng: np.random.Generator) -> Place | None:
    """A tube through three random poses, or None where the arm does not follow it at one and a half of its speed."""
    home = arm.forward(arm.configuration("work"))
    centers = home.position + rng.uniform(-1.0, 1.0, (3, 3)) * REACH
    turns = multiply(home.quaternion, quaternion_from_rotation_vector(rng.uniform(-0.4, 0.4, (3, 3))))
    path = human_path(centers, turns, rng.uniform(1.0, 1.6, 2), rng)
    time = np.linspace(0.0, path.duration, _SAMPLES)
    position, quaternion = path.at(time)
    deviation = _deviation(rng)
    tube = FlowTube("random", time, position, quaternion, deviation[:, :, None] ** 2 * np.eye(6))
    found = solve_inverse_kinematics(arm, tube.start, arm.configuration("work"))
    rolling = RollingTrajectory(arm, smooth_tube(tube, quaternion[0]), found.configuration)
    rolling.extend_until(float(time[-1]))
    if rolling.position_error > 1e-4 or rolling.highest_rate < SPEEDS[1]:
        return None
    precision: Array = np.linalg.inv(tube.covariance).astype(float)
    return Place(tube, rolling.tube, compute_compliance(tube), rolling, TubeMetric(tube), precision)


def _deviation(rng: np.random.Generator) -> Array:
    """Deviations (N, 6), m and rad, between 8 mm and 4 cm, that change smoothly from one end to the other."""
    ends = np.exp(rng.uniform(np.log(0.008), np.log(0.04), (2, 3)))
    share = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, _SAMPLES))[:, None]
    linear = (1.0 - share) * ends[0] + share * ends[1]
    return np.hstack([linear, rng.uniform(0.03, 0.15) * np.ones((_SAMPLES, 3))])


def random_start(arm: Arm, place: Place, rng: np.random.Generator) -> Start | None:
    """A state within `SPREAD` and `TURN` of a tube; None where the arm is not there."""
    speed, theta = rng.uniform(*SPEEDS), place.smooth.end * rng.uniform(*PHASES)
    on_tube = place.path.reference(theta, speed, 0.0)
    tool = arm.forward(on_tube.configuration)
    offset = SPREAD * rng.uniform() ** (1.0 / 3.0) * _direction(rng)
    turn = quaternion_from_rotation_vector(TURN * rng.uniform() * _direction(rng))
    try:
        found = solve_inverse_kinematics(
            arm, Pose(tool.position + offset, multiply(tool.quaternion, turn)), on_tube.configuration
        )
    except PFTError:
        return None
    if not found.found or np.max(np.abs(found.configuration - on_tube.configuration)) > 0.6:
        return None
    wanted = arm.jacobian(on_tube.configuration) @ on_tube.velocity
    jacobian = arm.jacobian(found.configuration)
    v = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T, wanted)
    return Start(place, TakenUp(place.path, theta, speed), found.configuration, v)


def _direction(rng: np.random.Generator) -> Array:
    vector = rng.standard_normal(3)
    unit: Array = vector / np.linalg.norm(vector)
    return unit


def random_starts(arm: Arm, count: int, seed: int, each: int = 25) -> list[Start]:
    """So many states, `each` about every tube."""
    rng = np.random.default_rng([seed, 23])
    starts: list[Start] = []
    while len(starts) < count:
        place = random_place(arm, rng)
        if place is None:
            continue
        drawn = [random_start(arm, place, rng) for _ in range(each)]
        starts += [start for start in drawn if start is not None]
    return starts[:count]
