"""Objects handled on the way: the tube goes to where they stand now, and nothing else is asked for."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.exceptions import MissingObjectError
from pft_exec.geometry import Array, Pose
from pft_exec.learning import learn_motion
from tests.learning.taught import scaled

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
SHELF = np.append([0.9, 0.5, 0.6], LEVEL)
RAISED = np.array([0.0, 0.0, 0.1])
STATION = np.array([0.5, 0.0, 0.1])


def _way(points: Array, samples: int) -> tuple[Array, Array]:
    """A path (N, 3) that rests at each point, and which piece (N,) each sample lies on."""
    s = np.linspace(0.0, 1.0, samples)
    eased = (10 * s**3 - 15 * s**4 + 6 * s**5)[:, None]
    pieces = [one + eased * (other - one) for one, other in pairwise(points)]
    path: Array = np.concatenate(pieces)
    return path, np.repeat(np.arange(len(pieces)), samples)


def carrying(rng: np.random.Generator, at_station: bool = False) -> Demonstration:
    """To the ball (or a fixed place), close, over to the bin, open; a block lies about and a shelf stands still."""
    start, ball = rng.uniform([0.3, -0.4, 0.3], [0.5, 0.4, 0.5]), rng.uniform([0.4, -0.4, 0.1], [0.8, 0.4, 0.1])
    basket, block = rng.uniform([0.3, -0.6, 0.0], [0.5, 0.6, 0.0]), rng.uniform([0.3, -0.5, 0.0], [0.8, 0.5, 0.1])
    grasp = (STATION if at_station else ball) + rng.normal(0.0, 0.002, 3)
    drop = basket + rng.normal([0.0, 0.0, 0.2], 0.002)
    position, piece = _way(np.stack([start, grasp, drop, drop + RAISED]), int(rng.integers(50, 70)))
    tracked = np.tile(np.append(ball, LEVEL), (len(position), 1))
    if not at_station:
        tracked[piece == 1, :3] = position[piece == 1]
        tracked[piece == 2, :3] = drop
    return Demonstration(
        "carry",
        np.linspace(0.0, 0.02 * (len(position) - 1), len(position)),
        position,
        discrete={"gripper_closed": (piece == 1).astype(int)},
        objects={"ball": tracked, "bin": np.append(basket, LEVEL), "block": np.append(block, LEVEL), "shelf": SHELF},
    )


def _lesson(count: int, seed: int = 0, at_station: bool = False) -> tuple[list[Demonstration], Demonstration]:
    rng = np.random.default_rng(seed)
    return [carrying(rng, at_station) for _ in range(count)], carrying(rng, at_station)


def _where_it_closes(demonstrations: list[Demonstration], scene: Scene, start: Pose) -> Array:
    tube = learn_motion(demonstrations).flow_tube(scene, start)
    closing = next(event for event in tube.events() if event.value == 1)
    return tube.at(closing.phase).position


@pytest.mark.parametrize("count", [3, 5, 8])
@pytest.mark.parametrize("seed", range(3))
def test_the_gripper_closes_where_the_ball_lies_now(count: int, seed: int) -> None:
    demonstrations, new = _lesson(count, seed)
    closes = _where_it_closes(demonstrations, new.scene, new.start)
    assert np.linalg.norm(closes - new.scene["ball"].position) < 0.01


def test_an_object_grasped_on_the_way_is_asked_for_and_no_other_is() -> None:
    demonstrations, new = _lesson(5)
    motion = learn_motion(demonstrations)
    objects = dict(new.scene.objects)
    needed = Scene({name: objects[name] for name in ("ball", "bin")})
    assert motion.flow_tube(needed, new.start).events()
    with pytest.raises(MissingObjectError, match="ball"):
        motion.flow_tube(Scene({"bin": objects["bin"]}), new.start)


def test_where_the_gripper_always_closed_at_one_place_that_place_holds_it_and_no_distant_object() -> None:
    demonstrations, new = _lesson(5, at_station=True)
    alone = Scene({"bin": new.scene["bin"]})
    closes = _where_it_closes(demonstrations, alone, new.start)
    assert np.linalg.norm(closes - STATION) < 0.01


def test_a_change_of_units_changes_no_handled_object() -> None:
    demonstrations, new = _lesson(5)
    larger = scaled(new, 1000.0)
    closes = _where_it_closes([scaled(d, 1000.0) for d in demonstrations], larger.scene, larger.start)
    expected = _where_it_closes(demonstrations, new.scene, new.start)
    np.testing.assert_allclose(closes, 1000.0 * expected, rtol=1e-6)
