"""Commands that move a robot: `execute` and `assist`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pft_exec.cli.application import command
from pft_exec.cli.options import (
    ArmName,
    Grasp,
    Gui,
    Json,
    LibraryFile,
    Log,
    Mirror,
    Pace,
    Plot,
    Robot,
    Seed,
    Softness,
    Solver,
    Substitute,
    Task,
    Tool,
)
from pft_exec.cli.terminal import print_tables, progress

if TYPE_CHECKING:
    from pft_exec.execution import ExecutionLog, TakeBackPlan
    from pft_exec.learning import MotionLibrary
    from pft_exec.recognition import Belief
    from pft_exec.simulation import World


@command("execute library.h5 reach --seed 7 --log run.h5 --plot run.png")
def execute(
    library: LibraryFile,
    motion: Annotated[str, typer.Argument(help="Motion of the library.")],
    robot: Robot = "pr2",
    task: Task = "tabletop",
    tool: Tool = None,
    arm: ArmName = None,
    mirror: Mirror = False,
    grasp: Grasp = "friction",
    substitute: Substitute = None,
    avoid: Annotated[list[str] | None, typer.Option(help="Object to keep clear of; may be repeated.")] = None,
    pace: Pace = 1.0,
    softness: Softness = 0.1,
    solver: Solver = "daqp",
    seed: Seed = 0,
    log: Log = None,
    plot: Plot = None,
    gui: Gui = False,
    as_json: Json = False,
) -> None:
    """Execute a motion by itself in a scene that is drawn from the task's placements."""
    from pft_exec import execute as execute_tube

    swaps = _substitutions(substitute)
    with _stage(library, motion, robot, task, tool, arm, mirror, seed, gui, grasp, swaps) as (world, known):
        tube = known[motion].flow_tube(world.scene, world.tool(arm), swaps)
        run = execute_tube(
            world, tube, arm, avoid=avoid or (), pace=pace, softness=softness, solver=solver, substitute=swaps
        )
    _report_run(run, log, plot, as_json)


@command("assist library.h5 reach --seed 7 --log run.h5 --plot seam.png")
def assist(
    library: LibraryFile,
    motion: Annotated[str, typer.Argument(help="Motion that the synthetic hand begins, without saying so.")],
    robot: Robot = "pr2",
    task: Task = "tabletop",
    tool: Tool = None,
    arm: ArmName = None,
    mirror: Mirror = False,
    grasp: Grasp = "friction",
    ask: Annotated[bool, typer.Option("--ask", help="Ask you, not the hand, where two motions are close.")] = False,
    take_back: Annotated[
        list[str] | None,
        typer.Option(help="The hand takes the arm back for a motion, at a place from 0 to 1: reach@0.4. Repeatable."),
    ] = None,
    let_go: Annotated[float, typer.Option(help="s over which the hand's force fades at a take-over.", min=0.0)] = 0.15,
    pace: Pace = 1.0,
    softness: Softness = 0.1,
    solver: Solver = "daqp",
    seed: Seed = 0,
    log: Log = None,
    plot: Plot = None,
    gui: Gui = False,
    as_json: Json = False,
) -> None:
    """A hand begins a motion; the robot recognizes it, takes over and finishes it."""
    from pft_exec import assist as assist_hand

    answer, plans = _ask if ask else None, [_take_back_plan(text) for text in take_back or ()]
    with _stage(library, motion, robot, task, tool, arm, mirror, seed, gui, grasp, bar=not ask) as (world, known):
        run = assist_hand(
            world,
            known,
            motion,
            arm,
            seed=seed,
            answer=answer,
            take_backs=plans,
            let_go=let_go,
            pace=pace,
            softness=softness,
            solver=solver,
        )
    _report_run(run, log, plot, as_json)


def _take_back_plan(text: str) -> TakeBackPlan:
    """``reach@0.4``: taken back for "reach" once the robot is at 0.4 of its motion."""
    from pft_exec.execution import TakeBackPlan

    label, _, place = text.partition("@")
    try:
        phase = float(place)
    except ValueError as error:
        raise typer.BadParameter(f"say which motion and at which place, such as reach@0.4; got {text!r}.") from error
    if not (label and 0.0 <= phase <= 1.0):
        raise typer.BadParameter(f"a motion, and a place between 0 and 1, such as reach@0.4; got {text!r}.")
    return TakeBackPlan(label, phase=phase)


def _ask(labels: tuple[str, ...], belief: Belief) -> str | None:
    """Ask the user which of some motions the hand makes; None is none of them."""
    choices = [f"{label} ({belief.probability[label]:.0%})" for label in labels]
    for number, choice in enumerate(choices, start=1):
        typer.echo(f"{number}: {choice}", err=True)
    chosen = typer.prompt("Which of these does the hand make? 0 is none", type=int, default=0, err=True)
    return labels[chosen - 1] if 1 <= chosen <= len(labels) else None


@contextmanager
def _stage(
    library: Path,
    motion: str,
    robot: str,
    task: str,
    tool: str | None,
    arm: str | None,
    mirror: bool,
    seed: int,
    gui: bool,
    grasp: str,
    substitute: Mapping[str, str] | None = None,
    bar: bool = True,
) -> Iterator[tuple[World, MotionLibrary]]:
    """A world set up for a motion of the task, and a library that knows it, as the arm makes its motions."""
    from pft_exec import MotionLibrary, World, load_robot
    from pft_exec.execution import prepare

    known = MotionLibrary.load(library)
    known[motion]  # refused before any world opens
    with progress(motion, bar), World(load_robot(robot, tool), task, gui=gui, seed=seed, grasp=grasp) as world:
        prepare(world, motion, arm, seed=seed, substitute=substitute)
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
