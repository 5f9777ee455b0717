"""Recorded world states and their replay: a simulation need not wait for the renderer.

While it runs, a world is asked for its state 20 to 25 times a second (`World.record_state`, some microseconds);
pictures are made from the states later, in another world or another process.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pft_exec.geometry import Array
from pft_exec.simulation.view import View

if TYPE_CHECKING:
    from pft_exec.simulation.world import World


@dataclass(frozen=True, eq=False)
class WorldState:
    """Joints and objects at one instant.

    Parameters
    ----------
    time : float, s
    joints : (J,), rad or m
        Every moving joint of the robot, in the order of its body.
    objects : (M, 7)
        Position, m, and quaternion (x, y, z, w) of the task's placed objects, world frame.
    liquid : (S, 3), m, world frame
        Balls of the liquid; (0, 3) where there is none.
    """

    time: float
    joints: Array
    objects: Array
    liquid: Array = field(default_factory=lambda: np.zeros((0, 3)))


def render_states(
    world: World, states: Iterable[WorldState], size: tuple[int, int] = (640, 480), view: str | View = "room"
) -> Iterator[NDArray[np.uint8]]:
    """Pictures (h, w, 3) of recorded states, made in a world of the same robot and task that is not being stepped."""
    for state in states:
        world.show_state(state)
        yield world.camera.frame(size, view)
