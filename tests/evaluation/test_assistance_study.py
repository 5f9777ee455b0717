"""The study of assistance: counts what it should, goes on where it stopped, and refuses what is not its own."""

from __future__ import annotations

import json

import pytest

from pft_exec.evaluation import assistance_study
from pft_exec.evaluation.assistance_study import AssistedRun, assistance_rows, run_assistance_study
from pft_exec.evaluation.lessons import Subject
from pft_exec.exceptions import StorageError


def test_shares_are_counted_over_the_runs_that_were_possible():
    runs = [
        AssistedRun("a", 0, taken="a", finished=True, join=0.2),
        AssistedRun("a", 1, taken="b"),
        AssistedRun("a", 2, taken="b", asked=1),
        AssistedRun("b", 3),
        AssistedRun("b", 4, possible=False),
    ]
    rows = {row["motion"]: row for row in assistance_rows(runs)}
    assert rows["all"]["runs"] == 4
    assert rows["all"]["right %"] == 25.0
    assert rows["all"]["wrong %"] == 25.0
    assert rows["all"]["asked %"] == 25.0
    assert rows["all"]["finished %"] == 25.0
    assert rows["b"]["runs"] == 1


@pytest.fixture
def pretended(monkeypatch):
    """Runs that take no time; the list of those that were made."""
    made: list[int] = []

    def run(_, __, label, number):
        made.append(number)
        return AssistedRun(label, number, taken=label, finished=True)

    monkeypatch.setattr(assistance_study, "assisted_run", run)
    monkeypatch.setattr(assistance_study, "give_lessons", lambda lessons, *_: dict.fromkeys(lessons, ()))
    monkeypatch.setattr(assistance_study, "learn_library", lambda _: None)
    return made


def test_an_interrupted_study_goes_on_where_it_stopped(pretended, tmp_path):
    run_assistance_study([Subject()], tmp_path, runs=3)
    report = run_assistance_study([Subject()], tmp_path, runs=5)
    assert pretended == [0, 1, 2, 3, 4]
    rows = next(iter(report["tables"].values()))
    assert rows[0]["runs"] == 5
    assert rows[0]["right %"] == 100.0
    assert (rows[-1]["motion"], rows[-1]["right %"]) == ("floor", 97.0)
    assert json.loads((tmp_path / "assistance.json").read_text()) == report


def test_a_damaged_file_and_one_of_another_version_are_refused(pretended, tmp_path):
    run_assistance_study([Subject()], tmp_path, runs=1)
    path = next((tmp_path / Subject().name).glob("*.json"))
    content = json.loads(path.read_text())
    path.write_text(json.dumps(content | {"version": "0.0"}))
    with pytest.raises(StorageError, match="another version"):
        run_assistance_study([Subject()], tmp_path, runs=1)
    path.write_text("{")
    with pytest.raises(StorageError, match="damaged"):
        run_assistance_study([Subject()], tmp_path, runs=1)
    assert pretended == [0]
