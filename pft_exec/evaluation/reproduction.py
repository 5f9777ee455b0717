"""Everything that is compared, run by name: the paper's tables, its figure 5, and the recordings of real people."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from threadpoolctl import threadpool_limits

from pft_exec.evaluation import pictures
from pft_exec.evaluation.extras import check_baselines
from pft_exec.evaluation.figure5 import figure5, write_figure5
from pft_exec.evaluation.methods import METHODS
from pft_exec.evaluation.protocol import Progress, silent
from pft_exec.evaluation.reach import evaluate_reach
from pft_exec.evaluation.real import SETS, Condition, evaluate_set
from pft_exec.evaluation.table3 import table3
from pft_exec.evaluation.tables import TableResult, table1, table2
from pft_exec.exceptions import StorageError, UnknownNameError

COMPARED = frozenset({"table1", "table2", "real"})  # with the baselines
SPLITS_A_SEED = 2  # of the real recordings: five seeds, the default of the command, make ten splits
UNKNOWN_SPLITS = 2
DRAWS_A_SEED = 4  # of the teaching demonstrations of reach_target; medians settle from 10 draws on
REAL_METHODS = tuple(name for name in METHODS if name != "HMM, ergodic")
POSED = "robottasks9"  # the set that has orientations; only the tubes use them
LARGEST = "letters2d"  # 26 motions, so 26 libraries a split to leave each out once: only where learning is quick
QUICK_METHODS = ("robust, phase", "DTW neighbor", "DTW neighbor, direction")
BLIND = "dong2012"  # the published method has no hypothesis for an unknown motion: there is nothing to ask
TUBE_METHODS = ("robust, phase", "dong2012")

Rows = Sequence[Mapping[str, Any]]


def reproduce(
    name: str, seeds: int = 5, out: str | Path | None = None, progress: Progress = silent, *, jobs: int = 1
) -> dict[str, Any]:
    """Run one comparison, or all.

    Parameters
    ----------
    name : "table1", "table2", "table3", "figure5", "real" or "all"
    seeds : int
        Of the simulated people; the recordings are split `SPLITS_A_SEED` times as often, and a figure shows one seed.
    out : str, Path or None
        Folder, made where missing, for ``<name>.json``, the pictures, and the lessons that a robot was given: they are
        simulated once, and an interrupted run goes on.
    progress : callable
        Takes the stage and the share that is done, in [0, 1].
    jobs : int
        Processes that teach, where a robot is taught, or judge splits of the recordings.

    Returns
    -------
    dict
        "tables": {title: rows}; the results in full under the names of the comparisons.

    Raises
    ------
    UnknownNameError
        If there is no such comparison.
    MissingPackageError
        If it has baselines whose packages are not installed.
    StorageError
        If "real" finds no recordings, or nothing can be written to `out`.
    """
    runs: dict[str, Callable[[_Request], _Part]] = {
        "table1": _table1,
        "table2": _table2,
        "table3": _table3,
        "figure5": _figure5,
        "real": _real,
    }
    if name not in (*runs, "all"):
        raise UnknownNameError("comparison", name, (*runs, "all"))
    chosen = list(runs) if name == "all" else [name]
    if not COMPARED.isdisjoint(chosen):
        check_baselines()
    folder = None if out is None else _made(Path(out))
    result: dict[str, Any] = {"tables": {}}
    for place, part_name in enumerate(chosen):
        with threadpool_limits(1):  # matrices are small: threads that wait for each other made this ten times as slow
            part = runs[part_name](_Request(seeds, folder, jobs, _share_of(progress, place, len(chosen))))
        result["tables"] |= part.tables
        result[part_name] = part.details
        if folder is not None:
            part.draw(folder)
    if folder is not None:
        (folder / f"{name}.json").write_text(json.dumps(result, indent=2), encoding="utf-8")
    return result


class _Request(NamedTuple):
    """What a comparison is run with."""

    seeds: int
    folder: Path | None
    jobs: int
    progress: Progress

    @property
    def lessons(self) -> Path | None:
        """Folder of lessons that are kept."""
        return None if self.folder is None else self.folder / "lessons"


class _Part:
    """What one comparison gives: tables for a reader, details for JSON, and a way to draw its pictures."""

    def __init__(self, tables: dict[str, Rows], details: Any, draw: Callable[[Path], Any]) -> None:
        self.tables = tables
        self.details = details
        self.draw = draw


def recordings_folder() -> Path:
    """Folder of the recordings of real people: the one that PFT_EXEC_DATA names, else ../shared/data of the project.

    Raises
    ------
    StorageError
        If there are none.
    """
    folder = Path(os.environ.get("PFT_EXEC_DATA") or Path(__file__).parents[3] / "shared" / "data")
    missing = [name for name in (*SETS, "reach_target") if not (folder / f"{name}.npz").is_file()]
    if missing:
        raise StorageError(
            f"there are no recordings {', '.join(missing)} in {folder}. Set PFT_EXEC_DATA to the folder that has them."
        )
    return folder


def _table1(request: _Request) -> _Part:
    return _table("Table 1, varying scenes", table1(request.seeds, progress=request.progress))


def _table2(request: _Request) -> _Part:
    return _table("Table 2, one scene", table2(request.seeds, progress=request.progress))


def _table3(request: _Request) -> _Part:
    results = table3(request.seeds, folder=request.lessons, jobs=request.jobs, progress=request.progress)
    tables: dict[str, Rows] = {}
    for result in results:
        tables[f"Table 3, {result.condition}"] = result.table()
        tables |= {f"Table 3, {result.condition}: {name}": result.by_motion(name) for name in result.summaries}

    def draw(folder: Path) -> None:
        for result in results:
            name = result.condition.replace(", ", "_").replace(" ", "_")
            pictures.draw_confusions(tuple(result.summaries.values()), folder / f"table3_{name}_confusion.png")

    return _Part(tables, [result.to_dict() for result in results], draw)


def _figure5(request: _Request) -> _Part:
    motions = figure5(folder=request.lessons, jobs=request.jobs, progress=request.progress)
    return _Part(
        {"Figure 5: motions taught to a PR2": [item.row() for item in motions]},
        [item.to_dict() for item in motions],
        lambda folder: write_figure5(motions, folder),
    )


def _table(title: str, result: TableResult) -> _Part:
    motions: dict[str, Rows] = {f"{title}: {method}": result.by_motion(method) for method in result.summaries}
    shown = {name: rows for name, rows in motions.items() if name.endswith(TUBE_METHODS)}
    return _Part(
        {f"{title}, %": result.table(), **shown},
        {**result.to_dict(), "by_motion": {name.split(": ", 1)[1]: rows for name, rows in motions.items()}},
        lambda folder: pictures.draw_table(result, folder),
    )


def _real(request: _Request) -> _Part:
    folder, seeds, progress = recordings_folder(), request.seeds, request.progress
    runs = [(name, Condition(removed), REAL_METHODS) for name in SETS for removed in (True, False)]
    runs += [(POSED, Condition(removed, pose=True), TUBE_METHODS) for removed in (True, False)]
    tables: dict[str, Rows] = {}
    details: dict[str, Any] = {"recognition": []}
    for place, (name, condition, methods) in enumerate(runs):
        share = _share_of(progress, place, len(runs) + 1)
        asking = [method for method in methods if method != BLIND]
        unknown_splits, asked = (1, QUICK_METHODS) if name == LARGEST else (UNKNOWN_SPLITS, asking)
        splits = SPLITS_A_SEED * seeds
        result = evaluate_set(folder, name, methods, splits, condition, unknown_splits, asked, share, request.jobs)
        tables[f"{name}, {condition.name}, %"] = result.table()
        details["recognition"].append(result.to_dict())
    reach = evaluate_reach(folder, draws=DRAWS_A_SEED * seeds, progress=_share_of(progress, len(runs), len(runs) + 1))
    tables["reach_target, placement never taught"] = reach.table()
    details["generation"] = reach.to_dict()
    return _Part(tables, details, lambda _: None)


def _share_of(progress: Progress, place: int, count: int) -> Progress:
    """Progress of one of `count` equal parts as progress of the whole."""
    return lambda stage, done: progress(stage, (place + done) / count)


def _made(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(f"the folder {folder} cannot be made ({error.strerror}).") from error
    return folder
