"""States recorded while running make, in another world, the pictures that the running world would have made."""

from __future__ import annotations

import numpy as np

from pft_exec.description import TaskDescription
from pft_exec.model import RobotModel
from pft_exec.simulation import World, render_states
from tests.simulation.runs import disturbed_run, near_bottle

SIZE = (160, 120)


def test_replayed_pictures_are_those_of_the_run(robot: RobotModel, task: TaskDescription) -> None:
    states, pictures = [], []
    with World(robot, task, seed=3) as world:
        world.reset(near_bottle(world))
        for _ in range(3):
            disturbed_run(world, 100)
            states.append(world.record_state())
            pictures.append(world.camera.frame(SIZE))
    assert [state.time for state in states] == [0.1, 0.2, 0.3]
    with World(robot, task, seed=8) as elsewhere:
        for replayed, picture in zip(render_states(elsewhere, states, SIZE), pictures, strict=True):
            differing = (np.abs(replayed.astype(int) - picture).max(axis=-1) > 8).mean()
            assert differing < 1e-3
        np.testing.assert_allclose(elsewhere.record_state().joints, states[-1].joints, atol=1e-12)
        np.testing.assert_allclose(elsewhere.record_state().objects, states[-1].objects, atol=1e-6)
