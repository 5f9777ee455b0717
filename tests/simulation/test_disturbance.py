"""What is wrong with sensors, motors and load acts where it should, by as much as it says, and the same for a seed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.description import TaskDescription
from pft_exec.exceptions import SimulationError
from pft_exec.geometry import Pose
from pft_exec.model import RobotModel
from pft_exec.simulation import ORDINARY, Mismatch, World
from tests.simulation.runs import disturbed_run, float_arm, near_bottle


def test_without_a_mismatch_the_plant_is_what_it_was_bit_for_bit(robot: RobotModel, task: TaskDescription) -> None:
    digests = []
    for mismatch in (None, Mismatch()):
        with World(robot, task, seed=3, mismatch=mismatch) as world:
            world.reset(near_bottle(world))
            digests.append(disturbed_run(world))
    assert digests[0] == digests[1]


def test_the_seed_decides_the_noise(robot: RobotModel, task: TaskDescription) -> None:
    digests = []
    for seed in (1, 1, 2):
        with World(robot, task, seed=3, mismatch=replace(ORDINARY, seed=seed)) as world:
            world.reset(near_bottle(world))
            digests.append(disturbed_run(world, 50))
    assert digests[0] == digests[1] != digests[2]


def test_a_payload_has_the_weight_and_the_inertia_of_a_mass_at_the_tool(
    robot: RobotModel, task: TaskDescription
) -> None:
    """The plant with friction and payload wrong is the model with these numbers, to the torque."""
    rng = np.random.default_rng(0)
    aside = replace(task, robot_base=Pose([-1.5, 0.0, 0.0]))
    with World("wam", aside, World(robot, task).scene, mismatch=Mismatch(friction=1.2, payload=0.5)) as world:
        model = world.arm().with_payload(0.5)
        for _ in range(100):
            q, v = world.state()
            world.command("arm", model.gravity(q) + rng.normal(size=7) * 3.0)
            motor = world.torque()
            world.step()
            after = world.state()[1]
            plant = model.dynamics(q, v)
            driving = motor + model.counterbalance(q) - 1.2 * model.friction.viscous * v
            friction = driving - plant.bias - plant.mass_matrix @ (after - v) / world.physics_step
            moving = np.abs(after) > 1e-2
            full = 1.2 * model.friction.coulomb * np.sign(after)
            np.testing.assert_allclose(friction[moving], full[moving], rtol=0, atol=1e-6)


def test_a_payload_can_come_and_go_while_the_arm_floats(world: World) -> None:
    model = world.arm("right")
    float_arm(world, "right", 10)
    q = world.state("right")[0]
    world.disturb(Mismatch(payload=0.5))
    float_arm(world, "right", 200)
    sunk = world.state("right")[0]
    assert model.forward(sunk).position[2] < model.forward(q).position[2] - 0.01
    world.disturb(Mismatch())
    float_arm(world, "right", 500, damping=5.0)
    rest = world.state("right")[0]
    float_arm(world, "right", 100, damping=5.0)
    np.testing.assert_allclose(world.state("right")[0], rest, atol=1e-4)


def test_measured_joints_are_noisy_and_true_ones_are_not(robot: RobotModel, task: TaskDescription) -> None:
    with World(robot, task, mismatch=Mismatch(encoder_noise=1e-4, velocity_noise=3e-3)) as world:
        errors = []
        for _ in range(400):
            world.step()
            measured, true = world.state("right"), world.true_state("right")
            np.testing.assert_array_equal(measured[0], world.state("right")[0])  # the same instant, the same reading
            errors.append([measured[0] - true[0], measured[1] - true[1]])
        deviation = np.std(errors, axis=(0, 2))
        np.testing.assert_allclose(deviation, [1e-4, 3e-3], rtol=0.1)
        assert (np.abs(np.mean(errors, axis=(0, 2))) < [1e-5, 3e-4]).all()


@pytest.mark.parametrize("steps_per_period", [1, 2])
def test_a_delayed_torque_acts_that_many_control_periods_later(
    robot: RobotModel, task: TaskDescription, steps_per_period: int
) -> None:
    with World(robot, task, control_period=1e-3 * steps_per_period, mismatch=Mismatch(delay=2)) as world:
        model = world.arm("right")
        q = world.state("right")[0]
        push = np.zeros(7)
        push[0] = 0.5 * model.limits.torque[0]
        moved = []
        for _ in range(5):
            world.command("right", model.gravity(q) - model.counterbalance(q) + push)
            for _ in range(steps_per_period):
                world.step()
            moved.append(abs(world.state("right")[1][0]) > 1e-3)
        assert moved == [False, False, True, True, True]


def test_a_weak_motor_delivers_its_share(robot: RobotModel, task: TaskDescription) -> None:
    with World(robot, task, mismatch=Mismatch(strength=0.3)) as world:
        limit = world.arm("right").limits.torque
        world.command("right", limit)
        np.testing.assert_allclose(world.torque("right"), 0.3 * limit)


def test_torque_ripple_grows_with_the_torque_and_turns_with_the_joint() -> None:
    from pft_exec.simulation.disturbance import Disturbance

    ripple = Disturbance(Mismatch(torque_ripple=0.02), 7, 1)
    torque = np.full(7, 10.0)
    seen = np.array([ripple.delivered("arm", slice(0, 7), torque, np.full(7, q)) for q in np.linspace(0.0, 1.0, 500)])
    np.testing.assert_allclose(seen.max(axis=0), 10.2, atol=0.01)
    np.testing.assert_allclose(seen.min(axis=0), 9.8, atol=0.01)
    np.testing.assert_array_equal(ripple.delivered("arm", slice(0, 7), 0.0 * torque, torque), np.zeros(7))


def test_encoders_report_what_they_are_told_to_and_the_arm_stays_where_it_is(world: World) -> None:
    q = world.state("right")[0]
    world.set_encoder("right", lambda q, v: (q + 0.1, v))
    np.testing.assert_allclose(world.state("right")[0], q + 0.1)
    np.testing.assert_array_equal(world.true_state("right")[0], q)
    hand_feels, seen = world.tool_motion("right")[0], world.tool("right").position
    assert np.linalg.norm(hand_feels - seen) > 0.01
    world.set_encoder("right", None)
    np.testing.assert_array_equal(world.state("right")[0], q)


@pytest.mark.parametrize("wrong", [{"friction": -1.0}, {"payload": np.nan}, {"strength": 1.5}, {"delay": -1}])
def test_an_impossible_mismatch_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(SimulationError):
        Mismatch(**wrong)
