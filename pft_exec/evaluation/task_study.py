"""The study of a task: teach, learn, and execute every motion in many scenes that nobody taught, on every arm.

Whatever is done leaves a file: lessons, the library, a result for each rollout. An interrupted study goes on where it
stopped; a folder that was begun with other settings is refused.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed

from pft_exec.description import load_task
from pft_exec.evaluation.benchmarks.stopwatch import milliseconds
from pft_exec.evaluation.figure5 import SAMPLES, thinned
from pft_exec.evaluation.lessons import Subject, described, give_lessons
from pft_exec.evaluation.measurements import found_relations
from pft_exec.evaluation.methods import expected_conflicts
from pft_exec.evaluation.protocol import Progress, silent
from pft_exec.evaluation.task_report import write_report
from pft_exec.evaluation.task_rollouts import DRAWN, MIRRORED, Rollout, RolloutResult, is_filmed, run_rollout
from pft_exec.exceptions import PFTError, StorageError, UnknownArmError
from pft_exec.learning import MotionLibrary, learn_library, learn_motion
from pft_exec.model import load_robot
from pft_exec.simulation import default_arm


def run_task_study(
    out: str | Path,
    subject: Subject | None = None,
    *,
    scenes: int = 20,
    arms: Sequence[str] | None = None,
    mirror_images: bool = False,
    relevance_seeds: int = 0,
    film: str = "failed",
    jobs: int = 1,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Evaluate a task, and write ``report.json``, ``report.html`` and contact sheets.

    Parameters
    ----------
    out : str or Path
        Folder; made where missing. What it holds of the same settings is not repeated.
    subject : Subject or None
        None is the bottle's motions on the PR2.
    scenes : int
        Unseen scenes of each motion and arm.
    arms : sequence of str or None
        None is every arm. All lessons are taught with the robot's only arm, else its right one; what was learned is
        mirrored for the other.
    mirror_images : bool
        The other arm also works in the mirror images of the taught arm's scenes.
    relevance_seeds : int
        Teach anew with so many seeds, and count how often the motion variables are exactly right.
    film : str
        "failed": a film of every failed rollout; "none", "all", or the beginning of the names of those to film,
        such as "right_drawn_pour_into_003".
    jobs : int
        Processes.
    progress : callable
        Takes what is going on and the share that is done.

    Returns
    -------
    dict
        What ``report.json`` holds: "settings", "figures", "motions" (rows), "failures" (rows), "rollouts".

    Raises
    ------
    StorageError
        If the folder was begun with other settings or by another version, or one of its files is damaged.
    UnknownArmError
        If the robot has no such arm.
    UnreachableError
        If a lesson cannot be given.
    """
    subject, out = subject or Subject(task="bottle"), Path(out)
    arms = _checked_arms(subject, arms)
    (out / "rollouts").mkdir(parents=True, exist_ok=True)
    _keep_settings(subject, out)
    library = _learn(subject, out, jobs, _part(progress, 0.0, 0.15))
    relevance = _relevance(subject, out, relevance_seeds, jobs, _part(progress, 0.15, 0.4))
    planned = _planned(subject, arms, scenes, mirror_images)
    begin = 0.4 if relevance_seeds else 0.15
    results = _roll_out(planned, out, film, jobs, _part(progress, begin, 0.97))
    times = {label: _learning_time(library, label) for label in library.labels}
    progress("writing the report", 0.98)
    about = {**asdict(subject), "scenes": scenes, "arms": list(arms), "relevance_seeds": relevance_seeds}
    return write_report(out, about, results, relevance, times)


def _checked_arms(subject: Subject, arms: Sequence[str] | None) -> tuple[str, ...]:
    """Those asked for, or all; the one that is taught first: the others are compared with it."""
    robot = load_robot(subject.robot, tool=subject.tool)
    known, taught = robot.arms, default_arm(robot)
    for arm in arms or ():
        if arm not in known:
            raise UnknownArmError("arm", arm, known, f"The robot is {subject.robot!r}.")
    return tuple(sorted(set(arms or known), key=lambda arm: arm != taught))


