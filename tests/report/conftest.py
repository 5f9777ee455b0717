"""Demonstrations of two motions, a library of them, and the log of a run with a handoff."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.execution.log import BeliefHistory, Event, ExecutionLog, Stage
from pft_exec.learning import MotionLibrary, learn_library


def demonstrate(label: str, seed: int, count: int = 60) -> Demonstration:
    """`reach` ends 0.1 m short of a box that stands elsewhere each time, `lift` 0.3 m above its start."""
    rng = np.random.default_rng(seed)
    start, box = np.array([0.4, 0.0, 0.8]) + rng.uniform(-0.05, 0.05, 3), np.array([0.7, 0.2, 0.8])
    box[:2] += rng.uniform(-0.08, 0.08, 2)
    end = box - [0.1, 0.0, 0.0] if label == "reach" else start + np.array([0.0, 0.0, 0.3])
    u = np.linspace(0.0, 1.0, count)
    path = start + (end + rng.normal(0.0, 0.002, 3) - start) * (10 * u**3 - 15 * u**4 + 6 * u**5)[:, None]
    path += np.sin(np.pi * u)[:, None] * rng.normal(0.0, 0.01, 3)
    return Demonstration(label, 2.0 * u, path, objects={"box": np.array([*box, 0.0, 0.0, 0.0, 1.0])})


@pytest.fixture(scope="session")
def demonstrations() -> list[Demonstration]:
    return [demonstrate(label, seed) for label in ("reach", "lift") for seed in range(5)]


@pytest.fixture(scope="session")
def library(demonstrations: list[Demonstration]) -> MotionLibrary:
    return learn_library(demonstrations)


@pytest.fixture(scope="session")
def log() -> ExecutionLog:
    """Two seconds: led by the hand, a transition from 0.8 s to 1.1 s, then the tube and a hold."""
    time = np.arange(2000) * 1e-3
    position = np.sin(np.outer(time, np.linspace(0.5, 1.5, 7)))
    velocity = np.cos(np.outer(time, np.linspace(0.5, 1.5, 7))) * np.linspace(0.5, 1.5, 7)
    stage = np.select([time < 0.8, time < 1.1, time < 1.7], [Stage.GUIDED, Stage.TRANSITION, Stage.TUBE], Stage.HOLD)
    belief = BeliefHistory(
        ("lift", "reach"), np.array([0.0, 0.4, 0.8]), np.array([[0.5, 0.5], [0.2, 0.8], [0.01, 0.99]]), np.zeros(3)
    )
    return ExecutionLog(
        time=time,
        configuration=position,
        velocity=velocity,
        torque=3.0 * velocity,
        position=position[:, :3],
        quaternion=np.tile([0.0, 0.0, 0.0, 1.0], (2000, 1)),
        phase=np.where(time < 0.8, np.nan, time / 2.0),
        success=True,
        reason="the tube's end was reached",
        events=(Event(0.8, "take_over", "reach 0.99"),),
        robot="pr2",
        task="tabletop",
        arm="right",
        label="reach",
        reference_position=position,
        reference_velocity=velocity,
        reference_acceleration=np.zeros_like(position),
        stage=stage.astype(np.int64),
        hand_force=np.where(time < 0.8, 5.0, 0.0),
        tick=np.full(2000, 2e-4),
        belief=belief,
        details={"end_position_error": 0.003},
    )
