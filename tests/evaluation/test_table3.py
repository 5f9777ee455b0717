"""Table 3: what is compared, and how recordings are prepared for it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.description import load_task
from pft_exec.evaluation import table3 as subject
from pft_exec.evaluation.lessons import Lesson
from pft_exec.evaluation.table3 import CONDITIONS, MOTIONS, PUBLISHED, centered, table3, with_bystanders


def trial(lesson: Lesson, number: int) -> Demonstration:
    """A line in a direction of its own for each motion, from somewhere, with the objects of its own task."""
    rng = np.random.default_rng([lesson.seed, number, sum(lesson.label.encode())])
    direction = np.eye(3)[list(MOTIONS).index(lesson.label) % 3] * (-1.0) ** (list(MOTIONS).index(lesson.label) // 3)
    u = np.linspace(0.0, 1.0, 40)
    path = rng.uniform(-0.02, 0.02, 3) + np.outer(0.3 * (10 * u**3 - 15 * u**4 + 6 * u**5), direction)
    objects = {name: np.array([*rng.uniform(0.4, 0.6, 3), 0, 0, 0, 1.0]) for name in load_task(lesson.task).placed}
    return Demonstration(lesson.label, 3.0 * u, path + rng.normal(0.0, 5e-4, (40, 3)), objects=objects)


@pytest.fixture
def lines(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Lesson, "teach", lambda lesson: [trial(lesson, number) for number in range(lesson.count)])


def test_every_motion_is_one_of_its_task_and_of_the_paper() -> None:
    assert set(MOTIONS) == set(PUBLISHED)
    assert all(label in load_task(task).labels for label, task in MOTIONS.items())


def test_published_figures_are_those_of_the_paper() -> None:
    """[Dong2012]_: 50 of 50, and a mean share of 91 %."""
    assert sum(row[0] for row in PUBLISHED.values()) == 50
    assert np.mean([row[1] for row in PUBLISHED.values()]) == pytest.approx(90.6, abs=0.05)


def test_a_centered_recording_begins_at_the_origin_and_has_no_objects() -> None:
    before = trial(Lesson("wam", "cable", "wind", 0), 0).segment(5, 30)
    after = centered(before)
    assert np.array_equal(after.position[0], np.zeros(3))
    assert after.time[0] == 0.0
    assert np.allclose(after.position - after.position[0], before.position - before.position[0])
    assert not after.objects


def test_every_task_s_objects_are_in_a_varied_scene_and_its_own_stay() -> None:
    before = trial(Lesson("wam", "cable", "wind", 0), 0)
    after, again, other = with_bystanders(before, 0, 0), with_bystanders(before, 0, 0), with_bystanders(before, 0, 1)
    assert set(after.objects) == {name for task in MOTIONS.values() for name in load_task(task).placed}
    assert np.array_equal(after.objects["post"], before.objects["post"])
    assert np.array_equal(after.objects["ball"], again.objects["ball"])
    assert not np.array_equal(after.objects["ball"], other.objects["ball"])


@pytest.mark.usefixtures("lines")
def test_each_half_is_tested_by_the_other(tmp_path: Path) -> None:
    """Ten trials of five motions, two ways: 50 tests a seed; lines in five directions are told apart."""
    results = table3(seeds=1, folder=tmp_path)
    assert [result.condition for result in results] == list(CONDITIONS)
    for result in results:
        assert set(result.summaries) == set(subject.METHODS)
        row = result.table()[0]
        assert row["recognized at the end"] == "50 of 50"
        motions = result.by_motion("robust, phase")
        assert [item["motion"] for item in motions] == list(MOTIONS)
        assert all(item[f"as {item['motion']}"] == 10 for item in motions)
        json.dumps(result.to_dict())
    assert results[0].table()[-1]["method"] == "published"
    assert len(list(tmp_path.iterdir())) == 10
