"""Arms of every robot that ships, and random states inside their limits."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from pft_exec.geometry import Array
from pft_exec.model import Arm, RobotModel, load_robot

CASES = [("pr2", None, "left"), ("pr2", None, "right"), ("wam", None, "arm"), ("wam", "gripper", "arm")]


@cache
def loaded(name: str, tool: str | None) -> RobotModel:
    return load_robot(name, tool)


@pytest.fixture(params=CASES, ids=lambda case: "-".join(part for part in case if part))
def robot_and_arm(request: pytest.FixtureRequest) -> tuple[RobotModel, Arm]:
    name, tool, arm = request.param
    return loaded(name, tool), loaded(name, tool).arm(arm)


@pytest.fixture
def arm(robot_and_arm: tuple[RobotModel, Arm]) -> Arm:
    return robot_and_arm[1]


@pytest.fixture
def right() -> Arm:
    return loaded("pr2", None).arm("right")


@pytest.fixture
def states(arm: Arm) -> list[tuple[Array, Array]]:
    """Twenty random configurations inside the soft limits, each with a velocity of about 1 rad/s."""
    generator = np.random.default_rng(7)
    lower, upper = np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)
    count = len(arm.joint_names)
    return [(generator.uniform(lower, upper), generator.normal(size=count)) for _ in range(20)]