def _keep_settings(subject: Subject, out: Path) -> None:
    """Write the settings, or hold them against those that the folder was begun with."""
    path = out / "settings.json"
    now = {**asdict(subject), "described": described(subject.robot, subject.task)}
    if not path.exists():
        write_beside(path, json.dumps(now, indent=2) + "\n")
        return
    try:
        then = dict(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, TypeError) as error:
        raise StorageError(f"{path} is damaged ({error}). Use another folder.") from error
    changed = [
        f"{name} was {then.get(name)!r} and is {value!r}" for name, value in now.items() if then.get(name) != value
    ]
    if changed:
        raise StorageError(f"{out} was begun with other settings: {'; '.join(changed)}. Use another folder.")


def _learn(subject: Subject, out: Path, jobs: int, progress: Progress) -> MotionLibrary:
    """The library of the folder; taught and learned where it has none."""
    path = out / "library.h5"
    if not path.exists():
        taught = give_lessons(subject.lessons, out / "lessons", jobs, progress)
        with expected_conflicts():
            learn_library(item for lesson in subject.lessons for item in taught[lesson]).save(path)
    return MotionLibrary.load(path)


def _relevance(subject: Subject, out: Path, seeds: int, jobs: int, progress: Progress) -> dict[str, list[bool]]:
    """For each motion, and each of some seeds, whether its variables are exactly those that the task means."""
    task = load_task(subject.task)
    lessons = [lesson for seed in range(subject.seed, subject.seed + seeds) for lesson in subject.lessons_of(seed)]
    right: dict[str, list[bool]] = {label: [] for label in task.labels if seeds}
    taught = give_lessons(lessons, out / "lessons", jobs, progress)
    for lesson in lessons:
        with expected_conflicts():
            library = learn_library(taught[lesson])
        right[lesson.label].append(found_relations(library, lesson.label) == task.relations(lesson.label))
    return right


def _planned(subject: Subject, arms: Iterable[str], scenes: int, mirror_images: bool) -> list[Rollout]:
    taught = default_arm(load_robot(subject.robot, tool=subject.tool))
    about = (subject.robot, subject.task, subject.tool)
    return [
        Rollout(*about, label, arm, kind, number, subject.seed)
        for arm in arms
        for kind in (DRAWN, MIRRORED)[: 2 if mirror_images and arm != taught else 1]
        for label in load_task(subject.task).labels
        for number in range(scenes)
    ]


def _roll_out(planned: Sequence[Rollout], out: Path, film: str, jobs: int, progress: Progress) -> list[RolloutResult]:
    """Results of all, those that have a file read from it."""
    folder = out / "rollouts"
    missing = [item for item in planned if _is_due(item, folder, film)]
    done = len(planned) - len(missing)
    finished = Parallel(n_jobs=jobs, return_as="generator")(
        delayed(_roll)(item, out / "library.h5", folder, film) for item in missing
    )
    for number, name in enumerate(finished, start=done + 1):
        progress(f"executed {name}", number / len(planned))
    return [_load(folder / f"{item.name}.json") for item in planned]


def _is_due(rollout: Rollout, folder: Path, film: str) -> bool:
    """Whether a rollout has no result yet, or is to be filmed and was not."""
    path = folder / f"{rollout.name}.json"
    if not path.exists():
        return True
    result = _load(path)
    has_film = result.refused or path.with_suffix(".mp4").exists()  # of what did not begin there is none
    return not has_film and is_filmed(film, result, rollout.name)


def _roll(rollout: Rollout, library: Path, folder: Path, film: str) -> str:
    result = run_rollout(rollout, library, folder, film)
    write_beside(folder / f"{rollout.name}.json", json.dumps(result.to_dict(), indent=1) + "\n")
    return rollout.name


def _load(path: Path) -> RolloutResult:
    try:
        return RolloutResult(**json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        if isinstance(error, PFTError):
            raise
        raise StorageError(f"{path} is damaged ({error}). Remove it to repeat that rollout.") from error


def write_beside(path: Path, text: str) -> None:
    """Write a file beside its place and rename it: whole or not at all."""
    beside = path.with_name(f".{path.name}.partial")
    beside.write_text(text, encoding="utf-8")
    beside.replace(path)


def _learning_time(library: MotionLibrary, label: str) -> float:
    """Ms to learn one motion from its demonstrations of `SAMPLES` samples each; median of some runs."""
    thin = [thinned(item, SAMPLES) for item in library[label].demonstrations]
    with expected_conflicts():
        return milliseconds(lambda: learn_motion(thin), repeats=5)


def _part(progress: Progress, begin: float, end: float) -> Progress:
    """Progress of a part as progress of the whole."""
    return lambda stage, done: progress(stage, begin + (end - begin) * done)
