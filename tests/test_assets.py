"""Where a robot or task is found: by its name, or by the folder or file of the user's own."""

from __future__ import annotations

from pathlib import Path
from shutil import copytree

import pytest

from pft_exec.assets import robot_file, task_file
from pft_exec.exceptions import UnknownRobotError, UnknownTaskError


@pytest.mark.parametrize("name", ["mine", "mine/", "./mine", "mine/robot.toml", "../here/mine"])
def test_a_folder_here_is_found_however_it_is_written(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = tmp_path / "here"
    copytree(robot_file("wam").parent, here / "mine")
    monkeypatch.chdir(here)
    assert robot_file(name) == here / "mine" / "robot.toml"
    assert robot_file(Path(name)) == here / "mine" / "robot.toml"


def test_a_name_that_ships_is_no_folder_that_happens_to_lie_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shipped = robot_file("wam")
    copytree(shipped.parent, tmp_path / "wam")
    monkeypatch.chdir(tmp_path)
    assert robot_file("wam") == shipped
    assert robot_file("./wam") == tmp_path / "wam" / "robot.toml"


def test_what_is_no_folder_of_a_description_is_refused_with_the_choices(tmp_path: Path) -> None:
    with pytest.raises(UnknownRobotError, match=r"Choices: 'pr2', 'wam'. A path to a folder with a robot.toml works"):
        robot_file(tmp_path)
    with pytest.raises(UnknownTaskError, match=r"'tabletop'. A path to a folder with a task.toml works"):
        task_file(tmp_path)
