"""The simulated plant: torque limits, springs, friction, brakes, fingers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.description import TaskDescription
from pft_exec.exceptions import SimulationError
from pft_exec.geometry import Pose
from pft_exec.model import RobotModel, load_robot
from pft_exec.simulation import SetUp, World
from tests.simulation.runs import float_arm


def test_gravity_compensation_holds_each_arm(world: World) -> None:
    for arm in world.robot.arms:
        world.reset(configurations={arm: world.arm(arm).configuration("teach")})
        before = world.state(arm)[0]
        float_arm(world, arm, 1000, damping=0.0)
        assert np.abs(world.state(arm)[0] - before).max() < 1e-5


def test_the_springs_carry_the_arm_apart_from_the_motors(world: World) -> None:
    """Stretched out, gravity exceeds the limit of the shoulder motor; yet the arm floats, with little of the motor."""
    world.reset(configurations={"right": world.arm("right").configuration("parked")})
    model = world.arm("right")
    stretched = model.configuration("parked").copy()
    stretched[1], stretched[3] = 0.0, -0.2
    world.place("right", stretched)
    assert np.abs(model.gravity(stretched)).max() > model.limits.torque[1]
    float_arm(world, "right", 300)
    assert np.abs(world.state("right")[0] - stretched).max() < 1e-4
    assert np.abs(world.torque("right")).max() < 0.2 * model.limits.torque[1]


def test_torque_is_clipped_at_the_limits(world: World) -> None:
    """A command far beyond the limits acts as one at the limits."""
    limit = world.arm("right").limits.torque
    world.command("right", 100.0 * limit)
    np.testing.assert_array_equal(world.torque("right"), limit)
    world.step()
    beyond = world.state("right")
    world.reset()
    world.command("right", limit)
    world.step()
    np.testing.assert_array_equal(world.state("right")[1], beyond[1])


def test_a_command_lasts_until_it_is_replaced(world: World) -> None:
    model = world.arm("right")
    q = world.state("right")[0]
    world.command("right", model.gravity(q) - model.counterbalance(q))
    for _ in range(300):
        world.step()
    assert np.abs(world.state("right")[0] - q).max() < 1e-6


def test_the_plant_is_the_model(robot: RobotModel, task: TaskDescription) -> None:
    """M dv + bias = motor + springs - viscous v + J^T F - Coulomb; a moving joint has all of its Coulomb friction.

    With the bare arm of the WAM, since the fingers of the PR2 give way a little.
    """
    rng = np.random.default_rng(0)
    aside = replace(task, robot_base=Pose([-1.5, 0.0, 0.0]))
    with World("wam", aside, World(robot, task).scene) as world:
        model = world.arm()
        for _ in range(100):
            q, v = world.state()
            wrench = rng.normal(size=6) * [5.0, 5.0, 5.0, 0.3, 0.3, 0.3]
            world.command("arm", model.gravity(q) + rng.normal(size=7) * 3.0)
            world.push("arm", wrench[:3], wrench[3:])
            motor = world.torque()
            world.step()
            after = world.state()[1]
            plant = model.dynamics(q, v)
            driving = motor + model.counterbalance(q) + plant.jacobian.T @ wrench - model.friction.viscous * v
            friction = driving - plant.bias - plant.mass_matrix @ (after - v) / world.physics_step
            moving = np.abs(after) > 1e-2
            full = model.friction.coulomb * np.sign(after)
            np.testing.assert_allclose(friction[moving], full[moving], rtol=0, atol=1e-6)
            assert (np.abs(friction) <= model.friction.coulomb + 1e-6).all()


def test_dry_friction_holds_against_a_small_torque_and_yields_to_a_larger(world: World) -> None:
    model = world.arm("right")
    for share, moves in ((0.9, False), (1.5, True)):
        world.reset()
        q = world.state("right")[0]
        extra = np.zeros(7)
        extra[0] = share * model.friction.coulomb[0]
        world.command("right", model.gravity(q) - model.counterbalance(q) + extra)
        for _ in range(100):
            world.step()
        assert (abs(world.state("right")[0][0] - q[0]) > 1e-4) == moves


def test_an_arm_is_braked_until_it_is_commanded_and_again_when_asked(world: World) -> None:
    left = world.state("left")[0]
    assert world.is_braked("left")
    world.push("left", [0.0, 0.0, -30.0])
    float_arm(world, "right", 200)
    assert not world.is_braked("right")
    assert np.abs(world.state("left")[0] - left).max() < 1e-4
    np.testing.assert_array_equal(world.torque("left"), np.zeros(7))
    world.brake("right")
    q = world.state("right")[0]
    for _ in range(200):
        world.step()
    assert np.abs(world.state("right")[0] - q).max() < 1e-4


def test_motors_brake_a_moving_arm_within_their_limits_and_a_command_ends_it(world: World) -> None:
    model, extra = world.arm("right"), np.zeros(7)
    extra[3] = 3.0

    def held() -> np.ndarray:
        q, _ = world.state("right")
        return model.gravity(q) - model.counterbalance(q)

    for _ in range(100):
        world.command("right", held() + extra)
        world.step()
    world.command("right", held())
    speeds = [np.abs(world.state("right")[1]).max()]
    assert speeds[0] > 0.2
    world.brake("right", by_motors=True)
    assert world.is_braked("right")
    for _ in range(300):
        world.step()
        speeds.append(np.abs(world.state("right")[1]).max())
        assert (np.abs(world.torque("right")) <= model.limits.torque * (1.0 + 1e-9)).all()
    assert max(speeds) <= speeds[0] + 1e-3, "friction drives nothing"
    assert speeds[-1] < 5e-3
    world.command("right", held() + 2.0 * extra)
    assert not world.is_braked("right")
    for _ in range(100):
        world.step()
    assert np.abs(world.state("right")[1]).max() > 0.1


def test_motors_do_not_brake_what_is_parked(world: World) -> None:
    world.brake("left", by_motors=True)
    np.testing.assert_array_equal(world.torque("left"), np.zeros(7))


def test_fingers_open_and_close_evenly_at_bounded_speed(world: World) -> None:
    assert world.gripper("right") == pytest.approx(0.0, abs=1e-9)
    world.set_gripper("right", 0.08)
    float_arm(world, "right", 200)
    assert 0.02 < world.gripper("right") < 0.05
    float_arm(world, "right", 600)
    assert world.gripper("right") == pytest.approx(0.08, abs=1e-3)
    left_finger, right_finger = world.record_state().joints[16:18]
    assert left_finger + right_finger == pytest.approx(world.gripper("right"), abs=1e-9)
    assert abs(left_finger - right_finger) < 1e-3


def test_a_width_that_the_gripper_cannot_take_is_refused(world: World) -> None:
    with pytest.raises(SimulationError, match=r"opens from 0.0 to 0.086 m; got 0.2 m"):
        world.set_gripper("right", 0.2)


def test_an_arm_without_gripper_says_so(world: World) -> None:
    with World("wam", world.task, world.scene) as bare:
        assert bare.gripper() == 0.0
        with pytest.raises(SimulationError, match="arm 'arm' of robot 'wam' has no gripper"):
            bare.set_gripper("arm", 0.0)
        for set_up in (SetUp(opened=("arm",)), SetUp(holding={"arm": "bottle"})):
            with pytest.raises(SimulationError, match="arm 'arm' of robot 'wam' has no gripper"):
                bare.reset(set_up=set_up)


def test_a_robot_that_cannot_be_loaded_is_refused(task: TaskDescription, world: World) -> None:
    robot = load_robot("pr2")
    robot.description = replace(robot.description, urdf=robot.description.folder / "missing.urdf")
    with pytest.raises(SimulationError, match=r"loading .*missing\.urdf failed"):
        World(robot, task, world.scene)


def test_a_urdf_without_the_arms_joints_is_refused(task: TaskDescription, world: World) -> None:
    robot = load_robot("pr2")
    robot.description = replace(robot.description, urdf=load_robot("wam").description.urdf)
    with pytest.raises(SimulationError, match="no moving joint named"):
        World(robot, task, world.scene)
