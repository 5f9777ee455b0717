"""Motions that hold something, follow one another or have placements of their own."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from pft_exec.description import (
    Setting,
    draw_scene,
    draw_settings,
    load_task,
    nominal_setting,
    path_is_free,
    random_stream,
    resolve_waypoints,
)
from pft_exec.description.nearest import nearest_setting, told_placement
from pft_exec.exceptions import DescriptionError
from pft_exec.geometry import Pose

TASK = load_task("bottle")


def _drawn(label: str, mirrored: bool = False) -> list[Setting]:
    task = TASK.mirrored() if mirrored else TASK
    return draw_settings(task, label, 5, random_stream(0, "evaluate", label))


def test_a_chain_holds_what_comes_before() -> None:
    assert TASK.chain("pour_done") == ("pour_into", "pour_done")
    assert TASK.chain("reach") == ("reach",)


@pytest.mark.parametrize("mirrored", [False, True])
def test_what_is_held_is_in_the_gripper(mirrored: bool) -> None:
    grip = TASK.motion("shake").holds.grip
    for setting in _drawn("shake", mirrored):
        plane = TASK.robot_base
        start, bottle = setting.start, setting.objects["bottle"]
        if mirrored:
            start, bottle = start.mirrored(plane), bottle.mirrored(plane)
        assert np.allclose((start @ grip).array, bottle.array)


def test_a_start_relative_to_an_object_is_at_the_object() -> None:
    for setting in _drawn("up_and_over"):
        assert np.allclose(setting.start.position - setting.objects["bottle"].position, [0.0, 0.0, 0.03])
        assert setting.objects["bottle"].position[2] == pytest.approx(0.79)


def test_a_motion_that_follows_is_drawn_as_the_first_of_its_chain() -> None:
    low, high = TASK.start_of("pour_into").z
    assert all(low <= setting.start.position[2] <= high for setting in _drawn("pour_done"))
    nominal = nominal_setting(TASK, "pour_done", draw_scene(TASK, np.random.default_rng(0)))
    assert nominal.start.position[2] == pytest.approx(0.5 * (low + high))


def test_placements_of_a_motion_replace_those_of_the_objects() -> None:
    for setting in _drawn("stir"):
        assert 0.06 <= setting.objects["bottle"].position[1] <= 0.14


def test_the_aim_of_a_waypoint_is_brought_to_its_position() -> None:
    setting = _drawn("pour_into")[0]
    end = resolve_waypoints(TASK, "pour_into", setting.objects, setting.start).end
    lip = end.apply(np.array([0.0, 0.0, 0.11]))
    assert np.allclose(lip - setting.objects["cup"].position, [0.0326, -0.0127, 0.09])


def test_a_hand_may_touch_what_it_takes_only_on_the_last_piece() -> None:
    setting = _drawn("reach")[0]
    assert path_is_free(TASK, "reach", setting)
    above = Pose(setting.objects["bottle"].position + np.array([0.0, 0.0, 0.05]), setting.start.quaternion)
    assert not path_is_free(TASK, "reach", Setting(setting.objects, above))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'follows = "pour_into"',
            'follows = "pour_in"',
            r"follows: nothing is named 'pour_in'.*'pour_into'",
        ),
        ('follows = "pour_into"', 'follows = "pour_done"', r"pour_done follows pour_done"),
        ('liquid = "bottle"', 'liquid = "botle"', r"liquid: nothing is named 'botle'"),
        ('touches = ["bottle"]', 'touches = ["botle"]', r"touches: nothing is named 'botle'"),
        ('gripper = "close"', 'gripper = "shut"', r"'shut' is not a choice"),
        ('kind = "swing"', 'kind = "swings"', r"Did you mean 'swing'"),
        ('into = "cup"', 'into = "mug"', r"success: nothing is named 'mug'"),
    ],
)
def test_a_mistake_is_named_with_its_key(tmp_path: Path, old: str, new: str, message: str) -> None:
    copy = Path(shutil.copy(TASK.folder / "task.toml", tmp_path))
    text = copy.read_text(encoding="utf-8")
    assert old in text
    copy.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(DescriptionError, match=message):
        load_task(copy)


def test_the_nearest_setting_lies_at_the_border_of_what_is_feasible() -> None:
    setting = _drawn("reach")[0]
    far = dict(setting.objects) | {"bottle": Pose(setting.objects["bottle"].position + np.array([0.4, 0.0, 0.0]))}

    def feasible(tried: Setting) -> bool:
        return bool(tried.objects["bottle"].position[0] <= 0.7)

    asked = Setting(far, setting.start)
    nearest = nearest_setting(TASK, "reach", asked, feasible)
    assert nearest is not None
    assert 0.69 <= nearest.objects["bottle"].position[0] <= 0.7
    assert "bottle at (0.69" in told_placement(TASK, "reach", asked, nearest)
    assert nearest_setting(TASK, "reach", asked, lambda _: False) is None
    assert "Not even the middle" in told_placement(TASK, "reach", asked, None)
