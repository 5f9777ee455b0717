"""Stopping: the arm comes to rest, and nobody who pushes meanwhile brings a joint past its velocity limit."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.faults import Fault
from pft_exec.execution.safety.stopping import stop
from pft_exec.model import load_robot
from pft_exec.simulation import Push, World


class Fastest:
    """Remembers the largest share of a velocity limit."""

    def __init__(self, world: World, arm: str | None) -> None:
        self._arm, self._limit = arm, world.arm(arm).limits.velocity
        self.share = 0.0

    def __call__(self, world: World) -> None:
        self.share = max(self.share, float(np.max(np.abs(world.true_state(self._arm)[1]) / self._limit)))


@pytest.mark.parametrize(("robot", "task", "arm"), [("pr2", "tabletop", "right"), ("wam", "anchor", None)])
def test_a_lasting_push_brings_no_joint_past_its_velocity_limit(robot: str, task: str, arm: str | None) -> None:
    for direction in (*np.eye(3), *-np.eye(3)[:2]):  # downwards the tool would meet the table
        with World(load_robot(robot), task, seed=0, control_period=2e-3) as world:
            fastest = Fastest(world, arm)
            stop(ControlLoop(world, arm, [Push(0.0, 0.4, 40.0 * direction)], fastest), "a test")
            assert np.abs(world.true_state(arm)[1]).max() < 0.05  # rad/s
            assert fastest.share < 0.9


def test_an_arm_that_is_not_seen_is_not_pushed_away_from_a_joint_limit() -> None:
    """Its wall would push all the while: a spring on a position that is only believed."""
    with World(load_robot("wam"), "anchor", seed=0, control_period=2e-3) as world:
        limits, q = world.arm().limits, world.true_state()[0]
        q[4] = limits.upper[4] - 0.015
        world.place(world.arm_name(None), q)
        fastest = Fastest(world, None)
        loop = ControlLoop(world, None, (), fastest, [Fault("encoder_frozen", 0.0, np.inf)])
        for _ in range(20):
            loop.sense()
            world.command(None, world.arm().gravity(q))
            world.step()
        stop(loop, "a test")
        assert fastest.share < 0.1
