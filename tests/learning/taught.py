"""Demonstrations whose relations are known: four motions on a table, and a stirring one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array, Pose, interpolate_quaternion, multiply, quaternion_from_rotation_vector, rotate

TRUTH = {
    "reach": ("bottle", "absolute"),
    "put_on_table": ("mat", "mat"),
    "move_left": ("start", "start"),
    "go_home": ("absolute", "absolute"),
}
LEVEL = quaternion_from_rotation_vector([0.0, 0.0, 1.2])


def turned(angle: float) -> Array:
    """Quaternion of a turn about z."""
    return quaternion_from_rotation_vector([0.0, 0.0, angle])


def _end(label: str, start: Pose, bottle: Array, mat: Array) -> tuple[Array, Array]:
    home = multiply(turned(0.6), quaternion_from_rotation_vector([0.0, -0.5, 0.0]))
    return {
        "reach": (bottle[:3] + np.array([-0.0435, -0.1118, 0.02]), LEVEL),
        "put_on_table": (mat[:3] + np.array([0.0, 0.0, 0.127]), multiply(mat[3:], LEVEL)),
        "move_left": (start.position + np.array([0.0, 0.2, 0.0]), start.quaternion),
        "go_home": (np.array([0.42, -0.5, 1.12]), home),
    }[label]


def taught(label: str, rng: np.random.Generator, samples: int = 120, noise: float = 0.003) -> Demonstration:
    """One demonstration: minimum jerk with a bow, other placements and another start each time."""
    bottle = np.concatenate([rng.uniform([0.54, -0.24], [0.66, -0.12]), [0.8], turned(rng.uniform(-3.1, 3.1))])
    mat = np.concatenate([rng.uniform([0.48, -0.45], [0.58, -0.35]), [0.703], turned(rng.uniform(-0.25, 0.25))])
    tilt = quaternion_from_rotation_vector(rng.uniform(-0.2, 0.2, 3))
    start = Pose(rng.uniform([0.48, -0.42, 0.94], [0.58, -0.32, 1.04]), multiply(LEVEL, tilt))
    end, turn = _end(label, start, bottle, mat)
    end = end + rng.normal(0.0, noise, 3)
    turn = multiply(turn, quaternion_from_rotation_vector(rng.normal(0.0, 0.01, 3)))
    s = np.linspace(0.0, 1.0, samples)
    u = 10 * s**3 - 15 * s**4 + 6 * s**5
    bow = np.sin(np.pi * u)[:, None] * rng.normal(0.0, 0.01, 3)
    ends = np.broadcast_to(start.quaternion, (samples, 4)), np.broadcast_to(turn, (samples, 4))
    return Demonstration(
        label,
        s * rng.uniform(1.6, 2.4),
        start.position + u[:, None] * (end - start.position) + bow,
        interpolate_quaternion(*ends, u),
        continuous={"width": 0.08 - 0.05 * u},
        discrete={"closed": (u > 0.5).astype(int)},
        objects={"bottle": bottle, "mat": mat},
    )


def lesson(label: str, seed: int = 0, count: int = 5, samples: int = 120) -> list[Demonstration]:
    """Some demonstrations of one motion."""
    rng = np.random.default_rng(seed)
    return [taught(label, rng, samples) for _ in range(count)]


def all_lessons(seed: int = 0) -> list[Demonstration]:
    """Five demonstrations of each of the four motions."""
    rng = np.random.default_rng(seed)
    return [taught(label, rng) for label in TRUTH for _ in range(5)]


def moved(demonstration: Demonstration, transform: Pose) -> Demonstration:
    """The demonstration with everything in it carried by a rigid motion."""

    def poses(values: Array) -> Array:
        return np.concatenate(
            [transform.apply(values[..., :3]), multiply(transform.quaternion, values[..., 3:])], axis=-1
        )

    quaternion = demonstration.quaternion
    return replace(
        demonstration,
        position=transform.apply(demonstration.position),
        quaternion=None if quaternion is None else multiply(transform.quaternion, quaternion),
        objects={name: poses(values) for name, values in demonstration.objects.items()},
    )


def scaled(demonstration: Demonstration, factor: float) -> Demonstration:
    """The demonstration in another unit of length."""
    unit = np.array([factor] * 3 + [1.0] * 4)
    return replace(
        demonstration,
        position=factor * demonstration.position,
        objects={name: poses * unit for name, poses in demonstration.objects.items()},
    )


def stirring(seed: int = 0, count: int = 5, radius: float = 0.05) -> list[Demonstration]:
    """Five circles in slightly different planes, each demonstration over another cup."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        cup = np.concatenate([rng.uniform([0.5, -0.2], [0.6, -0.1]), [0.8, 0.0, 0.0, 0.0, 1.0]])
        s = np.linspace(0.0, 1.0, 400)
        u = 10 * s**3 - 15 * s**4 + 6 * s**5
        angle = 2 * np.pi * 5 * u
        circle = radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(400)], axis=1)
        tilt = quaternion_from_rotation_vector(rng.normal(0.0, 0.1, 3))
        drift = u[:, None] * rng.normal(0.0, 0.004, 3)
        position = cup[:3] + np.array([0.0, 0.0, 0.2]) + rotate(tilt, circle) + drift + rng.normal(0.0, 0.002, 3)
        found.append(Demonstration("stir", s * rng.uniform(5.5, 6.5), position, objects={"cup": cup}))
    return found


def with_objects(demonstrations: Sequence[Demonstration], count: int, seed: int = 0) -> list[Demonstration]:
    """The demonstrations with further objects strewn about."""
    rng = np.random.default_rng(seed)
    return [
        replace(
            d,
            objects=dict(d.objects)
            | {f"object{i}": np.append(rng.uniform(-1.0, 1.0, 3), turned(rng.uniform(-3, 3))) for i in range(count)},
        )
        for d in demonstrations
    ]
