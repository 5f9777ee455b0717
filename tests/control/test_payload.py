"""The payload of a lift: mass and center as they were, with friction that is wrong and encoders that are noisy."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control import TrackingController, constant_compliance, estimate_payload, plan_joint_trajectory
from pft_exec.exceptions import ControlError
from pft_exec.learning.flow_tube import FlowTube
from tests.control.plant import Plant


def lift(arm, start, *, mass, center=(0.0, 0.0, 0.0), friction=1.0, noise=0.0):
    """Time, configuration, velocity and torque of a lift by 15 cm in 1.5 s with a turn of the tool by 0.5 rad."""
    pose = arm.forward(start)
    s = np.linspace(0.0, 1.0, 40)
    position = pose.position + np.outer(0.15 * (3 * s**2 - 2 * s**3), [0.0, 0.0, 1.0])
    tube = FlowTube("lift", 1.5 * s, position, np.tile(pose.quaternion, (40, 1)), np.tile(1e-4 * np.eye(6), (40, 1, 1)))
    trajectory = plan_joint_trajectory(arm, tube, start)
    controller = TrackingController(arm, 0.002)
    controller.follow(trajectory.at, constant_compliance(200.0), 0.0, blend=False)
    plant, generator = Plant(arm, start, friction=friction), np.random.default_rng(0)
    plant.arm = arm.with_payload(mass, center)
    rows = []
    for step in range(800):
        q, v = plant.q + noise * generator.normal(size=7), plant.v + 30.0 * noise * generator.normal(size=7)
        command = controller.update(0.002 * step, q, v)
        rows.append((0.002 * step, q, v, command.torque))
        for _ in range(2):
            plant.step(command.torque)
    return [np.array(column) for column in zip(*rows, strict=True)]


@pytest.mark.parametrize(("friction", "noise", "tolerance"), [(1.0, 0.0, 0.02), (1.2, 0.0, 0.06), (0.8, 1e-4, 0.08)])
def test_half_a_kilogram_is_weighed(arm, start, friction, noise, tolerance):
    found = estimate_payload(arm, *lift(arm, start, mass=0.5, friction=friction, noise=noise))
    assert found.mass == pytest.approx(0.5, abs=tolerance)


def test_an_empty_hand_weighs_nothing(arm, start):
    found = estimate_payload(arm, *lift(arm, start, mass=0.0))
    assert abs(found.mass) <= 0.03
    assert np.linalg.norm(found.center) <= 0.1


def test_the_center_is_found_where_it_shows(arm, start):
    """6 cm ahead of the tool."""
    found = estimate_payload(arm, *lift(arm, start, mass=1.0, center=(0.06, 0.0, 0.0)))
    assert found.mass == pytest.approx(1.0, abs=0.05)
    assert found.center[0] == pytest.approx(0.06, abs=0.03)


def test_the_arm_with_the_estimate_explains_the_lift(arm, start):
    recording = lift(arm, start, mass=0.7)
    found = estimate_payload(arm, *recording)
    assert abs(estimate_payload(arm.with_payload(found.mass, found.center), *recording).mass) <= 0.01
    assert found.residual <= 0.3


def test_a_recording_that_is_no_lift_is_refused(arm, start):
    with pytest.raises(ControlError, match="at least 20 samples of 7 joints"):
        estimate_payload(arm, np.arange(5.0), *([np.zeros((5, 7))] * 3))
    with pytest.raises(ControlError, match="finite"):
        estimate_payload(arm, np.arange(30.0), np.full((30, 7), np.nan), *([np.zeros((30, 7))] * 2))
