"""A world, and a library of the tabletop's motions as the hand would make them, without the arm's part in it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.description import draw_settings, random_stream
from pft_exec.exceptions import UnreachableError
from pft_exec.execution.hand.hand_path import plan_hand_path
from pft_exec.learning import MotionLibrary, learn_library
from pft_exec.simulation import World


@pytest.fixture(scope="package")
def shared_world() -> Iterator[World]:
    with World("pr2", "tabletop", seed=0) as opened:
        yield opened


@pytest.fixture(scope="package")
def library(shared_world: World) -> MotionLibrary:
    return learn_library(
        demonstration for label in shared_world.task.labels for demonstration in planned(shared_world, label, count=5)
    )


def planned(world: World, label: str, count: int) -> list[Demonstration]:
    """Demonstrations that follow the hand's path exactly."""
    generator = random_stream(0, "teach", label, "tests of execution")
    demonstrations: list[Demonstration] = []
    while len(demonstrations) < count:
        for setting in draw_settings(world.task, label, count, generator):
            try:
                plan = plan_hand_path(world, label, "right", setting, generator)
            except UnreachableError:
                continue
            time = np.arange(0.0, plan.duration, 0.01)
            position, quaternion = plan.at(time)
            objects = {name: pose.array for name, pose in setting.objects.items()}
            demonstrations.append(Demonstration(label, time, position, quaternion, objects=objects))
    return demonstrations[:count]
