"""Surroundings: objects of a scene become obstacles where they are, with the velocity they have, and are kept off."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.exceptions import MissingObjectError
from pft_exec.execution.surroundings import Surroundings
from pft_exec.simulation import World


@pytest.fixture
def world():
    with World("pr2", "tabletop", control_period=0.002) as world:
        yield world


def test_an_unknown_object_is_refused(world):
    with pytest.raises(MissingObjectError):
        Surroundings(world, "right", ["no such thing"])


def test_objects_stand_where_the_scene_says_and_the_other_arm_is_one_of_them(world):
    name = world.task.placed[0]
    seen = {obstacle.name: obstacle for obstacle in Surroundings(world, "right", [name]).look()}
    np.testing.assert_allclose(seen[name].pose.position, world.scene[name].position, atol=1e-9)
    assert not seen[name].velocity.any()
    assert len(seen) == 1 + len(world.arm("left").geometry.links)


def test_what_moves_has_its_velocity(world):
    """The other arm is let go and falls."""
    surroundings = Surroundings(world, "right", [])
    surroundings.look()
    assert not surroundings.is_due
    for _ in range(100):
        world.command("left", np.zeros(7))
        world.step()
    assert surroundings.is_due
    assert max(np.abs(obstacle.velocity).max() for obstacle in surroundings.look()) > 0.01
