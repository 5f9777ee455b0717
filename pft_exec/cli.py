"""The command line: arguments, calls and printing; everything it does can be done from Python with the same names."""

from __future__ import annotations

import json
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column, Table

from pft_exec import __version__
from pft_exec.exceptions import PFTError

if TYPE_CHECKING:
    from pft_exec.demonstration import Demonstration
    from pft_exec.execution import ExecutionLog
    from pft_exec.learning import MotionLibrary
    from pft_exec.simulation import World

app = typer.Typer(add_completion=False, rich_markup_mode="rich", pretty_exceptions_enable=False)

Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
Seed = Annotated[int, typer.Option(help="Same seed, same numbers.", min=0)]
Robot = Annotated[str, typer.Option(help="Name of a robot, or path of a folder with a robot.toml.")]
Task = Annotated[str, typer.Option(help="Name of a task, or path of a folder with a task.toml.")]
ArmName = Annotated[str | None, typer.Option(help="Arm of the robot; default: the only one, else right.")]
Gui = Annotated[bool, typer.Option("--gui", help="Show the world in a window.")]
Plot = Annotated[Path | None, typer.Option(help="Write a picture (.png, .pdf, .svg).")]
Log = Annotated[Path | None, typer.Option(help="Write the log of the run (HDF5).")]
Mirror = Annotated[bool, typer.Option("--mirror", help="The library was taught with the other arm.")]
Substitute = Annotated[list[str] | None, typer.Option(help="Object in place of the taught one, such as bottle=can.")]
Strict = Annotated[bool, typer.Option("--strict", help="Exit status 1 where a figure misses its floor.")]
LibraryFile = Annotated[Path, typer.Argument(help="Motion library (HDF5) that `learn` wrote.")]
DemonstrationFile = Annotated[Path, typer.Argument(help="Demonstrations (HDF5) that `teach` or `convert` wrote.")]


def _named_h5(path: Path) -> Path:
    if path.suffix not in (".h5", ".hdf5"):
        raise typer.BadParameter(f"a file to write is named .h5 or .hdf5; got {str(path)!r}.")
    return path


Written = Annotated[Path, typer.Argument(help="File to write (HDF5, .h5).", callback=_named_h5)]


