"""A gripper holds by friction, or by a constraint where asked for, and the world says what it holds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from pft_exec.demonstration import Scene
from pft_exec.description import draw_scene, load_task, nominal_setting
from pft_exec.exceptions import MissingObjectError, SimulationError, UnknownNameError
from pft_exec.model import load_robot, solve_inverse_kinematics
from pft_exec.simulation import SetUp, World

TASK = load_task("bottle")
ROBOT = load_robot("pr2")
SCENE = Scene(draw_scene(TASK, np.random.default_rng(0)))
HOLDING = SetUp(holding={"right": "bottle"})


@pytest.fixture(scope="module")
def opened() -> Iterator[World]:
    with World(ROBOT, TASK, SCENE) as world:
        yield world


def _set_up(world: World, label: str, set_up: SetUp) -> None:
    setting = nominal_setting(TASK, label, SCENE.objects)
    arm = ROBOT.arm("right")
    found = solve_inverse_kinematics(arm, setting.start, arm.configuration("teach"))
    world.reset(Scene(setting.objects), {"right": found.configuration}, set_up)


def _grip(world: World) -> np.ndarray:
    return (world.tool().inverse() @ world.scene["bottle"]).position


@pytest.mark.parametrize("kind", ["friction", "constraint"])
def test_a_held_object_moves_with_the_arm_and_slips_less_than_two_millimetres(kind: str) -> None:
    with World(ROBOT, TASK, SCENE, grasp=kind) as world:
        _set_up(world, "shake", HOLDING)
        assert world.time == 0.0
        assert world.held() == "bottle"
        before, height = _grip(world), world.scene["bottle"].position[2]
        arm = world.arm().with_payload(*world.load("bottle"))
        for _ in range(500):
            q, v = world.state()
            lift = arm.jacobian(q).T @ np.array([0.0, 0.0, 3.0, 0.0, 0.0, 0.0])
            world.command("right", arm.gravity(q) - arm.counterbalance(q) + lift - 1.0 * v)
            world.step()
        assert world.scene["bottle"].position[2] > height + 0.005
        assert np.linalg.norm(_grip(world) - before) < 0.002
        assert world.held() == "bottle"


@pytest.mark.parametrize("kind", ["friction", "constraint"])
def test_an_opened_gripper_lets_go(kind: str) -> None:
    with World(ROBOT, TASK, SCENE, grasp=kind) as world:
        _set_up(world, "shake", HOLDING)
        world.grip("right", closed=False)
        assert not world.is_gripper_closed()
        for _ in range(400):
            world.step()
        assert world.held() is None
        assert world.scene["bottle"].position[2] < 0.85


def test_a_gripper_that_closes_on_a_standing_bottle_holds_it_where_it_stands(opened: World) -> None:
    _set_up(opened, "up_and_over", SetUp(opened=("right",)))
    assert opened.gripper() == pytest.approx(0.086, abs=1e-3)
    assert opened.held() is None
    before = opened.scene["bottle"]
    opened.grip("right", closed=True)
    for _ in range(600):
        opened.step()
    assert opened.held() == "bottle"
    assert np.linalg.norm(opened.scene["bottle"].position - before.position) < 0.005
    assert opened.gripper() == pytest.approx(0.06, abs=2e-3)


def test_an_empty_hand_holds_nothing_not_even_itself(opened: World) -> None:
    opened.reset(SCENE)
    for _ in range(100):
        opened.step()
    assert opened.held() is None


def test_what_is_held_weighs_what_the_task_says_and_hangs_below_the_tool(opened: World) -> None:
    _set_up(opened, "shake", HOLDING)
    mass, center = opened.load("bottle")
    assert mass == TASK.objects["bottle"].mass
    assert np.allclose(center, [0.0, 0.0, -0.03], atol=2e-3)


def test_the_same_set_up_is_the_same_bit_for_bit(opened: World) -> None:
    runs = []
    for _ in range(2):
        _set_up(opened, "shake", HOLDING)
        for _ in range(50):
            opened.step()
        runs.append((opened.scene["bottle"].array, opened.gripper()))
    assert np.array_equal(runs[0][0], runs[1][0])
    assert runs[0][1] == runs[1][1]


def test_what_cannot_be_set_up_is_refused(opened: World) -> None:
    with pytest.raises(MissingObjectError, match="object of the task"):
        opened.reset(SCENE, set_up=SetUp(holding={"right": "botle"}))
    with pytest.raises(SimulationError, match="no vessel"):
        opened.reset(SCENE, set_up=SetUp(liquid="can"))
    with pytest.raises(UnknownNameError, match="'friction', 'constraint'"):
        World(ROBOT, TASK, SCENE, grasp="glue")
    opened.reset(SCENE)


def test_liquid_settles_in_its_vessel_and_is_part_of_its_load(opened: World) -> None:
    _set_up(opened, "pour_into", replace(HOLDING, liquid="bottle"))
    assert opened.liquid.shape == (TASK.liquid.count, 3)
    local = opened.scene["bottle"].inverse().apply(opened.liquid)
    assert (np.hypot(local[:, 0], local[:, 1]) < 0.03).all()
    assert (np.abs(local[:, 2]) < 0.09).all()
    mass, _ = opened.load("bottle")
    assert mass == pytest.approx(0.4 + TASK.liquid.count * TASK.liquid.mass)


def test_a_recorded_state_shows_the_liquid_where_it_was(opened: World) -> None:
    _set_up(opened, "pour_into", replace(HOLDING, liquid="bottle"))
    state = opened.record_state()
    opened.reset(SCENE)
    assert len(opened.liquid) == 0
    opened.show_state(state)
    assert np.allclose(opened.liquid, state.liquid)
