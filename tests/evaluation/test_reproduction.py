"""Comparisons by name: their rows, the paper's figures beside them, their files and their refusals."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import pft_exec.evaluation as evaluation
from pft_exec.evaluation import reproduction, tables
from pft_exec.evaluation.tables import table1
from pft_exec.exceptions import StorageError, UnknownNameError


def test_public_names_load_on_first_use() -> None:
    assert evaluation.reproduce is reproduction.reproduce
    assert callable(evaluation.benchmark)
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        evaluation.nothing  # noqa: B018


def test_an_unknown_comparison_is_refused_by_name() -> None:
    with pytest.raises(UnknownNameError, match=r"no comparison is named 'table4'\. Did you mean 'table[123]'"):
        evaluation.reproduce("table4")


def test_an_unknown_benchmark_is_refused_by_name() -> None:
    with pytest.raises(UnknownNameError, match=r"no benchmark is named 'lerning'\. Did you mean 'learning'"):
        evaluation.benchmark("lerning")


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match="cannot be made"):
        evaluation.reproduce("table1", out=tmp_path / "file" / "folder")


def test_published_figures_are_those_of_the_paper() -> None:
    """[Dong2012]_: 49 and 33 of 60, 71 and 40 % of the time; 97 and 78 %, 81.4 and 70.4 % (our sums)."""
    result = table1(1, ["DTW neighbor"])
    for place, end, share in ((0, 49 / 60, 70.5), (1, 33 / 60, 39.9)):
        assert result.published(place) == (pytest.approx(100 * end), pytest.approx(share, abs=0.05))
    second = tables.TableResult("table2", {}, {})
    assert second.published(0) == (pytest.approx(97.0, abs=0.1), pytest.approx(81.4, abs=0.05))
    assert second.published(1) == (pytest.approx(78.4, abs=0.1), pytest.approx(70.4, abs=0.05))


def test_a_table_has_a_row_for_each_method_and_for_the_paper() -> None:
    seen: list[float] = []
    result = table1(2, ["DTW neighbor"], lambda _, done: seen.append(done))
    rows = result.table()
    assert [row["method"] for row in rows] == ["DTW neighbor", "published tube", "published HMM"]
    assert "±" in rows[0]["end"]
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    motions = result.by_motion("DTW neighbor")
    assert [row["motion"] for row in motions] == ["to bin", "left", "to x"]
    assert sum(row[f"as {label}"] for row in motions for label in ("to bin", "left", "to x")) == 120
    json.dumps(result.to_dict())


@pytest.mark.slow
def test_a_comparison_writes_its_result_and_its_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "METHODS", {})
    methods = ("robust, phase", "dong2012")
    monkeypatch.setattr(reproduction, "table1", lambda seeds, progress: table1(seeds, methods, progress))
    result = evaluation.reproduce("table1", seeds=1, out=tmp_path / "new" / "folder")
    assert set(result["tables"]) == {
        "Table 1, varying scenes, %",
        "Table 1, varying scenes: robust, phase",
        "Table 1, varying scenes: dong2012",
    }
    written = {path.name for path in (tmp_path / "new" / "folder").iterdir()}
    assert written == {"table1.json", "table1_confusion.png", "figure7_tubes.png", "figure8_likelihood.png"}
    stored = json.loads((tmp_path / "new" / "folder" / "table1.json").read_text())
    assert stored["table1"]["published"]["hmm"][0] == pytest.approx(55.0)


@pytest.mark.data
@pytest.mark.slow
def test_recordings_are_judged_under_every_condition(recordings: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PFT_EXEC_DATA", str(recordings))
    monkeypatch.setattr(reproduction, "SETS", ("helloworld",))
    monkeypatch.setattr(reproduction, "REAL_METHODS", ("DTW neighbor",))
    monkeypatch.setattr(reproduction, "TUBE_METHODS", ("DTW neighbor",))
    result = evaluation.reproduce("real", seeds=1)
    assert list(result["tables"]) == [
        "helloworld, start removed, position, %",
        "helloworld, absolute, position, %",
        "robottasks9, start removed, pose, %",
        "robottasks9, absolute, pose, %",
        "reach_target, placement never taught",
    ]
    judged = result["real"]["recognition"][0]
    assert judged["unknown_auroc"]["DTW neighbor"]["end"]["mean"] > 0.95
    json.dumps(result)
