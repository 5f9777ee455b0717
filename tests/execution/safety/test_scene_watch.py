"""The scene watch: what somebody else moved counts once it stays, what the tool moves or a camera loses does not."""

from __future__ import annotations

import numpy as np

from pft_exec.demonstration import Scene
from pft_exec.execution.safety.scene_watch import SceneWatch
from pft_exec.geometry import Pose

HERE, THERE, FAR = Pose((0.5, 0.0, 0.7)), Pose((0.6, 0.1, 0.7)), Pose((0.0, 0.0, 1.0))


def changes(watch, seen, tool=FAR, duration=0.5):
    """Times at which the watch wants tubes anew, seeing `seen(time)`."""
    times = np.arange(0.0, duration, 0.01)
    return [time for time in times if watch.update(time, seen(time), tool) is not None]


def test_a_moved_object_counts_once_it_has_stayed_and_only_once():
    watch = SceneWatch(Scene({"box": HERE}))
    times = changes(watch, lambda _: Scene({"box": THERE}))
    assert len(times) == 1
    assert 0.15 <= times[0] <= 0.25
    np.testing.assert_array_equal(watch.scene["box"].position, THERE.position)


def test_a_jump_for_a_moment_noise_and_a_lost_object_do_not_count():
    watch = SceneWatch(Scene({"box": HERE}))
    assert not changes(watch, lambda t: Scene({"box": THERE if t < 0.1 else HERE}))
    assert not changes(watch, lambda t: Scene({"box": Pose(HERE.position + 0.003 * np.sin(50.0 * t))}))
    assert not changes(watch, lambda _: Scene({}))


def test_what_the_tool_moves_belongs_to_the_motion_even_after_it_was_let_go():
    watch = SceneWatch(Scene({"box": HERE}))
    carried = Pose(HERE.position + 0.02)
    watch.update(0.0, Scene({"box": carried}), tool=Pose(carried.position + 0.05))
    assert not changes(watch, lambda _: Scene({"box": THERE}), tool=FAR)
