"""Avoiding: led through an object the tool goes round it inside its tube, and what is near never throws the arm."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from pft_exec.control import Avoidance
from pft_exec.demonstration import Scene
from pft_exec.execution import ExecutionLog, execute
from pft_exec.execution.surroundings import Surroundings
from pft_exec.geometry import Pose
from pft_exec.learning import FlowTube
from pft_exec.simulation import World

LIFT = 0.26  # m
COMING = 0.07, 1.5  # m and s; from where and how long a moving object comes
LYING = (0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5))


@pytest.fixture(params=[0.001, 0.002], ids=["1 ms", "2 ms"])
def opened(request: pytest.FixtureRequest) -> Iterator[World]:
    with World("pr2", "tabletop", control_period=request.param) as world:
        yield world


@pytest.fixture(scope="module")
def table() -> Iterator[World]:
    with World("pr2", "tabletop", control_period=0.002) as world:
        yield world


def _ahead(tool: Pose) -> np.ndarray:
    """The direction (3,) in which the gripper points, horizontal."""
    ahead = tool.rotation[:, 0] * [1.0, 1.0, 0.0]
    return ahead / np.linalg.norm(ahead)


def _upwards(start: Pose, height: float, duration: float, spread: np.ndarray) -> FlowTube:
    """A tube straight up; spread (N, 6, 6)."""
    s = np.linspace(0.0, 1.0, len(spread))
    along = height * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5)
    position = start.position + np.outer(along, [0.0, 0.0, 1.0])
    return FlowTube("up", duration * s, position, np.tile(start.quaternion, (len(s), 1)), spread)


def _wide_ahead(start: Pose) -> np.ndarray:
    """Narrow but for the direction in which the gripper points, in the middle: (60, 6, 6)."""
    room = 0.045 * np.sin(np.pi * np.linspace(0.0, 1.0, 60)) ** 2
    spread = np.tile(np.diag([0.005**2] * 3 + [0.03**2] * 3), (60, 1, 1))
    spread[:, :3, :3] += (room**2)[:, None, None] * np.outer(_ahead(start), _ahead(start))
    return spread


def _scene(world: World, bottle: Pose) -> Scene:
    """The bottle at a place, and everything else far away."""
    away = {name: Pose(np.array([0.85, 0.55 + 0.15 * k, 0.8])) for k, name in enumerate(world.task.placed)}
    return Scene({**away, "bottle": bottle})


@dataclass(frozen=True)
class _Led:
    log: ExecutionLog
    distance: float


def _led_through(world: World, is_coming: bool, avoid: tuple[str, ...]) -> _Led:
    """Lead the tool up through a bottle that is held in the air, lying across the tube; its true least distance, m."""
    world.reset()
    start = world.tool("right")
    ahead = _ahead(start)
    middle = start.position + 0.06 * ahead + np.array([0.0, 0.0, 0.5 * LIFT])
    far, duration = COMING if is_coming else (0.0, 1.0)
    world.reset(_scene(world, Pose(middle + far * ahead, LYING)))
    begin, least = world.time, [np.inf]
    eyes, witness = Surroundings(world, "right", ["bottle"], other_arms=False), Avoidance(world.arm("right"), False)

    def hold(now: World) -> None:
        left = far * (1.0 - min((now.time - begin) / duration, 1.0))
        now._contents.objects["bottle"].place(Pose(middle + left * ahead, LYING))
        witness.watch(eyes.look(), 0.0)
        near = witness.near(now.arm("right"), *now.true_state("right"), 0.0)
        least[0] = min(least[0], np.inf if near is None else float(near.distance.min()))

    tube = _upwards(start, LIFT, 3.0, _wide_ahead(start))
    return _Led(execute(world, tube, "right", avoid=avoid, observer=hold), least[0])


@pytest.mark.parametrize("is_coming", [False, True], ids=["at rest", "coming"])
def test_the_tool_goes_round_a_bottle_on_its_tube_and_comes_to_the_end(table: World, is_coming: bool) -> None:
    led = _led_through(table, is_coming, ("bottle",))
    assert led.log.success, led.log.reason
    assert led.distance >= 0.02
    assert led.log.details["end_position_error"] < 0.004
    assert (np.abs(led.log.torque) < 0.5 * table.arm("right").limits.torque).all()
    assert {event.name for event in led.log.events} == {"joined"}


def test_without_being_told_it_goes_through(table: World) -> None:
    assert _led_through(table, False, ()).distance < 0.005


def test_what_is_beside_the_tool_from_the_beginning_is_left_calmly(opened: World) -> None:
    """A bottle and the other arm within the distance that is to be kept, and a tube that holds nothing fast."""
    start = opened.tool("right")
    beside = start.position + start.rotation @ np.array([0.0, -0.105, 0.0])
    beside[2] = opened.scene["bottle"].position[2]
    opened.reset(_scene(opened, Pose(beside)))
    tube = _upwards(opened.tool("right"), 0.03, 2.0, np.tile(0.05**2 * np.eye(6), (40, 1, 1)))
    _is_calm(execute(opened, tube, "right", avoid=["bottle"]), 0.5)


@pytest.mark.parametrize(("robot", "task"), [("pr2", "tabletop"), ("wam", "ball_bin")])
@pytest.mark.parametrize("period", [0.001, 0.002])
def test_a_wide_tube_is_followed_calmly(robot: str, task: str, period: float) -> None:
    with World(robot, task, control_period=period) as world:
        tube = _upwards(world.tool(), 0.03, 2.0, np.tile(0.05**2 * np.eye(6), (40, 1, 1)))
        _is_calm(execute(world, tube), 0.15)


def _is_calm(log: ExecutionLog, speed: float) -> None:
    assert {event.name for event in log.events} == {"joined"}
    assert log.details["end_position_error"] < 0.02  # nothing holds it fast
    assert np.abs(log.velocity).max() < speed
