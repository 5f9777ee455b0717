"""Commands that move a robot: `execute` and `assist`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pft_exec.cli.application import command
from pft_exec.cli.options import LibraryFile
from pft_exec.cli.run_options import RunOptions, with_options
from pft_exec.cli.terminal import print_tables, progress

if TYPE_CHECKING:
    from pft_exec.execution import ExecutionLog, TakeBackPlan
    from pft_exec.learning import MotionLibrary
    from pft_exec.recognition import Belief
    from pft_exec.simulation import World


@command("execute library.h5 reach --seed 7 --log run.h5 --plot run.png")
@with_options(RunOptions)
def execute(
    library: LibraryFile,
    motion: Annotated[str, typer.Argument(help="Motion of the library.")],
    options: RunOptions,
) -> None:
    """Execute a motion by itself in a scene that is drawn from the task's placements."""
    from pft_exec import execute as execute_tube

    with _stage(library, motion, options) as (world, known):
        tube = known[motion].flow_tube(world.scene, world.tool(options.arm), options.swaps)
        run = execute_tube(world, tube, options.arm, **options.of_a_run())
    _report_run(run, options)


@command("assist library.h5 reach --seed 7 --log run.h5 --plot seam.png")
@with_options(RunOptions)
def assist(
    library: LibraryFile,
    motion: Annotated[str, typer.Argument(help="Motion that the synthetic hand begins, without saying so.")],
    options: RunOptions,
    ask: Annotated[bool, typer.Option("--ask", help="Ask you, not the hand, where two motions are close.")] = False,
    take_back: Annotated[
        list[str] | None,
        typer.Option(help="The hand takes the arm back for a motion, at a place from 0 to 1: reach@0.4. Repeatable."),
    ] = None,
    let_go: Annotated[float, typer.Option(help="s over which the hand's force fades at a take-over.", min=0.0)] = 0.15,
) -> None:
    """A hand begins a motion; the robot recognizes it, takes over and finishes it."""
    from pft_exec import assist as assist_hand

    answer, plans = _ask if ask else None, [_take_back_plan(text) for text in take_back or ()]
    with _stage(library, motion, options, bar=not ask) as (world, known):
        run = assist_hand(
            world,
            known,
            motion,
            options.arm,
            seed=options.seed,
            answer=answer,
            take_backs=plans,
            let_go=let_go,
            **options.of_a_run(),
        )
    _report_run(run, options)


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
def _stage(library: Path, motion: str, options: RunOptions, bar: bool = True) -> Iterator[tuple[World, MotionLibrary]]:
    """A world set up for a motion of the task, and a library that knows it, as the arm makes its motions."""
    from pft_exec import MotionLibrary, World, load_robot
    from pft_exec.execution import prepare

    known = MotionLibrary.load(library)
    swaps, robot, seed = options.swaps, load_robot(options.robot, options.tool), options.seed
    known[motion]  # refused before any world opens, as are substitutes of what nobody taught
    known.check_substitute(swaps)
    with progress(motion, bar), World(robot, options.task, gui=options.gui, seed=seed, grasp=options.grasp) as world:
        prepare(world, motion, options.arm, seed=seed, substitute=swaps)
        yield world, known.mirrored(world.base) if options.mirror else known


def _report_run(run: ExecutionLog, options: RunOptions) -> None:
    from pft_exec.report import log_rows, log_summary, plot_log

    if options.log is not None:
        run.save(options.log)
    if options.plot is not None:
        plot_log(run, options.plot)
    print_tables(options.as_json, log_summary(run), {run.reason: log_rows(run)})
