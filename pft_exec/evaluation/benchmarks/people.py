"""Synthetic people for the benchmarks: motions of a given size, in any number."""

from __future__ import annotations

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.demonstration.synthetic import human_path

SAMPLES = 200


def synthetic_demonstrations(
    motions: int, seed: int, count: int = 5, samples: int = SAMPLES, pose: bool = True
) -> list[Demonstration]:
    """`count` demonstrations of each of some motions through random places of a cube of 0.6 m, `samples` each."""
    rng = np.random.default_rng([seed, 3])
    demonstrations = []
    for motion in range(motions):
        places = rng.uniform(-0.3, 0.3, (4, 3))
        turns = rng.standard_normal((4, 4))
        turns = turns / np.linalg.norm(turns, axis=1, keepdims=True)
        for _ in range(count):
            path = human_path(places + 0.01 * rng.standard_normal((4, 3)), turns, np.full(3, 0.7), rng)
            clock = np.linspace(0.0, path.duration, samples)
            position, quaternion = path.at(clock)
            demonstrations.append(Demonstration(f"motion {motion}", clock, position, quaternion if pose else None))
    return demonstrations
