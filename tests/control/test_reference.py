"""References: joining two, and holding still."""

from __future__ import annotations

import numpy as np

from pft_exec.control import JointReference, holding, joined


def test_joined_reference_switches_once_and_keeps_the_phase_of_the_second():
    first = lambda t: (np.full(2, t), np.ones(2), np.zeros(2))  # noqa: E731
    then = lambda t: JointReference(np.full(2, 10.0 + t), np.zeros(2), np.zeros(2), 0.1 * t)  # noqa: E731
    reference = joined(first, 0.5, then)
    np.testing.assert_array_equal(reference(0.4).configuration, 0.4)
    assert reference(0.4).phase == 0.1 * 0.4
    np.testing.assert_array_equal(reference(0.5).configuration, 10.5)


def test_holding_stays():
    still = holding(np.array([1.0, 2.0]))(7.0)
    np.testing.assert_array_equal(still.configuration, [1.0, 2.0])
    np.testing.assert_array_equal(still.velocity, 0.0)
    np.testing.assert_array_equal(still.acceleration, 0.0)
