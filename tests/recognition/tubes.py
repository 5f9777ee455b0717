"""Tubes and streams whose answer is known."""

from __future__ import annotations

import numpy as np

from pft_exec.geometry import normalize_quaternion, quaternion_from_rotation_vector
from pft_exec.learning.flow_tube import AlignedDemonstrations, FlowTube


def random_covariances(rng, count, size):
    factor = rng.normal(size=(count, size, size)) * 0.1
    return factor @ factor.swapaxes(1, 2) + 0.01 * np.eye(size)


def random_tube(rng, label, steps, turned):
    time = np.concatenate([[0.0], np.cumsum(rng.uniform(0.0, 0.1, steps - 1))])
    quaternion = normalize_quaternion(np.cumsum(rng.normal(size=(steps, 4)), axis=0) + np.array([0.0, 0.0, 0.0, 3.0]))
    return FlowTube(
        label,
        time,
        np.cumsum(rng.normal(scale=0.1, size=(steps, 3)), axis=0),
        quaternion if turned else None,
        random_covariances(rng, steps, 6 if turned else 3),
        rng.uniform(0.0, 0.1, steps),
        count=int(rng.integers(1, 6)),
    )


def line(label, direction, steps=100, duration=2.0, deviation=0.01, turn=None, aligned=5, seed=0, **more):
    """A straight motion of 0.4 m from the origin, with minimum-jerk-like speed and a few demonstrations."""
    rng = np.random.default_rng(seed)
    s = np.linspace(0.0, 1.0, steps)
    path = 0.4 * (10 * s**3 - 15 * s**4 + 6 * s**5)[:, None] * np.asarray(direction, dtype=float)
    time = duration * s
    size = 3 if turn is None else 6
    covariance = np.tile(np.eye(size) * deviation**2, (steps, 1, 1))
    quaternion = None if turn is None else quaternion_from_rotation_vector(s[:, None] * np.asarray(turn, dtype=float))
    evidence = None
    if aligned:
        bends = np.sin(np.pi * s)[:, None] * rng.normal(scale=deviation, size=(aligned, 1, 3))
        paces = rng.uniform(0.85, 1.15, (aligned, 1))
        turns = None if quaternion is None else np.tile(quaternion, (aligned, 1, 1))
        evidence = AlignedDemonstrations(path + bends, turns, paces * time)
    return FlowTube(
        label, time, path, quaternion, covariance, np.full(steps, 0.05), count=aligned, aligned=evidence, **more
    )


def directions(count=4):
    """Unit vectors in the plane, evenly spread."""
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)


def star(count=4, **more):
    """Tubes "0", "1", ... that leave the origin in different directions."""
    return [line(str(k), d, seed=k, **more) for k, d in enumerate(directions(count))]


def stream(recognizer, tube, rate=100.0, pace=1.0, start=0.0, turned=True, until=1.0, bend=(0.0, 0.0, 0.006)):
    """Beliefs along a motion like the tube's, sampled at `rate` (Hz); `pace` 2 is twice as fast."""
    duration = tube.duration / pace
    times = np.arange(0.0, until * duration + 0.5 / rate, 1.0 / rate)
    beliefs = []
    for time in times:
        phase = min(time / duration, 1.0)
        state = tube.at(phase)
        position = state.position + np.sin(np.pi * phase) * np.asarray(bend)
        beliefs.append(recognizer.update(start + time, position, state.quaternion if turned else None))
    return beliefs
