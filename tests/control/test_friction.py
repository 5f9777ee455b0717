"""Friction feed-forward: odd in the velocity, smooth at zero, Coulomb and viscous away from it."""

from __future__ import annotations

import numpy as np

from pft_exec.control.friction import friction_torque
from pft_exec.model import JointFriction

FRICTION = JointFriction(np.array([0.5, 0.2]), np.array([0.3, 0.1]))


def test_fast_joint_feels_coulomb_and_viscous_friction():
    np.testing.assert_allclose(friction_torque(FRICTION, np.array([1.0, -1.0])), [0.8, -0.3], rtol=1e-9)


def test_torque_is_odd_and_zero_at_rest():
    v = np.array([0.003, 0.4])
    np.testing.assert_allclose(friction_torque(FRICTION, -v), -friction_torque(FRICTION, v))
    np.testing.assert_array_equal(friction_torque(FRICTION, np.zeros(2)), 0.0)
