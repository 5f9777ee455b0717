"""The study of a task goes on where it stopped, refuses what it cannot trust, and never sees a taught scene."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.description import draw_scene, load_task, random_stream
from pft_exec.evaluation import task_study
from pft_exec.evaluation.lessons import Lesson, Subject
from pft_exec.evaluation.task_report import figures, motion_rows, relevance_rows
from pft_exec.evaluation.task_rollouts import Rollout, RolloutResult, is_filmed, run_rollout
from pft_exec.evaluation.task_study import run_task_study
from pft_exec.exceptions import StorageError, UnknownArmError
from pft_exec.report.contact_sheet import GOOD

SETTINGS = Subject("pr2", "tabletop", seed=2)
ROLLOUT = Rollout("pr2", "tabletop", None, "reach", "right", "drawn", 3, 2)
FIGURES = {
    "end_position_error": 1e-3,
    "tube_rms": 5e-4,
    "tube_largest": 1e-3,
    "torque_share": 0.2,
    "torque_beyond": -1.0,
}


def trial(lesson: Lesson, number: int) -> Demonstration:
    """A straight way of 0.2 m from somewhere."""
    rng = np.random.default_rng([lesson.seed, number])
    u = np.linspace(0.0, 1.0, 60)
    path = rng.uniform(-0.1, 0.1, 3) + np.outer(10 * u**3 - 15 * u**4 + 6 * u**5, [0.0, 0.2, 0.0])
    return Demonstration(lesson.label, u, path, np.tile([0.0, 0.0, 0.0, 1.0], (60, 1)))


@pytest.fixture
def executed(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Lessons and rollouts that take no time; the names of those rolled out."""
    names: list[str] = []

    def roll(rollout: Rollout, library: Path, folder: Path, film: str) -> RolloutResult:
        from PIL import Image

        assert library.exists()
        names.append(rollout.name)
        Image.new("RGB", (8, 6), GOOD).save(folder / f"{rollout.name}.png")
        success = rollout.label != "go_home" or rollout.number == 0
        about = (rollout.label, rollout.arm, rollout.kind, rollout.number)
        result = RolloutResult(*about, success, False, "as it should" if success else "too far away", FIGURES)
        if is_filmed(film, result, rollout.name):
            (folder / f"{rollout.name}.mp4").touch()
        return result

    monkeypatch.setattr(Lesson, "teach", lambda lesson: [trial(lesson, number) for number in range(lesson.count)])
    monkeypatch.setattr(task_study, "run_rollout", roll)
    return names


def test_a_study_rolls_out_every_motion_on_every_arm_and_says_how_it_went(executed: list[str], tmp_path: Path) -> None:
    report = run_task_study(tmp_path / "study", SETTINGS, scenes=2, arms=["left", "right"], mirror_images=True)
    assert len(executed) == 4 * 2 * 3
    assert {name.split("_")[0] for name in executed} == {"left", "right"}
    assert executed[0].startswith("right")  # the arm that was taught; the other is compared with it
    rows = {(row["arm"], row["scenes"], row["motion"]): row for row in report["motions"]}
    assert rows["right", "drawn", "all"]["success"] == "7 of 8"
    assert rows["left", "mirrored", "go_home"]["success"] == "1 of 2"
    assert report["figures"]["right, drawn: worst motion (go_home)"]["value"] == pytest.approx(50.0)
    assert report["figures"]["left, drawn: points behind right"]["value"] == pytest.approx(0.0)
    assert [row["why"] for row in report["failures"]] == ["too far away"] * 3
    written = {path.name for path in (tmp_path / "study").iterdir()}
    assert {"report.json", "report.html", "ends_right.png", "ends_left.png", "library.h5", "settings.json"} <= written
    assert json.loads((tmp_path / "study" / "report.json").read_text()) == report


def test_a_finished_study_films_what_is_asked_for_later(executed: list[str], tmp_path: Path) -> None:
    run_task_study(tmp_path, SETTINGS, scenes=2, arms=["right"], film="none")
    for film, expected in (("right_drawn_reach_001", "right_drawn_reach_001"), ("failed", "right_drawn_go_home_001")):
        for wanted in ([expected], []):  # once, and not again
            executed.clear()
            run_task_study(tmp_path, SETTINGS, scenes=2, arms=["right"], film=film)
            assert executed == wanted
        assert (tmp_path / "rollouts" / f"{expected}.mp4").exists()


