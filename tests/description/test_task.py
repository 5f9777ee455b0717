"""Tasks: what task.toml says is what comes out, and what is wrong in it is named."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from pft_exec.description import MotionDescription, TaskDescription, load_task
from pft_exec.exceptions import DescriptionError, UnknownMotionError, UnknownTaskError
from pft_exec.geometry import Pose


@pytest.fixture(scope="module")
def task() -> TaskDescription:
    return load_task("tabletop")


@pytest.fixture
def copy(task: TaskDescription, tmp_path: Path) -> Path:
    """A task of the user's own, to be spoilt."""
    return Path(shutil.copy(task.folder / "task.toml", tmp_path))


def _spoil(path: Path, old: str, new: str) -> Path:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return path


def test_the_labels_stand_in_the_order_of_the_file(task: TaskDescription) -> None:
    assert task.labels == ("reach", "put_on_table", "move_left", "go_home")
    assert all(isinstance(task.motion(label), MotionDescription) for label in task.labels)


def test_a_scene_holds_what_is_placed_and_no_furniture(task: TaskDescription) -> None:
    assert "table" in task.objects
    assert task.placed == ("bottle", "mat", "cup")


def test_relations_are_the_truth_by_motion_variable(task: TaskDescription) -> None:
    assert task.relations("put_on_table") == {
        "start.position": "none",
        "start.orientation": "none",
        "end.position": "mat",
        "end.orientation": "mat",
    }


def test_a_task_loads_from_its_name_folder_and_file_alike(task: TaskDescription, copy: Path) -> None:
    assert load_task(copy).motions == dict(task.motions)
    assert load_task(copy.parent).labels == task.labels


def test_an_unknown_task_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(UnknownTaskError, match="Did you mean 'tabletop'"):
        load_task("tabeltop")


def test_an_unknown_motion_is_refused_with_the_nearest_name(task: TaskDescription) -> None:
    with pytest.raises(UnknownMotionError, match=r"no motion is named 'reech'\. Did you mean 'reach'") as caught:
        task.motion("reech")
    assert caught.value.choices == task.labels


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("mass = 0.4", "wieght = 0.4", r"objects\.bottle\.wieght: unknown key"),
        ("friction = 1.0", "frictoin = 1.0", r"Did you mean 'friction'"),
        ('frame = "bottle"', 'frame = "botle"', r"waypoints\[0\]\.position\.frame: .*Did you mean 'bottle'"),
        ('frame = "mat"', 'frame = "table"', r"nothing is named 'table'"),
        ('on = "table"', 'on = "bottle"', r"objects\.bottle\.placement\.on: nothing is named 'bottle'"),
        ('position = "bottle", orientation', 'position = "bottel", orientation', r"relations\.end\.position.*'bottle'"),
        ("[objects.cup]", "[objects.start]", r"objects\.start: that word has a meaning of its own"),
        ("x = [0.55, 0.67]", "x = [0.67, 0.55]", r"x must go from the least to the greatest"),
        ("radius = 0.03", "radius = 0.0", r"must be above 0"),
        ("mass = 0.4\n", "", r"mass of an object that is placed must be above 0"),
        ('kind = "cylinder"', 'kind = "cone"', r"'cone' is not a choice"),
        ("duration = 2.4", "duration = -2.4", r"duration and dwell must be above 0"),
    ],
)
def test_a_mistake_is_named_with_its_key(copy: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(DescriptionError, match=message) as caught:
        load_task(_spoil(copy, old, new))
    assert str(copy) in str(caught.value)


def test_an_object_is_either_fixed_or_placed(copy: Path) -> None:
    with pytest.raises(DescriptionError, match=r"either fixed \(a pose\) or has a placement"):
        load_task(_spoil(copy, 'symmetry = "z"', "fixed = { position = [0.6, 0.0, 0.8] }"))


def test_a_motion_needs_a_waypoint(copy: Path) -> None:
    text = copy.read_text(encoding="utf-8")
    head, tail = text.split("[motions.go_home]")
    begin, end = tail.index("waypoints"), tail.index("relations")
    copy.write_text(f"{head}[motions.go_home]{tail[:begin]}waypoints = []\n{tail[end:]}", encoding="utf-8")
    with pytest.raises(DescriptionError, match="at least one waypoint"):
        load_task(copy)


def test_a_task_mirrored_twice_is_the_task(task: TaskDescription) -> None:
    mirrored = task.mirrored()
    assert mirrored.mirror == task.robot_base
    assert mirrored.mirrored() == task
    assert task.mirrored(Pose(np.array([0.0, 0.1, 0.0]))).mirror != mirrored.mirror


def test_symmetric_objects_are_named(task: TaskDescription) -> None:
    assert task.symmetric == {"bottle", "cup"}
