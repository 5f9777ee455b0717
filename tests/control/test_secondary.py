"""Secondary aims: the gradient is exact, the wide directions and the null space give way, the narrow ones do not."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control import TrackingController, compute_compliance, holding
from pft_exec.control.compliance import LEVER
from pft_exec.control.secondary import MARGIN, _dexterity_gradient, room_for, secondary_acceleration
from pft_exec.learning.flow_tube import FlowTube
from tests.control.plant import Plant

LEVERS = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])


def dexterity(arm, q):
    return np.linalg.svd(LEVERS[:, None] * arm.jacobian(q))[1][-1]


@pytest.mark.parametrize("seed", range(3))
def test_gradient_of_the_smallest_singular_value_is_that_of_finite_differences(arm, start, seed):
    q = start + np.random.default_rng(seed).normal(0.0, 0.3, 7)
    value, gradient = _dexterity_gradient(np.ascontiguousarray(arm.jacobian(q)), LEVERS)
    assert value == pytest.approx(dexterity(arm, q))
    step = 1e-6
    measured = [(dexterity(arm, q + step * e) - dexterity(arm, q - step * e)) / (2 * step) for e in np.eye(7)]
    np.testing.assert_allclose(gradient, measured, atol=1e-6)


def test_nothing_is_asked_for_in_the_middle_of_the_workspace(arm, start):
    assert not secondary_acceleration(arm.limits, start, arm.jacobian(start)).any()


def test_each_limit_pushes_away_from_itself(arm, start):
    for joint in (1, 3):
        for limit, sign in ((arm.limits.lower, 1.0), (arm.limits.upper, -1.0)):
            q = np.array(start)
            q[joint] = limit[joint] + sign * 0.2 * MARGIN
            acceleration = secondary_acceleration(arm.limits, q, arm.jacobian(start))
            assert sign * acceleration[joint] > 0.5


def test_there_is_room_in_the_wide_directions_only():
    weight = np.diag([1.0, 0.01, 1.0, *(3 * [LEVER**2])])
    np.testing.assert_allclose(room_for(np.ones(6), weight), [0.0, 0.9801, 0.0, 0.0, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("across", [0.05, 0.003])
def test_a_wide_tube_is_used_to_leave_a_joint_limit_and_a_narrow_one_is_kept(arm, start, across):
    """The elbow at 0.03 rad from its limit: the tool steps aside along y as far as the tube allows."""
    near = np.array(start)
    near[3] = arm.limits.upper[3] - 0.03
    pose = arm.forward(near)
    deviation = np.array([0.003, across, 0.003, 0.02, 0.02, 0.02])
    tube = FlowTube(
        "rest", [0.0, 1.0], [pose.position] * 2, [pose.quaternion] * 2, np.tile(np.diag(deviation**2), (2, 1, 1))
    )
    frictionless = arm.with_payload(0.0)
    frictionless.friction = type(arm.friction)(np.zeros(7), np.zeros(7))
    controller, plant = TrackingController(frictionless, 0.002), Plant(frictionless, near)
    controller.follow(holding(near), compute_compliance(tube), 0.0, blend=False)
    for step in range(1000):
        command = controller.update(0.002 * step, plant.q, plant.v)
        for _ in range(2):
            plant.step(command.torque)
    moved = np.abs(arm.forward(plant.q).position - pose.position)
    assert moved[1] <= across
    assert moved[[0, 2]].max() <= 0.002
    gained = plant.q[3] - near[3]
    if across > 0.01:
        assert moved[1] >= 0.003
        assert gained <= -0.005
    else:
        assert moved[1] <= 0.002
