"""Held damping: symmetric, never more than what it stands for, and it never gives energy to a motion."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control.held_damping import STABLE_SHARE, held_damping


def _positive(generator: np.random.Generator, size: int, rank: int) -> np.ndarray:
    """A random symmetric matrix of some rank, its eigenvalues over six orders of magnitude."""
    basis = np.linalg.qr(generator.standard_normal((size, size)))[0][:, :rank]
    return (basis * 10.0 ** generator.uniform(-4.0, 2.0, rank)) @ basis.T


@pytest.mark.parametrize("seed", range(200))
def test_damping_never_gives_energy_to_a_motion(seed: int) -> None:
    """For random inertia, damping and period: from any speed, a period of held damping leads to less energy."""
    generator = np.random.default_rng(seed)
    size = int(generator.integers(1, 8))
    mass, damping = _positive(generator, size, size), _positive(generator, size, int(generator.integers(1, size + 1)))
    period = 10.0 ** generator.uniform(-5.0, 0.0)
    held = held_damping(mass, damping, period)
    np.testing.assert_allclose(held, held.T, rtol=1e-6, atol=1e-6 * np.abs(held).max())
    for _ in range(20):
        v = generator.standard_normal(size)
        after = v - period * np.linalg.solve(mass, held @ v)
        gained = after @ mass @ after - v @ mass @ v
        assert gained <= -2.0 * (1.0 - 0.5 * STABLE_SHARE) * period * v @ held @ v + 1e-9 * v @ mass @ v


@pytest.mark.parametrize("seed", range(20))
def test_with_a_period_of_delay_it_still_brings_to_rest(seed: int) -> None:
    """Of a speed measured a period ago: no swing grows, also where the damping is far too much for the inertia."""
    generator = np.random.default_rng(seed)
    mass, damping = _positive(generator, 7, 7), 1e3 * _positive(generator, 7, 7)
    step = 0.002 * np.linalg.solve(mass, held_damping(mass, damping, 0.002))
    roots = np.linalg.eigvals(np.block([[np.eye(7), -step], [np.eye(7), np.zeros((7, 7))]]))
    assert np.abs(roots).max() <= 1.0 + 1e-9
    assert np.abs(roots.imag).max() <= 1e-3


def test_for_short_periods_it_is_the_damping_itself() -> None:
    generator = np.random.default_rng(0)
    mass, damping = np.eye(7) + _positive(generator, 7, 7), _positive(generator, 7, 3)
    np.testing.assert_allclose(held_damping(mass, damping, 1e-9), damping, rtol=1e-4, atol=1e-6)