def test_an_interrupted_study_goes_on(executed: list[str], tmp_path: Path) -> None:
    run_task_study(tmp_path, SETTINGS, scenes=1, arms=["right"])
    (tmp_path / "rollouts" / "right_drawn_reach_000.json").unlink()
    executed.clear()
    run_task_study(tmp_path, SETTINGS, scenes=2, arms=["right"])
    again = [f"right_drawn_{label}_001" for label in load_task("tabletop").labels]
    assert sorted(executed) == sorted(["right_drawn_reach_000", *again])


@pytest.mark.usefixtures("executed")
def test_a_folder_of_other_settings_is_refused(tmp_path: Path) -> None:
    run_task_study(tmp_path, SETTINGS, scenes=1, arms=["right"])
    with pytest.raises(StorageError, match="seed was 2 and is 3"):
        run_task_study(tmp_path, replace(SETTINGS, seed=3), scenes=1)


@pytest.mark.usefixtures("executed")
def test_damaged_files_and_unknown_arms_are_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(UnknownArmError, match="middle"):
        run_task_study(tmp_path, SETTINGS, arms=["middle"])
    run_task_study(tmp_path, SETTINGS, scenes=1, arms=["right"])
    (tmp_path / "rollouts" / "right_drawn_reach_000.json").write_text('{"label": ')
    with pytest.raises(StorageError, match=r"right_drawn_reach_000\.json is damaged"):
        run_task_study(tmp_path, SETTINGS, scenes=1, arms=["right"])
    (tmp_path / "settings.json").write_text("[")
    with pytest.raises(StorageError, match=r"settings\.json is damaged"):
        run_task_study(tmp_path, SETTINGS, scenes=1, arms=["right"])


@pytest.mark.usefixtures("executed")
def test_variables_are_judged_over_seeds_that_were_asked_for(tmp_path: Path) -> None:
    """Straight ways of one length: only `move_left` is meant to be one."""
    report = run_task_study(tmp_path, SETTINGS, scenes=1, arms=["right"], relevance_seeds=2)
    rights = {row["motion"]: row["right"] for row in report["variables"]}
    assert rights["go_home"] == "0 of 2"
    assert report["figures"]["seeds with the variables of all 4 motions right"]["value"] == 0.0


def test_scenes_of_a_study_are_never_those_that_were_taught() -> None:
    """Whatever the seeds are: the streams have different purposes, and no number meets another's scene."""
    task = load_task("tabletop")
    seeds = [replace(ROLLOUT, number=number, seed=seed).scene_seed for number in range(20) for seed in range(20)]
    assert len(set(seeds)) == len(seeds)
    for seed in (ROLLOUT.scene_seed, ROLLOUT.seed):
        taught = draw_scene(task, random_stream(seed, "teach", "reach", "right", "placement"))
        shown = draw_scene(task, random_stream(seed, "evaluate", "setting", "reach", "right"))
        assert np.linalg.norm(taught["bottle"].position - shown["bottle"].position) > 1e-6


def test_what_could_not_be_measured_is_no_figure() -> None:
    refused = RolloutResult("reach", "right", "drawn", 0, False, True, "beyond reach", {})
    found = figures([refused], {"reach": [True, False]}, {"reach": 12.0})
    assert found["right, drawn: success"].value == 0.0
    assert not found["torque beyond its limit"].ok
    assert motion_rows([refused])[0]["refused"] == 1
    assert relevance_rows({"reach": [True, False]})[0]["right"] == "1 of 2"


def test_pours_and_slips_are_figures_where_a_task_has_them() -> None:
    results = [
        RolloutResult("pour_into", "right", "drawn", i, ok, False, "", {"poured": share, "slip": 1e-3})
        for i, (ok, share) in enumerate([(True, 1.0), (True, 0.9), (False, 0.1)])
    ]
    found = figures(results, {}, {})
    assert found["spheres in the cup, mean over successful pours"].value == pytest.approx(95.0)
    assert found["slip in the gripper, worst"].value == pytest.approx(1.0)


@pytest.mark.slow
def test_a_rollout_is_measured_pictured_and_filmed(tmp_path: Path) -> None:
    """One real rollout of a motion that was really taught, on the arm that was not."""
    lesson = Lesson("pr2", "tabletop", "move_left", seed=1, count=3)
    from pft_exec.learning import learn_library

    library = learn_library(lesson.teach())
    library.save(tmp_path / "library.h5")
    rollout = replace(ROLLOUT, label="move_left", arm="left", kind="mirrored")
    result = run_rollout(rollout, tmp_path / "library.h5", tmp_path, film="left_mirrored")
    assert result.success
    assert result.figures["tube_rms"] < 0.01
    assert result.figures["torque_beyond"] <= 1e-9
    assert (tmp_path / f"{rollout.name}.png").stat().st_size > 1000
    assert (tmp_path / f"{rollout.name}.mp4").stat().st_size > 1000
