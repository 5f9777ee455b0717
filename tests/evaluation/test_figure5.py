"""Figure 5: what stands on its page, and that a collapsed motion is seen as one."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.evaluation.figure5 import LearnedMotion, figure5, thinned, write_figure5
from pft_exec.evaluation.lessons import Lesson


def trial(lesson: Lesson, number: int) -> Demonstration:
    """A straight way to the bottle or of a fixed length, from somewhere."""
    rng = np.random.default_rng([lesson.seed, number, sum(lesson.label.encode())])
    start, half = np.array([0.5, -0.3, 1.0]) + rng.uniform(-0.1, 0.1, 3), rng.uniform(-1.0, 1.0)
    bottle = np.array([*rng.uniform(-0.1, 0.1, 3), 0.0, 0.0, np.sin(half), np.cos(half)])
    end = bottle[:3] + np.array([0.6, 0.0, 0.8]) if lesson.label == "reach" else start + np.array([0.0, 0.2, 0.0])
    u = np.linspace(0.0, 1.0, 150)
    path = start + np.outer(10 * u**3 - 15 * u**4 + 6 * u**5, end - start) + rng.normal(0.0, 5e-4, (150, 3))
    quaternion = np.tile([0.0, 0.0, 0.0, 1.0], (150, 1))
    return Demonstration(lesson.label, 2.0 * u, path, quaternion, objects={"bottle": bottle})


@pytest.fixture
def motions(monkeypatch: pytest.MonkeyPatch) -> list[LearnedMotion]:
    monkeypatch.setattr(Lesson, "teach", lambda lesson: [trial(lesson, number) for number in range(lesson.count)])
    return figure5("tabletop")


def test_a_thinned_demonstration_keeps_its_ends_and_has_the_asked_samples() -> None:
    whole = trial(Lesson("pr2", "tabletop", "reach", 0), 0)
    thin = thinned(whole, 100)
    assert len(thin) == 100
    assert np.array_equal(thin.position[[0, -1]], whole.position[[0, -1]])
    assert len(thinned(whole, 500)) == len(whole)


def test_both_methods_learn_from_the_same_and_are_drawn_where_a_person_is_seen(motions: list[LearnedMotion]) -> None:
    reach = motions[0]
    assert len(reach.demonstrations) == 5
    assert set(reach.tubes) == {"robust", "dong2012"}
    assert not any(np.array_equal(reach.shown.position, item.position) for item in reach.demonstrations)
    for tube in reach.tubes.values():
        assert np.linalg.norm(tube.end.position - reach.shown.end.position) < 0.01
    assert reach.found["robust"]["end.position"] == "bottle"
    assert reach.size("robust") == pytest.approx(1.0, abs=0.05)


def test_relations_are_counted_and_their_objects_named(motions: list[LearnedMotion]) -> None:
    reach = motions[0]
    found = {"robust": reach.meant, "dong2012": {**reach.meant, "start.position": "table"}}
    changed = LearnedMotion(**{**vars(reach), "found": found})
    assert (changed.right("robust"), changed.right("dong2012")) == ("4 of 4", "3 of 4")
    assert changed.objects == {"bottle"}, "what is no placed object of the scene has no place in the picture"


def test_a_collapsed_motion_is_small(motions: list[LearnedMotion]) -> None:
    still = motions[0].tubes["robust"]
    middle = still.position.mean(axis=0)
    small = type(still)(
        still.label, still.time, middle + 0.01 * (still.position - middle), still.quaternion, still.covariance
    )
    collapsed = LearnedMotion(**{**vars(motions[0]), "tubes": {"robust": small}})
    assert collapsed.size("robust") < 0.05


def test_the_page_has_every_motion_its_numbers_and_the_paper_s_words(
    motions: list[LearnedMotion], tmp_path: Path
) -> None:
    text = write_figure5(motions, tmp_path).read_text(encoding="utf-8")
    assert all(f"<h2>{item.label.replace('_', ' ')}</h2>" in text for item in motions)
    assert text.count("data:image/png") == len(motions)
    assert text.count("in the paper in 0.9 to 1.3 s") == len(motions)
    assert "the displacement varied too much to be found relevant" in text
    assert "spread" in text
    json.dumps([item.to_dict() for item in motions])
