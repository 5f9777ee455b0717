"""Pictures: robot and objects are seen before the floor, from either side; wrong requests are refused."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.exceptions import SimulationError, UnknownNameError
from pft_exec.simulation import VIEWS, World
from pft_exec.simulation.backdrop import compute_backdrop

SIZE = (160, 120)


def share_of(frame: np.ndarray, backdrop: np.ndarray) -> float:
    return float(np.mean((frame != backdrop).any(axis=-1)))


@pytest.mark.parametrize("view", sorted(VIEWS))
def test_a_picture_shows_robot_and_objects_before_the_backdrop(world: World, view: str) -> None:
    frame = world.camera.frame(SIZE, view)
    assert frame.shape == (120, 160, 3)
    assert frame.dtype == np.uint8
    seen = VIEWS[view]
    backdrop = compute_backdrop(np.array(seen.eye), np.array(seen.target), seen.field_of_view, SIZE)
    assert 0.2 < share_of(frame, backdrop) < 0.9
    red, green, blue = np.moveaxis(frame.astype(int), -1, 0)
    assert (green - np.maximum(red, blue) > 20).sum() > 10, "the green bottle"
    assert (blue - np.maximum(red, green) > 20).sum() > 10, "the blue cup"


def test_pictures_differ_when_the_arm_moved_and_repeat_when_not(world: World) -> None:
    before = world.camera.frame(SIZE)
    np.testing.assert_array_equal(world.camera.frame(SIZE), before)
    world.place("right", world.arm("right").configuration("home"))
    assert share_of(world.camera.frame(SIZE), before) > 0.005


def test_shadows_darken(world: World) -> None:
    assert world.camera.frame(SIZE, shadow=True).mean() < world.camera.frame(SIZE).mean()


def test_a_picture_that_cannot_be_made_is_refused(world: World) -> None:
    with pytest.raises(UnknownNameError, match=r"no view is named 'tabel'. Did you mean 'table'"):
        world.camera.frame(SIZE, "tabel")
    with pytest.raises(SimulationError, match=r"positive width and height in pixels; got \(0, 10\)"):
        world.camera.frame((0, 10))


def test_the_backdrop_has_tiles_below_and_sky_above() -> None:
    image = compute_backdrop(np.array([2.0, 0.0, 1.5]), np.array([0.0, 0.0, 1.2]), 60.0, (80, 60)).astype(int)
    assert np.ptp(image[:5].reshape(-1, 3), axis=0).max() <= 1
    assert np.ptp(image[-10:].reshape(-1, 3), axis=0).min() > 10
