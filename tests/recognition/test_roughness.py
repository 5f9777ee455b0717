"""How rough demonstrations are, and the window of the direction that follows from it."""

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.recognition.evidence import window_share
from pft_exec.recognition.motion_clock import ClockScales
from pft_exec.recognition.roughness import measure_noise, roughness
from pft_exec.recognition.settings import DEFAULT_SETTINGS
from tests.recognition.tubes import star


def _paths(noise, seed=0, count=5, samples=120, unit=1.0):
    """Smooth turns at an uneven rate, and noise of one deviation an axis."""
    rng = np.random.default_rng(seed)
    time = np.sort(rng.uniform(0.0, 2.0, (count, samples)), axis=1)
    places = np.stack([np.cos(time), np.sin(1.5 * time), np.zeros_like(time)], axis=-1)
    places[..., :2] += noise * rng.standard_normal((count, samples, 2))
    return time, unit * places


@pytest.mark.parametrize("noise", [0.001, 0.004, 0.016])
def test_roughness_is_the_length_of_the_noise_whatever_the_path_and_the_rate(noise):
    """The median length of planar noise is 1.18 deviations; the turns of the path add nothing that matters."""
    time, places = _paths(noise)
    assert roughness(time, places) == pytest.approx(1.18 * noise, rel=0.15)


def test_a_smooth_path_is_not_rough_and_units_do_not_matter():
    """A path without noise has next to none; in millimetres it has a thousand times as much."""
    assert roughness(*_paths(0.0)) < 1e-4
    time, places = _paths(0.002)
    assert roughness(time, 1e3 * places) == pytest.approx(1e3 * roughness(time, places))


def test_places_at_the_same_time_and_short_paths_are_left_out():
    """Repeated samples, as an alignment makes them, are no noise; three places tell nothing."""
    time, places = _paths(0.002)
    again = roughness(np.repeat(time, 2, axis=1), np.repeat(places, 2, axis=1))
    assert np.isfinite(again)
    assert again == 0.0
    assert roughness(time[:, :3], places[:, :3]) == 0.0
    held = np.concatenate([time, time[:, -1:]], axis=1), np.concatenate([places, places[:, -1:]], axis=1)
    assert roughness(*held) == pytest.approx(roughness(time, places))


def test_tubes_without_demonstrations_are_not_rough():
    """Nothing is known of their noise."""
    assert measure_noise([replace(tube, aligned=None) for tube in star()]) == 0.0


def test_the_window_grows_as_the_square_root_of_the_noise_and_never_falls_below_its_least():
    """Four times the noise takes twice the window; clean recordings have the shortest."""
    scales = [ClockScales(1.0, 1.0, {}, 2.0, noise) for noise in (0.0, 0.002, 0.008, 9.0)]
    windows = [window_share(item, DEFAULT_SETTINGS) for item in scales]
    assert windows[0] == DEFAULT_SETTINGS.window
    assert windows[2] == pytest.approx(2.0 * windows[1])
    assert windows[1] > windows[0]
    assert windows[3] == 0.1
