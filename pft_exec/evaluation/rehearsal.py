"""The main job once: teach four motions by hand, learn them, and finish them in scenes nobody taught, on both arms.

What one seed of the demo does, without any file; `pft_exec.evaluation.demo` writes the report of it, and
`pft_exec.evaluation.study` repeats it over seeds.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.exceptions import UnreachableError
from pft_exec.execution import ExecutionLog, GuidingFigures, assist, prepare, teach
from pft_exec.execution.control_loop import Observer
from pft_exec.learning import MotionLibrary, learn_library
from pft_exec.simulation import World

ROBOT, TASK = "pr2", "tabletop"
TAUGHT, OTHER = "right", "left"
ONE_SIDED = "put_on_table"
"""A motion whose object lies where only the arm on its side reaches."""

Progress = Callable[[str, float], None]
"""Takes what is going on and the share that is done, 0 to 1."""
Watch = Callable[[str], AbstractContextManager[Observer | None]]
"""Opens a recording of one run under a caption; see `unwatched`."""


@dataclass(frozen=True)
class Run:
    """One assisted motion.

    Parameters
    ----------
    kind : str
        "unseen": the taught arm in a scene nobody taught; "mirrored": the other arm in its mirror image; "fresh": the
        other arm in a scene drawn from the mirrored placements.
    arm, truth : str
        Which arm, and what the hand began.
    scene : Scene
    log : ExecutionLog
    """

    kind: str
    arm: str
    truth: str
    scene: Scene
    log: ExecutionLog


@dataclass(frozen=True)
class Rehearsal:
    """All that one seed made.

    Parameters
    ----------
    seed : int
    demonstrations : tuple of Demonstration
    guidance : tuple of Guidance
        How well the tool followed the hand in each demonstration.
    library : MotionLibrary
    runs : tuple of Run
    refusal : str
        What the other arm said of a placement that only the taught arm reaches; empty where it was not refused.
    """

    seed: int
    demonstrations: tuple[Demonstration, ...]
    guidance: tuple[GuidingFigures, ...]
    library: MotionLibrary
    runs: tuple[Run, ...]
    refusal: str


def unwatched(caption: str) -> AbstractContextManager[None]:
    """Record nothing."""
    del caption
    return nullcontext()


def rehearse(seed: int, *, count: int = 5, watch: Watch = unwatched, progress: Progress | None = None) -> Rehearsal:
    """Teach, learn, and assist in all motions with both arms.

    Parameters
    ----------
    seed : int
        Of everything that chance decides.
    count : int
        Demonstrations of each motion.
    watch : callable
        Opens a recording of each run.
    progress : callable or None
    """
    report = progress or (lambda _, __: None)
    with World(ROBOT, TASK, seed=seed) as world:
        labels = world.task.labels
        steps = _Steps(report, total=len(labels) * 4)
        demonstrations: list[Demonstration] = []
        guidance: list[GuidingFigures] = []
        for label in labels:
            steps.next(f"teaching {label}")
            with watch(f"teaching {label}, the hand leads") as observer:
                demonstrations += teach(
                    world, label, TAUGHT, count, seed=seed, report=guidance.append, observer=observer
                )
        library = learn_library(demonstrations)
        runs = _perform(world, library, seed, steps, watch)
        refusal = _refused(world, library, runs)
    return Rehearsal(seed, tuple(demonstrations), tuple(guidance), library, tuple(runs), refusal)


def _perform(world: World, library: MotionLibrary, seed: int, steps: _Steps, watch: Watch) -> list[Run]:
    """Every motion: unseen scenes for the taught arm, their mirror images and fresh ones for the other."""
    mirrored = library.mirrored(world.base)
    runs = []
    for label in library.labels:
        steps.next(f"right arm: {label}")
        prepare(world, label, TAUGHT, seed=seed)
        scene, start = world.scene, world.tool(TAUGHT)
        runs.append(_run(world, library, label, "unseen", TAUGHT, seed, watch))
        steps.next(f"left arm, mirror image: {label}")
        prepare(world, label, OTHER, scene=scene.mirrored(world.base), start=start.mirrored(world.base))
        runs.append(_run(world, mirrored, label, "mirrored", OTHER, seed, watch))
        steps.next(f"left arm, fresh scene: {label}")
        prepare(world, label, OTHER, seed=seed)
        runs.append(_run(world, mirrored, label, "fresh", OTHER, seed, watch))
    return runs


def _run(world: World, library: MotionLibrary, label: str, kind: str, arm: str, seed: int, watch: Watch) -> Run:
    scene = world.scene
    with watch(f"{arm} arm: the hand begins, the robot finishes ({label})") as observer:
        log = assist(world, library, label, arm, seed=seed, observer=observer)
    return Run(kind, arm, label, scene, log)


def _refused(world: World, library: MotionLibrary, runs: list[Run]) -> str:
    """Ask the other arm to put something on the mat of the taught arm's side, which it does not reach."""
    scene = next(run.scene for run in runs if run.truth == ONE_SIDED)
    try:
        prepare(world, ONE_SIDED, OTHER, scene=scene)
        assist(world, library, ONE_SIDED, OTHER)
    except UnreachableError as error:
        return str(error)
    return ""


class _Steps:
    """Counts what is done, for the progress bar."""

    def __init__(self, report: Progress, total: int) -> None:
        self._report, self._total, self._done = report, total, 0

    def next(self, stage: str) -> None:
        self._report(stage, self._done / self._total)
        self._done += 1
