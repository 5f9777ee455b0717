"""Lessons are taught once, kept, and never mixed up with those of other settings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from shutil import copytree

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.description import load_task
from pft_exec.evaluation import lessons
from pft_exec.evaluation.lessons import Lesson, give_lessons

LESSON = Lesson("pr2", "tabletop", "reach", seed=3, count=2)


def test_a_lesson_that_has_its_file_is_not_taught_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    time = np.arange(5) * 0.1
    taught: list[Lesson] = []

    def teach(lesson: Lesson) -> list[Demonstration]:
        taught.append(lesson)
        return [Demonstration(lesson.label, time, np.outer(time, np.ones(3))) for _ in range(lesson.count)]

    monkeypatch.setattr(Lesson, "teach", teach)
    other = replace(LESSON, seed=4)
    first = give_lessons([LESSON], tmp_path / "lessons")
    again = give_lessons([LESSON, other], tmp_path / "lessons")
    assert taught == [LESSON, other]
    assert np.array_equal(first[LESSON][1].position, again[LESSON][1].position)
    assert len(again[other]) == 2
    give_lessons([LESSON])
    assert taught == [LESSON, other, LESSON]


@pytest.mark.parametrize(
    "change", [{"seed": 4}, {"count": 3}, {"arm": "left"}, {"same_scene": True}, {"label": "go_home"}]
)
def test_another_lesson_has_another_file(change: dict[str, object]) -> None:
    assert replace(LESSON, **change).file_name != LESSON.file_name  # type: ignore[arg-type]


def test_a_changed_task_makes_other_lessons(tmp_path: Path) -> None:
    folder = tmp_path / "tabletop"
    copytree(load_task("tabletop").folder, folder)
    mine = replace(LESSON, task=str(folder))
    before = mine.file_name
    text = (folder / "task.toml").read_text(encoding="utf-8")
    (folder / "task.toml").write_text(text.replace("mass = 0.4", "mass = 0.5"), encoding="utf-8")
    assert mine.file_name != before


def test_another_version_teaches_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    before = LESSON.file_name
    monkeypatch.setattr(lessons, "__version__", "0.0.0")
    assert LESSON.file_name != before


@pytest.mark.slow
def test_lessons_in_one_scene_differ_only_in_the_start_and_the_person() -> None:
    first, second = replace(LESSON, same_scene=True).teach()
    assert all(np.allclose(first.scene[name].position, second.scene[name].position, atol=1e-3) for name in first.scene)
    assert np.linalg.norm(first.position[0] - second.position[0]) > 0.01
    one, other = LESSON.teach()
    assert np.linalg.norm(one.scene["bottle"].position - other.scene["bottle"].position) > 0.01
