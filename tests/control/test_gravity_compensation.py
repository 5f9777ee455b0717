"""Gravity compensation: holds still, damps, turns back at walls, and never exceeds a limit."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control import GravityCompensation
from pft_exec.control.gravity_compensation import FRICTION_SHARE, WALL_MARGIN, guiding_torque
from pft_exec.control.held_damping import STABLE_SHARE, held_damping
from pft_exec.model import load_robot
from pft_exec.model.limits import JointFriction
from tests.control.plant import Plant


@pytest.fixture
def floating(arm):
    return GravityCompensation(arm)


def test_arm_at_rest_stays_for_a_second(arm, start, floating):
    plant = Plant(arm, start, friction=0.0)
    for step in range(1000):
        plant.step(floating.update(0.001 * step, plant.q, plant.v).torque)
    np.testing.assert_allclose(plant.q, start, atol=1e-9)


def test_motion_dies_out(arm, start, floating):
    plant = Plant(arm, start, np.full(7, 0.2))
    energy = []
    for step in range(500):
        energy.append(plant.v @ arm.mass_matrix(plant.q) @ plant.v)
        plant.step(floating.update(0.001 * step, plant.q, plant.v).torque)
    assert energy[-1] < 0.7 * energy[0]
    assert (np.diff(energy) <= 1e-4 * energy[0]).all()


def test_wall_turns_a_pushed_joint_back_before_it_is_far_beyond_its_limit(arm, start, floating):
    q = np.array(start)
    q[1] = arm.limits.upper[1] - 0.06
    plant = Plant(arm, q, np.eye(7)[1] * 0.5)
    beyond = []
    for step in range(600):
        plant.step(floating.update(0.001 * step, plant.q, plant.v).torque)
        beyond.append(plant.q[1] - arm.limits.upper[1])
    assert max(beyond) <= 0.01
    assert beyond[-1] <= 0.0


def test_wall_is_silent_away_from_the_limits(arm, start, floating):
    expected = arm.gravity(start) - arm.counterbalance(start)
    assert arm.limits.margin(start).min() > WALL_MARGIN
    np.testing.assert_allclose(floating.update(0.0, start, np.zeros(7)).torque, expected, atol=1e-12)


def test_a_joint_that_is_not_seen_is_held_up_no_more(arm, start, floating):
    """A spring that answers to a state which is only believed would push, and nothing would end it."""
    q = np.array(start)
    q[4], q[5] = arm.limits.upper[4] - 0.01, arm.limits.upper[5] - 0.01
    unseen = np.arange(7) == 5
    expected = arm.gravity(q) - arm.counterbalance(q)
    torque = GravityCompensation(arm, damping=1.0).update(0.0, q, np.eye(7)[5], unseen=unseen).torque
    np.testing.assert_allclose(np.delete(torque, 4), np.delete(expected, 4), atol=1e-12)
    assert torque[4] < expected[4] - 0.1


def test_torque_never_exceeds_its_limit(arm, floating):
    generator = np.random.default_rng(0)
    for _ in range(300):
        q = generator.uniform(-3.0, 3.0, 7)
        command = floating.update(0.0, q, generator.normal(0.0, 50.0, 7))
        assert (np.abs(command.torque) <= arm.limits.torque).all()
        assert command.torque_active.any() == (np.abs(command.torque) >= arm.limits.torque).any()


@pytest.mark.parametrize("spoiled", ["configuration", "velocity"])
def test_a_measurement_that_is_not_finite_holds_the_last_good_configuration(arm, start, floating, spoiled):
    before = floating.update(0.0, start, np.zeros(7))
    q, v = start.copy(), np.zeros(7)
    (q if spoiled == "configuration" else v)[3] = np.nan
    after = floating.update(0.001, q, v)
    np.testing.assert_array_equal(after.torque, before.torque)
    assert f"{spoiled} not finite" in after.status


def test_payload_is_carried_where_the_arm_knows_it(arm, start):
    loaded = arm.with_payload(0.5)
    plant = Plant(loaded, start, friction=0.0)
    controller = GravityCompensation(loaded)
    for step in range(300):
        plant.step(controller.update(0.001 * step, plant.q, plant.v).torque)
    np.testing.assert_allclose(plant.q, start, atol=1e-9)


def test_what_helps_the_hand_never_gives_more_than_friction_takes(arm, start):
    """Passive: with the joints' own friction, power flows out of the motion at every velocity."""
    generator = np.random.default_rng(1)
    dynamics = arm.dynamics(start, np.zeros(7))
    for _ in range(300):
        v = generator.normal(0.0, 1.0, 7) * 10.0 ** generator.uniform(-4.0, 0.0)
        power = v @ guiding_torque(arm.friction, v, dynamics, 0.001)
        assert power < np.abs(v) @ arm.friction.coulomb
        assert power <= FRICTION_SHARE * np.abs(v) @ arm.friction.coulomb


def test_the_motion_that_leaves_the_tool_where_it_is_is_damped_most(arm, start):
    dynamics = arm.dynamics(start, np.zeros(7))
    swivel = np.linalg.svd(dynamics.jacobian)[2][6]
    still = guiding_torque(arm.friction, 0.0 * swivel, dynamics, 0.001)
    np.testing.assert_array_equal(still, np.zeros(7))
    assert swivel @ guiding_torque(arm.friction, swivel, dynamics, 0.001) < -1.0


def test_a_stop_is_damped_alone(arm, start):
    v = np.full(7, 0.1)
    stop = GravityCompensation(arm, 2.0)
    held = held_damping(arm.mass_matrix(start), 2.0 * np.eye(7), stop.period)
    expected = arm.gravity(start) - arm.counterbalance(start) - held @ v
    np.testing.assert_allclose(stop.update(0.0, start, v).torque, expected, atol=1e-12)


def test_a_payload_is_held_from_when_it_is_carried_on(arm, start):
    floating, still = GravityCompensation(arm), np.zeros(7)
    before = floating.update(0.0, start, still).torque
    heavy = arm.with_payload(0.5)
    floating.carry(heavy)
    weight = heavy.gravity(start) - arm.gravity(start)
    np.testing.assert_allclose(floating.update(0.0, start, still).torque - before, weight, atol=1e-9)


@pytest.mark.parametrize("period", [0.001, 0.002])
def test_the_damping_under_a_hand_is_no_more_than_the_lightest_joint_bears(period: float) -> None:
    """Held for a period, it takes at most its share of any speed away: more made a light wrist swing ever wider."""
    arm = load_robot("wam", tool="gripper").arm("arm")
    q = arm.configuration("work")
    dynamics = arm.dynamics(q, np.zeros(7))
    still = JointFriction(np.zeros(7), np.zeros(7))
    damped = np.stack([guiding_torque(still, v, dynamics, period) for v in np.eye(7)], axis=1)
    shares = np.linalg.eigvals(-period * np.linalg.solve(dynamics.mass_matrix, damped)).real
    assert shares.min() > 0.0
    assert shares.max() <= STABLE_SHARE + 1e-9
