"""The guiding hand: it leads the floating arm closely and gently, bounds its force, and lets go."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.demonstration.synthetic import STEADY, HumanPath, human_path
from pft_exec.description import nominal_setting, resolve_waypoints
from pft_exec.exceptions import SimulationError
from pft_exec.geometry import quaternion_from_rotation_vector
from pft_exec.model import solve_inverse_kinematics
from pft_exec.simulation import HandGrip, HandGuide, World

AT_REST = np.zeros(6)
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def straight_path(length: float = 0.1, turn: float = 0.5) -> HumanPath:
    turned = quaternion_from_rotation_vector([0.0, 0.0, turn])
    return human_path([[0.0, 0.0, 0.0], [length, 0.0, 0.0]], [LEVEL, turned], [1.0], np.random.default_rng(0), STEADY)


def test_the_hand_pulls_towards_its_place_and_against_motion() -> None:
    hand = HandGuide(straight_path(), HandGrip(stiffness=1000.0, damping=50.0))
    force, torque = hand.wrench(0.0, np.array([0.01, 0.0, -0.002]), LEVEL, AT_REST)
    np.testing.assert_allclose(force, [-10.0, 0.0, 2.0], atol=1e-9)
    np.testing.assert_allclose(torque, np.zeros(3), atol=1e-9)
    force, _ = hand.wrench(0.0, np.zeros(3), LEVEL, np.array([0.0, 0.1, 0.0, 0.0, 0.0, 0.0]))
    np.testing.assert_allclose(force, [0.0, -5.0, 0.0], atol=1e-9)


def test_the_torque_turns_the_tool_in_the_world_whatever_the_sign_of_the_quaternion() -> None:
    hand = HandGuide(straight_path(turn=0.0), HandGrip(rotational_stiffness=10.0))
    off = quaternion_from_rotation_vector([0.0, 0.08, 0.0])
    for sign in (1.0, -1.0):
        _, torque = hand.wrench(0.0, np.zeros(3), sign * off, AT_REST)
        np.testing.assert_allclose(torque, [0.0, -0.8, 0.0], atol=1e-9)


def test_force_and_torque_are_bounded() -> None:
    hand = HandGuide(straight_path())
    force, torque = hand.wrench(0.0, np.array([3.0, 4.0, 0.0]), np.array([1.0, 0.0, 0.0, 0.0]), AT_REST)
    np.testing.assert_allclose(force, [-18.0, -24.0, 0.0], atol=1e-9)
    assert np.linalg.norm(torque) == pytest.approx(3.0)


def test_the_hand_moves_as_its_path_does_and_rests_before_and_after() -> None:
    path = straight_path()
    hand = HandGuide(path)
    for time in (-1.0, 0.0, 0.3, 0.777, hand.duration, 5.0):
        for asked, expected in zip(hand.pose(time), path.at(time), strict=True):
            np.testing.assert_allclose(asked, expected, atol=1e-9)
    speed = [np.linalg.norm(hand.wrench(time, *hand.pose(time), AT_REST)[0]) for time in (-1.0, 0.5, 5.0)]
    assert speed[0] == pytest.approx(0.0, abs=1e-3)
    assert speed[1] == pytest.approx(80.0 * 0.1 * 1.875, rel=1e-3)
    assert speed[2] == pytest.approx(0.0, abs=1e-3)


def test_letting_go_fades_and_can_be_taken_back() -> None:
    hand = HandGuide(straight_path())
    hand.let_go(0.5, fade=0.2)
    assert [hand.strength(time) for time in (0.4, 0.5, 0.71, 0.9)] == [1.0, 1.0, 0.0, 0.0]
    assert hand.strength(0.6) == pytest.approx(0.5)
    force, torque = hand.wrench(1.0, np.ones(3), LEVEL, AT_REST)
    assert not force.any()
    assert not torque.any()
    hand.hold()
    assert hand.strength(1.0) == 1.0
    hand.let_go(0.5)
    assert hand.strength(0.5) == 0.0


def test_a_hand_that_has_no_path_is_refused() -> None:
    class Lost:
        duration = 1.0

        def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return np.full((len(time), 3), np.nan), np.tile(LEVEL, (len(time), 1))

    with pytest.raises(SimulationError, match=r"must be positive; got 0.0 s"):
        HandGuide(straight_path(), step=0.0)
    with pytest.raises(SimulationError, match="path of a hand must be finite"):
        HandGuide(Lost())


@pytest.mark.slow
@pytest.mark.parametrize("arm", ["right", "left"])
@pytest.mark.parametrize("label", ["reach", "put_on_table", "move_left", "go_home"])
def test_the_hand_leads_each_arm_within_ten_millimeters_and_fifteen_newtons(world: World, arm: str, label: str) -> None:
    """There and back in 2 s each way, from the middle of the starts, in a drawn scene, with teaching's damping."""
    task, scene = world.task_for(arm), world.draw_scene(3, arm)
    start = nominal_setting(task, label, {}).start
    model = world.arm(arm)
    found = solve_inverse_kinematics(model, world.base.inverse() @ start, model.configuration("work"))
    world.reset(scene, {arm: found.configuration})
    there = resolve_waypoints(task, label, scene, start)
    durations = there.durations * 2.0 / there.durations.sum()
    path = human_path(
        np.vstack([there.positions, there.positions[-2::-1]]),
        np.vstack([there.quaternions, there.quaternions[-2::-1]]),
        np.append(durations, durations[::-1]),
        np.random.default_rng(0),
        STEADY,
    )
    hand = HandGuide(path)
    errors, forces = [], []
    for step in range(round(path.duration / world.physics_step)):
        q, v = world.state(arm)
        world.command(arm, model.gravity(q) - model.counterbalance(q) - 0.5 * v)
        time, tool = step * world.physics_step, world.tool_motion(arm)
        force, torque = hand.wrench(time, *tool)
        world.push(arm, force, torque)
        errors.append(np.linalg.norm(hand.pose(time)[0] - tool[0]))
        forces.append(np.linalg.norm(force))
        world.step()
    assert np.sqrt(np.mean(np.square(errors))) < 0.010
    assert max(forces) < 15.0
    for name in scene:
        assert np.linalg.norm(world.scene[name].position - scene[name].position) < 1e-3, f"{name} was touched"
