"""Nine motions with a bottle and a cup as people make them, and what matters in each; mostly the bottle is in hand."""

from __future__ import annotations

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.demonstration.synthetic import human_path, minimum_jerk
from pft_exec.geometry import Array, multiply, quaternion_from_rotation_vector, rotate

LEVEL = quaternion_from_rotation_vector([0.0, 0.0, 1.2])
ROLLED = multiply(LEVEL, quaternion_from_rotation_vector([-1.9, 0.0, 0.0]))
UP = np.array([0.0, 0.0, 1.0])
OVER_CUP = np.array([-0.06, -0.05, 0.20])
REACHED_EMPTY = ("go_home", "reach")


def _relations(*frames: str) -> dict[str, dict[str, str]]:
    """Frames of position and orientation at the start, then at the end."""
    return {
        "start": {"position": frames[0], "orientation": frames[1]},
        "end": {"position": frames[2], "orientation": frames[3]},
    }


RELATIONS = {
    "move_left": _relations("", "", "start", "start"),
    "up_and_over": _relations("", "", "start", "start"),
    "go_home": _relations("", "", "absolute", "absolute"),
    "reach": _relations("", "", "bottle", "absolute"),
    "put_on_table": _relations("", "", "mat", "absolute"),
    "pour_into": _relations("", "", "cup", "absolute"),
    "pour_done": _relations("cup", "absolute", "absolute", "absolute"),
    "shake": _relations("", "", "start", "start"),
    "stir": _relations("cup", "absolute", "cup", "absolute"),
}
LABELS = tuple(RELATIONS)


def _yaw(angle: float) -> Array:
    return quaternion_from_rotation_vector([0.0, 0.0, angle])


def _place(rng: np.random.Generator, low: list[float], high: list[float]) -> Array:
    return rng.uniform(low, high)


def _tilted(rng: np.random.Generator, *most: float) -> Array:
    return multiply(LEVEL, quaternion_from_rotation_vector(rng.uniform(-1.0, 1.0, 3) * most))


def _waypoints(
    label: str, rng: np.random.Generator, bottle: Array, cup: Array, mat: Array
) -> tuple[list[Array], list[Array], list[float]]:
    """Positions, orientations, and durations between them."""
    start, free = _place(rng, [0.50, -0.44, 0.96], [0.60, -0.34, 1.06]), _tilted(rng, 0.1, 0.1, 0.15)
    pouring, home = cup + OVER_CUP, np.array([0.42, -0.50, 1.12])
    if label == "move_left":
        left = np.array([0.0, 0.2 * np.exp(0.1 * rng.standard_normal()), 0.0])
        return [start, start + left], [free, free], [2.5]
    if label == "up_and_over":
        turn = _tilted(rng, 0.0, 0.0, 0.15)
        steps = [np.zeros(3), 0.18 * UP, np.array([0.02, 0.2, 0.18]), np.array([0.02, 0.2, 0.0])]
        return [bottle + step for step in steps], [turn] * 4, [1.2, 1.4, 1.2]
    if label == "go_home":
        tucked = multiply(_yaw(0.6), quaternion_from_rotation_vector([0.0, -0.5, 0.0]))
        return [start, home], [free, tucked], [3.0]
    if label == "reach":
        before = bottle - rotate(LEVEL, np.array([0.1, 0.0, 0.0]))
        return [start, before, bottle], [free, LEVEL, LEVEL], [2.0, 1.0]
    if label == "put_on_table":
        return [start, mat + 0.22 * UP, mat + 0.12 * UP], [free, LEVEL, LEVEL], [1.8, 1.4]
    if label == "pour_into":
        return [start, pouring, pouring], [_tilted(rng, 0.05, 0.05, 0.1), LEVEL, ROLLED], [1.8, 2.2]
    if label == "pour_done":
        return [pouring, pouring + 0.02 * UP, np.array([0.56, -0.32, 1.02])], [ROLLED, LEVEL, LEVEL], [1.5, 1.8]
    heights = (0.0, 0.06, -0.06, 0.06, -0.06, 0.0)
    turn = _tilted(rng, 0.08, 0.08, 0.15)
    return [start + h * UP for h in heights], [turn] * 6, [0.25, 0.4, 0.4, 0.4, 0.3]


def _stirred(rng: np.random.Generator, cup: Array, radius: float) -> tuple[Array, Array]:
    """Five circles (N, 3), in a slightly tilted plane over the cup."""
    u = minimum_jerk(np.linspace(0.0, 1.0, 400))
    angle = 10.0 * np.pi * u + rng.normal(0.0, 0.03)
    size = radius * (1.0 + 0.03 * rng.standard_normal())
    circles = size * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    tilt = quaternion_from_rotation_vector(rng.normal(0.0, 0.08, 3))
    drift = u[:, None] * rng.normal(0.0, 0.004, 3) + rng.normal(0.0, 0.004, 3)
    tool = multiply(LEVEL, quaternion_from_rotation_vector(rng.normal(0.0, 0.01, 3)))
    center = cup + np.array([-0.04, 0.0, 0.24])
    return center + rotate(tilt, circles) + drift, np.broadcast_to(tool, (400, 4))


def perform(label: str, rng: np.random.Generator, radius: float = 0.05) -> Demonstration:
    """One demonstration with idle ends, in a scene of its own with bottle, cup, mat and a box that does not matter."""
    bottle = _place(rng, [0.50, -0.38, 0.82], [0.62, -0.26, 0.82])
    cup = _place(rng, [0.56, -0.20, 0.70], [0.64, -0.10, 0.70])
    mat = _place(rng, [0.48, -0.45, 0.70], [0.58, -0.35, 0.70])
    box = _place(rng, [0.45, -0.50, 0.72], [0.70, 0.0, 0.72])
    if label == "stir":
        position, quaternion = _stirred(rng, cup, radius)
    else:
        places, turns, durations = _waypoints(label, rng, bottle, cup, mat)
        _, position, quaternion = human_path(np.array(places), np.array(turns), durations, rng).sample(0.02)
    rests = rng.integers(10, 25, 2)
    index = np.clip(np.arange(-rests[0], len(position) + rests[1]), 0, len(position) - 1)
    position, quaternion = position[index], np.asarray(quaternion)[index]
    grip = np.hstack(
        [position + rotate(quaternion, rng.normal(0.0, 0.003, 3)), multiply(quaternion, _yaw(rng.uniform(-3, 3)))]
    )
    stands = np.append(bottle - 0.02 * UP, _yaw(rng.uniform(-3, 3)))
    return Demonstration(
        label,
        0.02 * np.arange(len(index)),
        position,
        quaternion,
        objects={
            "bottle": stands if label in REACHED_EMPTY else grip,
            "cup": np.append(cup, _yaw(rng.uniform(-3, 3))),
            "mat": np.append(mat, _yaw(rng.uniform(-0.25, 0.25))),
            "box": np.append(box, _yaw(rng.uniform(-3, 3))),
        },
    )