def _command(example: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Register a command whose help closes with an example."""
    return app.command(epilog=f"Example: [bold]pft-exec {example}[/bold]")


@app.callback(invoke_without_command=True)
def _about(
    context: typer.Context, version: Annotated[bool, typer.Option("--version", help="Print it.")] = False
) -> None:
    """Teach a robot arm by hand; learn, recognize and execute motions as probabilistic flow tubes."""
    if context.invoked_subcommand is None:
        typer.echo(__version__ if version else context.get_help())


@contextmanager
def _progress(stage: str) -> Iterator[Callable[[str, float], None]]:
    """A bar on standard error; the function that moves it takes the stage and the share done, 0 to 1."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(stage, total=None)
        yield lambda stage, done: bar.update(task, description=stage, total=1.0, completed=done)


def _print_tables(as_json: bool, result: Mapping[str, Any], tables: Mapping[str, Sequence[Mapping[str, Any]]]) -> None:
    """The result as JSON, or its tables, {title: rows}, with a column per key of the first row."""
    if as_json:
        typer.echo(json.dumps(result, indent=2, default=lambda value: getattr(value, "tolist", value.__str__)()))
        return
    from pft_exec.report.tables import cell_text

    console = Console(width=None if sys.stdout.isatty() else 160)  # characters, where it goes to a file
    for title, rows in tables.items():
        names = list(rows[0]) if rows else []
        columns = (Column(name, overflow="fold") for name in names)
        table = Table(*columns, title=title, title_justify="left", box=SIMPLE_HEAD)
        for row in rows:
            table.add_row(*(cell_text(row.get(name)) for name in names))
        console.print(table if rows else title, markup=False)


@_command("teach demonstrations.h5 --motion reach --motion go_home --count 5 --seed 1")
def teach(
    out: Written,
    motion: Annotated[list[str] | None, typer.Option(help="Motion of the task; may be repeated. Default: all.")] = None,
    count: Annotated[int, typer.Option(help="Demonstrations of each motion.", min=1)] = 5,
    robot: Robot = "pr2",
    task: Task = "tabletop",
    arm: ArmName = None,
    seed: Seed = 0,
    gui: Gui = False,
    as_json: Json = False,
) -> None:
    """Teach motions in simulation: a synthetic hand guides the floating arm, and what the arm did is recorded."""
    from pft_exec import World, load_task, save_demonstrations
    from pft_exec import teach as teach_motion

    description = load_task(task)
    labels = motion or list(description.labels)
    [description.motion(label) for label in labels]  # refused before any world opens
    demonstrations: list[Demonstration] = []
    with _progress("opening the world") as advance, World(robot, description, gui=gui, seed=seed) as world:
        for place, label in enumerate(labels):
            advance(f"teaching {label}", place / len(labels))
            demonstrations += teach_motion(world, label, arm, count, seed=seed)
    save_demonstrations(out, demonstrations)
    _report_demonstrations(demonstrations, out, as_json)


@_command("convert recordings.npz demonstrations.h5 --summary")
def convert(
    source: Annotated[Path, typer.Argument(help="Recordings of others: .npz or .csv.")],
    target: Written,
    scale: Annotated[float, typer.Option(help="What one unit of the file's positions is in m.")] = 1.0,
    summary: Annotated[bool, typer.Option("--summary", help="Print a row for each motion.")] = False,
    as_json: Json = False,
) -> None:
    """Convert recordings that others made into demonstrations."""
    from pft_exec import convert_recordings, save_demonstrations

    demonstrations = convert_recordings(source, scale)
    save_demonstrations(target, demonstrations)
    _report_demonstrations(demonstrations, target, as_json, summary)


def _report_demonstrations(taught: Sequence[Demonstration], path: Path, as_json: bool, table: bool = True) -> None:
    from pft_exec.report import demonstration_rows

    rows = demonstration_rows(taught)
    _print_tables(as_json, {"file": path, "motions": rows}, {f"{len(taught)} demonstrations in {path}": rows * table})


@_command("learn demonstrations.h5 library.h5 --count 5 --held-out rest.h5")
def learn(
    demonstrations: DemonstrationFile,
    library: Written,
    method: Annotated[str, typer.Option(help="robust or dong2012.")] = "robust",
    count: Annotated[int | None, typer.Option(help="Learn from so many of each motion; default: all.", min=2)] = None,
    held_out: Annotated[Path | None, typer.Option(help="Write the demonstrations that --count left over.")] = None,
    seed: Annotated[int | None, typer.Option(help="Draw the --count at random; default: the first ones.")] = None,
    as_json: Json = False,
) -> None:
    """Learn a motion library, and print which motion variables are relevant and the numbers that decided it."""
    from pft_exec import learn_library, load_demonstrations, save_demonstrations
    from pft_exec.report import decision_rows, hold_out

    taught = load_demonstrations(demonstrations)
    chosen, rest = (taught, []) if count is None else hold_out(taught, count, seed)
    with _progress("learning"):
        learned = learn_library(chosen, method)
    learned.save(library)
    if held_out is not None:
        save_demonstrations(held_out, rest)
    decisions = {label: learned[label].variables.to_dict() for label in learned.labels}
    result = {"file": library, "learned_from": len(chosen), "held_out": len(rest), "motions": decisions}
    _print_tables(as_json, result, {f"{library}: learned from {len(chosen)} demonstrations": decision_rows(learned)})


@_command("recognize library.h5 rest.h5 --plot belief.png")
def recognize(
    library: LibraryFile,
    recordings: DemonstrationFile,
    method: Annotated[str, typer.Option(help="phase or dong2012.")] = "phase",
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Recognize recordings sample by sample, as if they were under way: label, probability, when it was decided."""
    from pft_exec import MotionLibrary, load_demonstrations
    from pft_exec.report import plot_beliefs, recognition_rows, recognize_stream

    known, streams = MotionLibrary.load(library), load_demonstrations(recordings)
    results = []
    with _progress("recognizing") as advance:
        for place, stream in enumerate(streams):
            results.append(recognize_stream(known, stream, method))
            advance("recognizing", (place + 1) / len(streams))
    if plot is not None:
        plot_beliefs(results, plot)
    right, rows = sum(result.is_right for result in results), recognition_rows(results)
    _print_tables(as_json, {"recognized": right, "recordings": rows}, {f"{right} of {len(rows)} recognized": rows})


@_command("execute library.h5 reach --seed 7 --log run.h5 --plot run.png")
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


@_command("assist library.h5 reach --seed 7 --log run.h5 --plot seam.png")
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
    with _progress(motion), World(robot, task, gui=gui, seed=seed) as world:
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
    _print_tables(as_json, log_summary(run), {run.reason: log_rows(run)})


@_command("demo --out runs/demo --seed 0")
def demo(
    out: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("runs/demo"),
    seed: Seed = 0,
    video: Annotated[bool, typer.Option(help="Write demo.mp4.")] = True,
    strict: Strict = False,
    as_json: Json = False,
) -> None:
    """Teach four motions on the PR2, learn, recognize, take over and finish, with both arms; write a report."""
    from pft_exec.evaluation.demo import report_tables, run_demo

    with _progress("opening the world") as advance:
        report = run_demo(out, seed=seed, progress=advance, video=video)
    _report_figures(report, report_tables(report), out, strict, as_json)


@_command("evaluate --seeds 20 --out runs/evaluation")
def evaluate(
    seeds: Annotated[int, typer.Option(help="Number of runs of the demo, from --seed up.", min=1)] = 20,
    seed: Seed = 0,
    jobs: Annotated[int, typer.Option(help="Processes.", min=1)] = 1,
    out: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("runs/evaluation"),
    strict: Strict = False,
    as_json: Json = False,
) -> None:
    """Run the demo over many seeds and hold every figure against its floor."""
    from pft_exec.evaluation.study import run_study

    with _progress("evaluating") as advance:
        report = run_study(range(seed, seed + seeds), out=out, jobs=jobs, progress=advance)
    _report_figures(report, {}, out, strict, as_json)


def _report_figures(
    report: Mapping[str, Any], before: Mapping[str, Any], out: Path, strict: bool, as_json: bool
) -> None:
    """Tables of what was found, and the table of figures that closes a report."""
    rows = [{"figure": name, **figure} for name, figure in report["figures"].items()]
    _print_tables(as_json, report, {**before, f"figures; report in {out}": rows})
    if strict and not all(row["ok"] for row in rows):
        raise typer.Exit(1)


@_command("reproduce table1 --seeds 5 --out runs/table1")
def reproduce(
    what: Annotated[str, typer.Argument(help="Table or figure of the paper: table1, table2, real, all.")],
    seeds: Annotated[int, typer.Option(help="Number of seeds.", min=1)] = 5,
    out: Annotated[Path | None, typer.Option(help="Folder for the full result and its pictures.")] = None,
    as_json: Json = False,
) -> None:
    """Reproduce a table of the paper, ours and its baselines beside the published figures."""
    from pft_exec.evaluation import reproduce as reproduce_tables

    with _progress(f"reproducing {what}") as advance:
        result = reproduce_tables(what, seeds=seeds, out=out, progress=advance)
    _print_tables(as_json, result, result["tables"])


@_command("benchmark recognition")
def benchmark(
    what: Annotated[str, typer.Argument(help="recognition, learning or control.")],
    seed: Seed = 0,
    as_json: Json = False,
) -> None:
    """Time a part, with the alternatives in the same run."""
    from pft_exec.evaluation import benchmark as run_benchmark

    with _progress(f"timing {what}") as advance:
        result = run_benchmark(what, seed=seed, progress=advance)
    _print_tables(as_json, result, result["tables"])


@_command("show library.h5 --plot tubes.png")
def show(
    file: Annotated[Path, typer.Argument(help="Demonstrations, motion library, or log of a run (HDF5).")],
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Show what a file holds: a table, and with --plot a picture."""
    from pft_exec.report import plot_contents, read_contents

    contents = read_contents(file)
    if plot is not None:
        plot_contents(contents, plot)
    _print_tables(as_json, {"kind": contents.kind, "rows": contents.rows}, {contents.title: contents.rows})


@_command("check robot my_robot/")
def check(
    kind: Annotated[str, typer.Argument(help="robot or task.")],
    name: Annotated[str, typer.Argument(help="Its name, or the path of its folder.")],
    as_json: Json = False,
) -> None:
    """Check a robot or task of yours, and say what to mend; exit status 1 where something is to be mended."""
    from pft_exec.report.check import check_description

    with _progress(f"checking {name}"):
        rows = check_description(kind, name)
    _print_tables(as_json, {"checks": rows}, {f"{kind} {name}": rows})
    if not all(row["ok"] for row in rows):
        raise typer.Exit(1)


def run(arguments: Sequence[str]) -> int:
    """Run the command line and return its exit status: 0, 1 where a check failed, 2 for a mistake of the user's."""
    try:
        with warnings.catch_warnings():
            warnings.showwarning = lambda message, *_: _say(f"warning: {message}")
            status = app(list(arguments), prog_name="pft-exec", standalone_mode=False)
    except (typer.TyperException, PFTError, OSError) as mistake:
        _say(mistake.format_message() if isinstance(mistake, typer.TyperException) else str(mistake))
        return 2
    return status if isinstance(status, int) else 0


def _say(message: str) -> None:
    """One line on standard error."""
    typer.echo(f"pft-exec: {' '.join(message.split())}", err=True)


def main() -> None:
    """Entry of ``pft-exec``."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # small matrices: threads cost more than they bring
        os.environ.setdefault(name, "1")
    sys.exit(run(sys.argv[1:]))
