"""Commands that move a robot: `execute` and `assist`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pft_exec.cli.application import command
from pft_exec.cli.options import ArmName, Gui, Json, LibraryFile, Log, Mirror, Plot, Robot, Seed, Substitute, Task
from pft_exec.cli.terminal import print_tables, progress

if TYPE_CHECKING:
    from pft_exec.execution import ExecutionLog
    from pft_exec.learning import MotionLibrary
    from pft_exec.simulation import World


@command("execute library.h5 reach --seed 7 --log run.h5 --plot run.png")
def execute(
    library: LibraryFile,
    motion: Annotated[str, typer.Argument(help="Motion of the library.")],
    robot: Robot = "pr2",
    task: Task = "tabletop",
    arm: ArmName = None,
    mirror: Mirror = False,
    substitute: Substitute = None,
    seed: Seed = 0,
    log: Log = None,
    plot: Plot = None,
    gui: Gui = False,
    as_json: Json = False,
) -> None:
    """Execute a motion by itself in a scene that is drawn from the task's placements."""
    from pft_exec import execute as execute_tube

    swaps = _substitutions(substitute)
    with _stage(library, motion, robot, task, arm, mirror, seed, gui) as (world, known):
        run = execute_tube(world, known[motion].flow_tube(world.scene, world.tool(arm), swaps), arm)
    _report_run(run, log, plot, as_json)


@command("assist library.h5 reach --seed 7 --log run.h5 --plot seam.png")
def assist(
    library: LibraryFile,
    motion: Annotated[str, typer.Argument(help="Motion that the synthetic hand begins, without saying so.")],
    robot: Robot = "pr2",
    task: Task = "tabletop",
    arm: ArmName = None,
    mirror: Mirror = False,
    seed: Seed = 0,
    log: Log = None,
    plot: Plot = None,
    gui: Gui = False,
    as_json: Json = False,
) -> None:
    """A hand begins a motion; the robot recognizes it, takes over and finishes it."""
    from pft_exec import assist as assist_hand

    with _stage(library, motion, robot, task, arm, mirror, seed, gui) as (world, known):
        run = assist_hand(world, known, motion, arm, seed=seed)
    _report_run(run, log, plot, as_json)


@contextmanager
def _stage(
    library: Path, motion: str, robot: str, task: str, arm: str | None, mirror: bool, seed: int, gui: bool
) -> Iterator[tuple[World, MotionLibrary]]:
    """A world set up for a motion of the task, and a library that knows it, as the arm makes its motions."""
    from pft_exec import MotionLibrary, World
    from pft_exec.execution import prepare

    known = MotionLibrary.load(library)
    known[motion]  # refused before any world opens
    with progress(motion), World(robot, task, gui=gui, seed=seed) as world:
        prepare(world, motion, arm, seed=seed)
        yield world, known.mirrored(world.base) if mirror else known


def _substitutions(pairs: Sequence[str] | None) -> dict[str, str]:
    """``["bottle=can"]`` as a mapping from the taught object to the one that takes its place."""
    named = {taught: now for taught, _, now in (pair.partition("=") for pair in pairs or ())}
    if not all((*named, *named.values())):
        raise typer.BadParameter("a substitution names two objects, such as bottle=can.")
    return named


def _report_run(run: ExecutionLog, log: Path | None, plot: Path | None, as_json: bool) -> None:
    from pft_exec.report import log_rows, log_summary, plot_log

    if log is not None:
        run.save(log)
    if plot is not None:
        plot_log(run, plot)
    print_tables(as_json, log_summary(run), {run.reason: log_rows(run)})
