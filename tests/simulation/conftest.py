"""A PR2 before the tabletop task, set up anew for each test."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import pytest

from pft_exec.description import TaskDescription, load_task
from pft_exec.model import RobotModel, load_robot
from pft_exec.simulation import World


@cache
def pr2() -> RobotModel:
    return load_robot("pr2")


@cache
def tabletop() -> TaskDescription:
    return load_task("tabletop")


@pytest.fixture(scope="session")
def robot() -> RobotModel:
    return pr2()


@pytest.fixture(scope="session")
def task() -> TaskDescription:
    return tabletop()


@pytest.fixture
def world() -> Iterator[World]:
    with World(pr2(), tabletop()) as world:
        yield world
