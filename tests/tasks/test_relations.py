"""What the motions of every task relate to is found in what a person shows: the paths of hands, without a robot."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.demonstration.synthetic import human_path
from pft_exec.description import Setting, TaskDescription, draw_settings, load_task, random_stream, resolve_waypoints
from pft_exec.evaluation.measurements import found_relations
from pft_exec.geometry import Array, Pose
from pft_exec.learning import Motion, learn_motion

MOTIONS = [(task, label) for task in ("bottle", "cable", "ball_bin") for label in load_task(task).labels]


def _path(task: TaskDescription, label: str, setting: Setting, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Time, position and orientation of a person's hand in the last motion of a chain."""
    start = setting.start
    for part in task.chain(label):
        ways = resolve_waypoints(task, part, Scene(setting.objects), start)
        path = human_path(
            ways.positions,
            ways.quaternions,
            ways.durations,
            rng,
            rests=ways.rests,
            curve=ways.curve,
            curve_duration=ways.curve_duration,
        )
        time, position, quaternion = path.sample(0.02)
        start = Pose(position[-1], quaternion[-1])
    return time, position, quaternion


def _demonstration(task: TaskDescription, label: str, setting: Setting, rng: np.random.Generator) -> Demonstration:
    time, position, quaternion = _path(task, label, setting, rng)
    objects = {name: pose.array for name, pose in setting.objects.items()}
    held = [task.motion(part).holds for part in task.chain(label)]
    for holds in (each for each in held if each is not None):
        objects[holds.object] = np.array(
            [(Pose(p, q) @ holds.grip).array for p, q in zip(position, quaternion, strict=True)]
        )
    return Demonstration(label, time, position, quaternion, objects=objects)


def _shown(task: TaskDescription, label: str) -> Motion:
    settings = draw_settings(task, label, 5, random_stream(0, "teach", label, "tests"))
    hands = [random_stream(number, "teach", label, "hand") for number in range(5)]
    return learn_motion([_demonstration(task, label, *each) for each in zip(settings, hands, strict=True)])


@pytest.mark.parametrize(("name", "label"), MOTIONS)
def test_what_a_motion_relates_to_is_found_in_what_a_person_shows(name: str, label: str) -> None:
    task = load_task(name)
    assert found_relations({label: _shown(task, label)}, label) == task.relations(label)


@pytest.mark.parametrize("label", load_task("anchor").labels)
def test_posts_that_never_turn_are_found_but_not_whether_a_motion_would_turn_with_them(label: str) -> None:
    task = load_task("anchor")
    relations, variables = task.relations(label), _shown(task, label).variables
    for when in ("start", "end"):
        decision = getattr(variables, when).position
        assert decision.frame == relations[f"{when}.position"] == "anchors"
        assert decision.ambiguous
