"""The same calls give the same bits: after a reset, beside another world, in another process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pft_exec.description import TaskDescription
from pft_exec.model import RobotModel
from pft_exec.simulation import World
from tests.simulation.runs import disturbed_run, float_arm, near_bottle, snapshot

_ROOT = Path(__file__).parents[2]
_PROGRAM = """
from pft_exec.simulation import World
from tests.simulation.runs import disturbed_run, near_bottle
world = World("pr2", "tabletop", seed=3)
world.reset(near_bottle(world))
print(disturbed_run(world))
"""


@pytest.fixture
def reference(robot: RobotModel, task: TaskDescription) -> str:
    with World(robot, task, seed=3) as world:
        scene = near_bottle(world)
        world.reset(scene)
        digest = disturbed_run(world)
        moved = np.linalg.norm(world.scene["bottle"].position - scene["bottle"].position)
        assert moved > 0.01, "the run is to be one with contact"
    return digest


def test_a_reset_world_repeats_itself_bit_for_bit(robot: RobotModel, task: TaskDescription, reference: str) -> None:
    with World(robot, task, seed=3) as world:
        scene = near_bottle(world)
        float_arm(world, "left", 50)
        world.push("right", [0.0, 0.0, 30.0])
        world.reset(scene)
        assert disturbed_run(world) == reference
        world.reset(scene)
        assert disturbed_run(world) == reference


def test_another_process_gives_the_same_bits(reference: str) -> None:
    run = subprocess.run([sys.executable, "-c", _PROGRAM], cwd=_ROOT, capture_output=True, text=True, check=True)
    assert run.stdout.split()[-1] == reference


def test_two_worlds_do_not_disturb_one_another(robot: RobotModel, task: TaskDescription) -> None:
    """Stepped in turns they do what each does alone."""

    def advance(world: World, steps: int, force: float) -> None:
        for _ in range(steps):
            world.push("right", [0.0, force, 0.0])
            float_arm(world, "right", 1)

    alone = []
    for force in (8.0, -8.0):
        with World(robot, task, seed=4) as world:
            advance(world, 100, force)
            alone.append(snapshot(world))
    with World(robot, task, seed=4) as first, World(robot, task, seed=4) as second:
        for _ in range(100):
            advance(first, 1, 8.0)
            advance(second, 1, -8.0)
        np.testing.assert_array_equal(snapshot(first), alone[0])
        np.testing.assert_array_equal(snapshot(second), alone[1])


def test_the_seed_draws_the_scene(robot: RobotModel, task: TaskDescription) -> None:
    with World(robot, task, seed=5) as first, World(robot, task, seed=5) as again, World(robot, task, seed=6) as other:
        assert first.scene == again.scene
        assert first.scene != other.scene
