"""The study of assistance: many hands begin motions in scenes nobody taught; what the robot made of each, counted.

Lessons and runs leave files; an interrupted study goes on where it stopped.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from pft_exec import __version__
from pft_exec.description import load_task, random_stream
from pft_exec.evaluation.figures import wilson_interval
from pft_exec.evaluation.lessons import Subject, described, give_lessons
from pft_exec.evaluation.protocol import Progress, silent
from pft_exec.exceptions import StorageError, UnreachableError
from pft_exec.execution import ExecutionLog, assist, prepare
from pft_exec.learning import MotionLibrary, learn_library
from pft_exec.model import load_robot
from pft_exec.simulation import World

FLOORS = {"right": 97.0, "wrong": 0.5, "asked": 10.0, "finished": 95.0}
"""Percent of all runs: at least, at most, at most, at least."""


@dataclass(frozen=True)
class AssistedRun:
    """One run of the study.

    Parameters
    ----------
    label : str
        What the hand began.
    number : int
    taken : str
        What was taken over, empty where nothing was.
    finished : bool
        Whether the task's predicate held at the end.
    asked : int
        Questions.
    possible : bool
        False where no placement was found in which the arm can be led through the motion; such a run does not count.
    reason : str
    join : float, s
    late : float
        Share of the control periods, percent, that took longer to compute than they last.
    """

    label: str
    number: int
    taken: str = ""
    finished: bool = False
    asked: int = 0
    possible: bool = True
    reason: str = ""
    join: float = 0.0
    late: float = 0.0


def run_assistance_study(
    subjects: Iterable[Subject],
    out: str | Path,
    *,
    runs: int = 200,
    jobs: int = 1,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Let hands begin every motion of some tasks, so many runs for each robot and task, and count what came of it.

    Parameters
    ----------
    subjects : iterable of Subject
    out : str or Path
        Folder of lessons, runs and ``assistance.json``.
    runs : int
        For each subject, spread over its motions.
    jobs : int
        Processes.
    progress : callable
        Takes what is done and the share of it.

    Returns
    -------
    dict
        ``{"tables": {title: rows}}``: shares, percent, with their 95 % Wilson intervals, for each subject and motion,
        and what is asked of all runs together.

    Raises
    ------
    StorageError
        If a file is damaged or was written by another version or for another robot or task.
    UnreachableError
        If a lesson cannot be given.
    """
    out, subjects = Path(out), list(subjects)
    tables = {}
    for place, subject in enumerate(subjects):
        progress(f"lessons of {subject.name}", place / len(subjects))
        taught = give_lessons(subject.lessons, out / "lessons", jobs)
        demonstrations = [item for lesson in subject.lessons for item in taught[lesson]]
        done = _all_runs(subject, demonstrations, out / subject.name, runs, jobs, progress)
        asked_for = {"motion": "floor", "runs": None} | {f"{name} %": value for name, value in FLOORS.items()}
        tables[f"assistance: {subject.robot}, {subject.task}"] = [*assistance_rows(done), asked_for]
    report = {"tables": tables}
    (out / "assistance.json").write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    return report


def assistance_rows(done: Sequence[AssistedRun]) -> list[dict[str, Any]]:
    """A row for all runs and one for each motion: shares in percent with 95 % Wilson intervals."""
    labels = sorted({run.label for run in done})
    groups = {"all": list(done)} | {label: [run for run in done if run.label == label] for label in labels}
    return [_row(name, [run for run in group if run.possible]) for name, group in groups.items()]


def _row(name: str, runs: Sequence[AssistedRun]) -> dict[str, Any]:
    counted = {
        "right": sum(run.taken == run.label for run in runs),
        "wrong": sum(run.taken not in ("", run.label) and not run.asked for run in runs),
        "asked": sum(run.asked > 0 for run in runs),
        "finished": sum(run.finished for run in runs),
    }
    row: dict[str, Any] = {"motion": name, "runs": len(runs)}
    for share, hits in counted.items():
        low, high = wilson_interval(hits, len(runs))
        row[f"{share} %"] = 100.0 * hits / max(len(runs), 1)
        row[f"{share}, 95 %"] = f"{low:.1f} to {high:.1f}"
    joins = [run.join for run in runs if run.taken]
    return row | {"join s, median": float(np.median(joins)) if joins else 0.0}


def _all_runs(
    subject: Subject, demonstrations: Sequence[Any], folder: Path, runs: int, jobs: int, progress: Progress
) -> list[AssistedRun]:
    """The runs of one subject, those without a file made now."""
    folder.mkdir(parents=True, exist_ok=True)
    library = learn_library(demonstrations)
    labels = load_task(subject.task).labels
    planned = [(labels[number % len(labels)], number) for number in range(runs)]
    mark = described(subject.robot, subject.task)
    missing = [run for run in planned if not _file(folder, *run).exists()]
    made = Parallel(n_jobs=jobs, return_as="generator")(
        delayed(_keep)(subject, library, label, number, folder, mark) for label, number in missing
    )
    for count, name in enumerate(made, start=1):
        progress(name, (runs - len(missing) + count) / runs)
    return [_load(_file(folder, *run), mark) for run in planned]


def _file(folder: Path, label: str, number: int) -> Path:
    return folder / f"{label}_{number:04d}.json"


def _keep(subject: Subject, library: MotionLibrary, label: str, number: int, folder: Path, mark: str) -> str:
    """Make one run and write its file, beside and renamed."""
    run = assisted_run(subject, library, label, number)
    path = _file(folder, label, number)
    beside = path.with_suffix(".partial")
    content = {"version": __version__, "described": mark, "run": asdict(run)}
    beside.write_text(json.dumps(content) + "\n", encoding="utf-8")
    beside.replace(path)
    return f"{label} {number}"


def _load(path: Path, mark: str) -> AssistedRun:
    try:
        content: Mapping[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        version, described_as, run = content["version"], content["described"], AssistedRun(**content["run"])
    except (ValueError, KeyError, TypeError) as error:
        raise StorageError(f"{path} is damaged: it holds no run ({error}). Remove it to repeat it.") from error
    if (version, described_as) != (__version__, mark):
        raise StorageError(f"{path} was made with another version, robot or task. Use another folder.")
    return run


def assisted_run(subject: Subject, library: MotionLibrary, label: str, number: int) -> AssistedRun:
    """One hand begins one motion in a scene that nobody taught; its number is its seed."""
    seed = int(random_stream(subject.seed, "evaluate", "assistance", number).integers(2**31))
    with World(load_robot(subject.robot, tool=subject.tool), subject.task, seed=seed) as world:
        try:
            prepare(world, label, seed=seed)
            log = assist(world, library, label, seed=seed)
        except UnreachableError as error:
            return AssistedRun(label, number, possible=False, reason=str(error))
        return _run_of(log, label, number, world.control_period)


def _run_of(log: ExecutionLog, label: str, number: int, period: float) -> AssistedRun:
    return AssistedRun(
        label=label,
        number=number,
        taken=log.label,
        finished=bool(log.success),
        asked=int(log.details.get("asked", 0.0)),
        reason=log.reason,
        join=float(log.details.get("join_time", 0.0)),
        late=100.0 * float(np.mean(log.tick > period)),
    )
