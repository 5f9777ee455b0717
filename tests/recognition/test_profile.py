import numpy as np
import pytest

from pft_exec.recognition.profile import GRID, from_grid, on_grid, smoothed


@pytest.mark.parametrize("count", [2, 50, 300])
def test_a_straight_profile_comes_back_from_the_grid(count):
    """What is linear over phase is kept exactly, whatever the number of steps."""
    profile = np.linspace(1.0, 3.0, count)
    np.testing.assert_allclose(from_grid(on_grid(profile), count), profile, rtol=1e-12)


def test_smoothing_keeps_the_level_and_lessens_the_noise():
    """A constant stays; the variance of white noise falls by the width of the average."""
    np.testing.assert_allclose(smoothed(np.full(GRID, 2.0)), 2.0, rtol=1e-12)
    noise = np.random.default_rng(0).normal(size=GRID)
    assert smoothed(noise).std() < 0.7 * noise.std()
