"""The command line: help with examples, JSON, one clear line and status 2 for a mistake."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pft_exec import cli
from pft_exec.demonstration import Demonstration, load_demonstrations, save_demonstrations
from pft_exec.demonstration.hdf5 import write_file

COMMANDS = (
    "assist",
    "benchmark",
    "check",
    "convert",
    "demo",
    "evaluate",
    "execute",
    "learn",
    "recognize",
    "reproduce",
    "show",
    "teach",
)


def demonstrate(label: str, seed: int) -> Demonstration:
    """`up` ends 0.3 m above its start, `left` 0.3 m to its left, wherever it starts."""
    rng = np.random.default_rng(seed)
    u = np.linspace(0.0, 1.0, 40)
    displacement = np.array([0.0, 0.0, 0.3] if label == "up" else [0.0, 0.3, 0.0]) + rng.normal(0.0, 0.002, 3)
    path = rng.uniform(-0.1, 0.1, 3) + np.outer(3 * u**2 - 2 * u**3, displacement)
    return Demonstration(label, u, path + np.outer(np.sin(np.pi * u), rng.normal(0.0, 0.01, 3)))


@pytest.fixture
def taught(tmp_path: Path) -> Path:
    save_demonstrations(tmp_path / "taught.h5", [demonstrate(x, seed) for x in ("up", "left") for seed in range(6)])
    return tmp_path / "taught.h5"


@pytest.fixture
def library(taught: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    path = taught.with_name("library.h5")
    assert cli.run(["learn", str(taught), str(path), "--count", "4", "--held-out", str(path.with_name("rest.h5"))]) == 0
    capsys.readouterr()
    return path


def mistake(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """The one line that a mistake is answered with; it comes with status 2, on standard error, without a traceback."""
    assert cli.run([str(argument) for argument in arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("pft-exec: ")
    assert len(err.splitlines()) == 1
    return err


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_helps_and_shows_an_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run([command, "--help"]) == 0
    text = capsys.readouterr().out
    assert f"Example: pft-exec {command}" in text
    assert "--json" in text


def test_there_is_no_other_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run([]) == 0
    listed = capsys.readouterr().out.split("Commands")[1]
    assert all(f"│ {name} " in listed for name in COMMANDS)
    registered = {command.callback.__name__ for command in cli.app.registered_commands if command.callback}
    assert registered == set(COMMANDS)


def test_the_version_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["--version"]) == 0
    assert capsys.readouterr().out.strip().count(".") == 2


def test_a_misspelt_command_or_option_gets_the_nearest_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert "Did you mean 'learn'?" in mistake(capsys, "lern")
    assert "--count" in mistake(capsys, "learn", "a.h5", "b.h5", "--cont", "3")


def test_missing_or_impossible_arguments_are_mistakes(capsys: pytest.CaptureFixture[str]) -> None:
    assert "demonstrations" in mistake(capsys, "learn")
    assert "--count" in mistake(capsys, "learn", "a.h5", "b.h5", "--count", "1")
    assert "--seed" in mistake(capsys, "demo", "--seed", "-1")


def test_a_missing_file_is_a_mistake(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    for arguments in (
        ["learn", tmp_path / "none.h5", tmp_path / "out.h5"],
        ["recognize", tmp_path / "none.h5", tmp_path / "none.h5"],
        ["execute", tmp_path / "none.h5", "reach"],
        ["assist", tmp_path / "none.h5", "reach"],
        ["show", tmp_path / "none.h5"],
    ):
        assert "there is no file" in mistake(capsys, *arguments)


def test_a_foreign_file_is_a_mistake(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    write_file(tmp_path / "a.h5", {"x": 1}, "somebody's numbers", 1)
    assert "somebody's numbers" in mistake(capsys, "show", tmp_path / "a.h5")
    assert "foreign" in mistake(capsys, "learn", tmp_path / "a.h5", tmp_path / "b.h5")
    (tmp_path / "a.txt").write_text("hello")
    assert "converted from .npz or .csv" in mistake(capsys, "convert", tmp_path / "a.txt", tmp_path / "b.h5")


def test_an_output_folder_that_does_not_exist_is_a_mistake(
    capsys: pytest.CaptureFixture[str], taught: Path, tmp_path: Path
) -> None:
    assert "does not exist" in mistake(capsys, "learn", taught, tmp_path / "nowhere" / "library.h5")
    assert "does not exist" in mistake(capsys, "show", taught, "--plot", tmp_path / "nowhere" / "a.png")
    (tmp_path / "file").write_text("")
    assert "file" in mistake(capsys, "demo", "--out", tmp_path / "file" / "demo")


def test_an_unknown_name_gets_the_nearest_one(capsys: pytest.CaptureFixture[str], taught: Path, library: Path) -> None:
    assert "Did you mean 'robust'?" in mistake(capsys, "learn", taught, library, "--method", "robst")
    assert "Did you mean 'phase'?" in mistake(capsys, "recognize", library, taught, "--method", "phases")
    assert "Did you mean 'left'?" in mistake(capsys, "execute", library, "lft")
    assert "Did you mean 'left'?" in mistake(capsys, "assist", library, "lft")
    assert "Did you mean 'tabletop'?" in mistake(capsys, "teach", "a.h5", "--task", "tabeltop")
    assert "Did you mean 'reach'?" in mistake(capsys, "teach", "a.h5", "--motion", "raech")
    assert "Did you mean 'robot'?" in mistake(capsys, "check", "robt", "pr2")


def test_one_demonstration_only_is_a_mistake(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    save_demonstrations(tmp_path / "one.h5", [demonstrate("up", 0)])
    assert "at least 2 demonstrations" in mistake(capsys, "learn", tmp_path / "one.h5", tmp_path / "library.h5")


def test_a_substitution_names_two_objects(capsys: pytest.CaptureFixture[str], library: Path) -> None:
    for pair in ("bottle", "bottle=", "=can"):
        for command in ("execute", "assist"):
            assert "such as bottle=can" in mistake(capsys, command, library, "up", "--substitute", pair)


def test_a_substitute_for_what_nobody_taught_is_a_mistake(capsys: pytest.CaptureFixture[str], library: Path) -> None:
    for command in ("execute", "assist"):
        assert "is named 'botle'" in mistake(capsys, command, library, "up", "--substitute", "botle=can")


def test_learning_prints_the_decisions_and_holds_out_the_rest(
    capsys: pytest.CaptureFixture[str], taught: Path, tmp_path: Path
) -> None:
    arguments = ["learn", str(taught), str(tmp_path / "l.h5"), "--count", "4", "--held-out", str(tmp_path / "rest.h5")]
    assert cli.run(arguments) == 0
    text = capsys.readouterr().out
    assert "learned from 8 demonstrations" in text
    assert "start" in text
    assert [item.label for item in load_demonstrations(tmp_path / "rest.h5")] == ["up", "up", "left", "left"]
    assert cli.run([*arguments, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["learned_from"], result["held_out"]) == (8, 4)
    assert result["motions"]["up"]["end"]["position"]["frame"] == "start"


def test_what_was_held_out_is_recognized(capsys: pytest.CaptureFixture[str], library: Path, tmp_path: Path) -> None:
    arguments = ["recognize", str(library), str(library.with_name("rest.h5")), "--plot", str(tmp_path / "belief.png")]
    assert cli.run(arguments) == 0
    assert "4 of 4 recognized" in capsys.readouterr().out
    assert (tmp_path / "belief.png").is_file()
    assert cli.run([*arguments[:3], "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["recognized"] == 4
    assert {row["recognized as"] for row in result["recordings"]} == {"up", "left"}


def test_files_are_shown_as_a_table_json_and_picture(
    capsys: pytest.CaptureFixture[str], taught: Path, library: Path, tmp_path: Path
) -> None:
    assert cli.run(["show", str(taught), "--plot", str(tmp_path / "taught.png")]) == 0
    assert "12 demonstrations" in capsys.readouterr().out
    assert cli.run(["show", str(library), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["kind"] == "pft_exec motion library"
    assert (tmp_path / "taught.png").is_file()


def test_recordings_of_others_are_converted(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = np.random.default_rng(0).normal(size=(20, 2))
    np.savez(tmp_path / "a.npz", label=np.array(["wave"]), pos_0000=path, t_0000=np.linspace(0.0, 1.0, 20))
    arguments = ["convert", str(tmp_path / "a.npz"), str(tmp_path / "a.h5"), "--scale", "0.01"]
    assert cli.run(arguments) == 0
    assert "1 demonstrations in" in capsys.readouterr().out
    np.testing.assert_allclose(load_demonstrations(tmp_path / "a.h5")[0].position[:, :2], 0.01 * path)
    assert cli.run([*arguments, "--summary"]) == 0
    assert "wave" in capsys.readouterr().out
    assert cli.run([*arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["motions"][0]["motion"] == "wave"


@pytest.mark.data
@pytest.mark.slow
def test_people_who_were_not_learned_from_are_recognized(
    capsys: pytest.CaptureFixture[str], recordings: Path, tmp_path: Path
) -> None:
    """Everyday tasks of people: convert, learn from five of each motion, recognize the rest."""
    files = [str(tmp_path / name) for name in ("d.h5", "library.h5", "rest.h5")]
    assert cli.run(["convert", str(recordings / "robottasks9.npz"), files[0]]) == 0
    assert cli.run(["learn", files[0], files[1], "--count", "5", "--held-out", files[2]]) == 0
    capsys.readouterr()
    assert cli.run(["recognize", files[1], files[2], "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["recognized"] == 36


def fake_report(ok: bool) -> dict[str, Any]:
    figure = {"value": 1.5, "floor": 1.0, "unit": "mm", "bound": "at most", "ok": ok}
    run = {
        "arm": "left",
        "kind": "fresh",
        "motion": "reach",
        "taken over": "reach",
        "success": ok,
        "reason": "2 mm off",
    }
    return {
        "figures": {"right arm: end error": figure},
        "motions": {"reach": {"description": "`reach` ends 0.12 m right of bottle (spread 2 mm)"}},
        "runs": [run | {"details": {"take_over_share": 0.25}}],
    }


@pytest.mark.parametrize("ok", [True, False])
def test_the_demo_closes_with_its_figures_and_strictly_fails_below_a_floor(
    ok: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    calls: list[tuple[Any, ...]] = []

    def run_demo(out: Path, *, seed: int, progress: Any, video: bool) -> dict[str, Any]:
        progress("teaching", 0.5)
        calls.append((out, seed, video))
        return fake_report(ok)

    monkeypatch.setattr("pft_exec.evaluation.demo.run_demo", run_demo)
    arguments = ["demo", "--out", str(tmp_path), "--seed", "3", "--no-video"]
    assert cli.run(arguments) == 0
    assert calls == [(tmp_path, 3, False)]
    printed = capsys.readouterr().out
    assert "right arm: end error" in printed
    assert "reach ends 0.12 m right of bottle (spread 2 mm)" in printed
    assert cli.run([*arguments, "--strict", "--json"]) == (0 if ok else 1)
    assert json.loads(capsys.readouterr().out) == fake_report(ok)


def test_a_study_runs_over_the_seeds_from_the_first(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    calls: list[tuple[Any, ...]] = []

    def run_study(seeds: Any, out: Path, *, jobs: int, progress: Any) -> dict[str, Any]:
        calls.append((list(seeds), out, jobs))
        return fake_report(True)

    monkeypatch.setattr("pft_exec.evaluation.study.run_study", run_study)
    assert cli.run(["evaluate", "--seeds", "3", "--seed", "4", "--out", str(tmp_path), "--jobs", "2"]) == 0
    assert calls == [([4, 5, 6], tmp_path, 2)]
    assert "end error" in capsys.readouterr().out


@pytest.mark.parametrize(("failed", "title"), [([], "no failures"), ([{"why": "fell over"}], "failures")])
def test_a_study_without_failures_says_so(
    failed: list[dict[str, str]],
    title: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    report = fake_report(True) | {"motions": [{"motion": "wind"}], "failures": failed}
    monkeypatch.setattr("pft_exec.evaluation.task_study.run_task_study", lambda *_, **__: report)
    assert cli.run(["evaluate", "--task", "cable", "--robot", "wam", "--out", str(tmp_path)]) == 0
    assert title in [line.strip() for line in capsys.readouterr().out.splitlines()]


@pytest.mark.parametrize("command", ["reproduce", "benchmark"])
def test_tables_are_printed_one_after_another(
    command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    result = {"tables": {"first": [{"method": "ours", "share": 99.0}], "second": [{"method": "theirs", "share": 82.0}]}}
    monkeypatch.setattr(f"pft_exec.evaluation.{command}", lambda _, **__: result)
    assert cli.run([command, "table1"]) == 0
    text = capsys.readouterr().out
    assert text.index("first") < text.index("ours") < text.index("second") < text.index("theirs")
    assert cli.run([command, "table1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == result


def test_a_warning_is_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def read_contents(path: Path) -> None:
        warnings.warn("motion 'reach' is left out", RuntimeWarning, stacklevel=1)
        raise OSError("the disk is full")

    monkeypatch.setattr("pft_exec.report.read_contents", read_contents)
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        assert cli.run(["show", "a.h5"]) == 2
    assert capsys.readouterr().err.splitlines() == [
        "pft-exec: warning: motion 'reach' is left out",
        "pft-exec: the disk is full",
    ]


@pytest.mark.slow
def test_teach_learn_execute_and_assist_from_the_command_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """The parts stand alone: files go from one to the next, on both arms, and every run succeeds."""
    files = [str(tmp_path / name) for name in ("taught.h5", "library.h5", "run.h5", "run.png")]
    teach = ["teach", files[0], "--motion", "move_left", "--motion", "go_home", "--count", "3", "--seed", "5"]
    assert cli.run(teach) == 0
    assert cli.run(["learn", files[0], files[1]]) == 0
    for command, *options in (["execute"], ["assist"], ["execute", "--arm", "left", "--mirror"]):
        capsys.readouterr()
        outputs = ["--log", files[2], "--plot", files[3], "--json"]
        assert cli.run([command, files[1], "go_home", "--seed", "6", *options, *outputs]) == 0
        result = json.loads(capsys.readouterr().out)
        assert result["success"], result["reason"]
        assert result["arm"] == (options[1] if options else "right")
        assert cli.run(["show", files[2]]) == 0
        assert Path(files[3]).stat().st_size > 10_000


@pytest.mark.slow
def test_the_shipped_robot_and_task_pass_their_check(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["check", "robot", "pr2", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["checks"]
    assert any("simulated second" in row["check"] for row in rows)
    assert cli.run(["check", "task", "tabletop", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["checks"]) == 5


def test_a_broken_description_fails_its_check_with_what_to_mend(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "robot.toml").write_text("titel = 'x'\n")
    assert cli.run(["check", "robot", str(tmp_path), "--json"]) == 1
    (row,) = json.loads(capsys.readouterr().out)["checks"]
    assert not row["ok"]
    assert "titel" in row["detail"]


@pytest.mark.parametrize(("kind", "name", "nearest"), [("robot", "pr3", "pr2"), ("task", "tabeltop", "tabletop")])
def test_checking_what_does_not_exist_is_a_mistake_of_the_users(
    kind: str, name: str, nearest: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["check", kind, name]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert f"Did you mean '{nearest}'?" in printed.err


def test_a_file_to_write_without_the_suffix_of_hdf5_is_refused_at_once(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """``pft-exec teach reach`` is a motion's name where a file's belongs."""
    assert cli.run(["teach", str(tmp_path / "reach")]) == 2
    assert "a file to write is named .h5 or .hdf5" in capsys.readouterr().err


def test_an_interruption_says_so(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("pft_exec.report.read_contents", interrupt)
    assert cli.run(["show", "library.h5"]) == 130
    assert capsys.readouterr().err == "pft-exec: interrupted.\n"
