"""The drive of coupled fingers: bounded force, equal openings."""

from __future__ import annotations

import pytest

from pft_exec.simulation.gripper import GripperDrive


def test_the_force_is_bounded_and_equal_on_both_fingers() -> None:
    drive = GripperDrive(force=30.0)
    assert drive.forces(0.0, (0.03, 0.03), (0.0, 0.0)) == (-30.0, -30.0)
    assert drive.forces(0.08, (0.0, 0.0), (0.0, 0.0)) == (30.0, 30.0)


def test_the_coupling_pulls_unequal_fingers_together_without_closing_them() -> None:
    left, right = GripperDrive().forces(0.04, (0.021, 0.019), (0.0, 0.0))
    assert left == pytest.approx(-8.0)
    assert right == pytest.approx(8.0)


def test_motion_is_damped() -> None:
    left, right = GripperDrive().forces(0.04, (0.02, 0.02), (0.1, 0.1))
    assert left == right == pytest.approx(-4.0)
