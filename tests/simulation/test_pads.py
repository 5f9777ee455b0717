"""Pads share their press out over the patch that they lie on, and so keep what is held from turning, within reason."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pybullet
import pytest

from pft_exec.demonstration import Scene
from pft_exec.description import draw_scene, load_task, nominal_setting
from pft_exec.geometry import geodesic_distance
from pft_exec.model import load_robot, solve_inverse_kinematics
from pft_exec.simulation import SetUp, World

TASK, ROBOT = load_task("bottle"), load_robot("pr2")
PRESS = ROBOT.description.arms["right"].gripper.force.values[0]  # N


@pytest.fixture
def full() -> Iterator[World]:
    """A full bottle, held below its middle by an arm that stands still."""
    setting = nominal_setting(TASK, "pour_into", draw_scene(TASK, np.random.default_rng(0)))
    arm = ROBOT.arm("right")
    found = solve_inverse_kinematics(arm, setting.start, arm.configuration("teach"))
    with World(ROBOT, TASK, Scene(setting.objects)) as world:
        holding = SetUp(holding={"right": "bottle"}, liquid="bottle")
        world.reset(Scene(setting.objects), {"right": found.configuration}, holding)
        yield world


def _presses(world: World, finger: int) -> np.ndarray:
    """Normal forces, N, at the contact points of a finger and the bottle."""
    contacts = pybullet.getContactPoints(
        bodyA=world._body.body,
        bodyB=world._contents.objects["bottle"].body,
        linkIndexA=finger,
        physicsClientId=world._body._client,
    )
    return np.array([contact[9] for contact in contacts])


def _turned_by(world: World, torque: float, duration: float = 0.5) -> float:
    """Rad that the bottle turns in the gripper under a torque, N m, about the axis through the pads."""
    before = world.tool().inverse() @ world.scene["bottle"]
    axis = world.tool().rotation[:, 1]
    for _ in range(round(duration / world.physics_step)):
        pybullet.applyExternalTorque(
            world._contents.objects["bottle"].body,
            -1,
            (torque * axis).tolist(),
            pybullet.WORLD_FRAME,
            physicsClientId=world._body._client,
        )
        world.step()
    after = world.tool().inverse() @ world.scene["bottle"]
    return float(geodesic_distance(before.quaternion, after.quaternion))


def test_a_pad_presses_with_all_corners_of_its_patch_and_not_with_one(full: World) -> None:
    for finger in np.array(full._body._indices)[full._body._fingers["right"]]:
        press = _presses(full, int(finger))
        assert press.sum() == pytest.approx(PRESS, abs=5.0)
        assert press.max() < 0.3 * press.sum()


def test_a_bottle_held_below_its_middle_does_not_tip_between_the_pads(full: World) -> None:
    assert _turned_by(full, 0.0, 2.0) < 0.005


def test_what_is_held_withstands_a_torque_about_the_pads_as_far_as_friction_goes(full: World) -> None:
    """Two patches of 25 by 22 mm under 35 N and a friction of 1: corners 16.6 mm from the middle bear 1.16 N m."""
    assert _turned_by(full, 0.8) < 0.01
    assert _turned_by(full, 1.6) > 0.1
