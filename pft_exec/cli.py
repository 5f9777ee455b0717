"""The command line: arguments, calls and printing; everything it does can be done from Python with the same names."""

from __future__ import annotations

import json
import os
import random
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from pft_exec import __version__
from pft_exec.exceptions import PFTError

if TYPE_CHECKING:
    from pft_exec.demonstration import Demonstration
    from pft_exec.execution import ExecutionLog
    from pft_exec.simulation import World

app = typer.Typer(
    name="pft-exec", no_args_is_help=True, add_completion=False, rich_markup_mode="rich", pretty_exceptions_enable=False
)

Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
Seed = Annotated[int, typer.Option(help="Same seed, same numbers.", min=0)]
Robot = Annotated[str, typer.Option(help="Name of a robot, or path of a folder with a robot.toml.")]
Task = Annotated[str, typer.Option(help="Name of a task, or path of a folder with a task.toml.")]
ArmName = Annotated[str | None, typer.Option(help="Arm of the robot; the only one, else right.")]
Gui = Annotated[bool, typer.Option("--gui", help="Show the world in a window.")]
Plot = Annotated[Path | None, typer.Option(help="Write a picture (.png, .pdf, .svg).")]
Log = Annotated[Path | None, typer.Option("--out", help="Write the log of the run (HDF5).")]
LibraryFile = Annotated[Path, typer.Argument(help="Motion library (HDF5) that `learn` wrote.")]
DemonstrationFile = Annotated[Path, typer.Argument(help="Demonstrations (HDF5) that `teach` or `convert` wrote.")]
Mirror = Annotated[bool, typer.Option("--mirror", help="The library was taught with the other arm.")]
Substitute = Annotated[list[str] | None, typer.Option(help="Object in place of the taught one, such as bottle=can.")]
Strict = Annotated[bool, typer.Option("--strict", help="Exit status 1 where a figure misses its floor.")]

Command = TypeVar("Command", bound=Callable[..., None])


def _command(example: str) -> Callable[[Command], Command]:
    """Register a command whose help closes with an example."""
    return app.command(epilog=f"Example: [bold]pft-exec {example}[/bold]")


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(__version__)
        raise typer.Exit


@app.callback()
def _about(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print it.")
    ] = False,
) -> None:
    """Teach a robot arm by hand; learn, recognize and execute motions as probabilistic flow tubes."""


# --- printing -----------------------------------------------------------------------------------------------------


@contextmanager
def _progress(stage: str) -> Iterator[Callable[[str, float], None]]:
    """A bar on standard error; the function that moves it takes the stage and the share done, 0 to 1."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(stage, total=None)

        def advance(stage: str, done: float) -> None:
            bar.update(task, description=stage, total=1.0, completed=done)

        yield advance


def _text(value: Any) -> str:
    """A cell: floats with four digits, flags as words."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    return "" if value is None else str(value)


def _print_rows(title: str, rows: Sequence[Mapping[str, Any]]) -> None:
    """A table with a column per key of the first row."""
    columns = list(rows[0]) if rows else []
    table = Table(*columns, title=title, title_justify="left")
    for row in rows:
        table.add_row(*(_text(row.get(column)) for column in columns))
    Console().print(table)


def _print_result(as_json: bool, title: str, rows: Sequence[Mapping[str, Any]], result: Mapping[str, Any]) -> None:
    """The result as JSON, or its rows as a table."""
    if as_json:
        typer.echo(json.dumps(result, indent=2, default=_plain))
    else:
        _print_rows(title, rows)


def _print_tables(as_json: bool, result: Mapping[str, Any]) -> None:
    """JSON, or each table of a result: ``{"tables": {title: rows}, ...}``."""
    if as_json:
        typer.echo(json.dumps(result, indent=2, default=_plain))
        return
    for title, rows in result["tables"].items():
        _print_rows(title, rows)


def _plain(value: Any) -> Any:
    """What JSON can hold of an array, a numpy number or a path."""
    return value.tolist() if hasattr(value, "tolist") else str(value)


# --- from teaching to recognition -----------------------------------------------------------------------------------


@_command("teach demonstrations.h5 --motion reach --motion go_home --count 5 --seed 1")
def teach(
    out: Annotated[Path, typer.Argument(help="Demonstrations to write (HDF5).")],
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
    demonstrations: list[Demonstration] = []
    with _progress("opening the world") as advance, World(robot, description, gui=gui, seed=seed) as world:
        for place, label in enumerate(labels):
            description.motion(label)
            advance(f"teaching {label}", place / len(labels))
            demonstrations += teach_motion(world, label, arm, count)
    save_demonstrations(out, demonstrations)
    _report_demonstrations(demonstrations, out, as_json)


@_command("convert recordings.npz demonstrations.h5 --summary")
def convert(
    source: Annotated[Path, typer.Argument(help="Recordings of others: .npz or .csv.")],
    target: Annotated[Path, typer.Argument(help="Demonstrations to write (HDF5).")],
    scale: Annotated[float, typer.Option(help="What one unit of the file's positions is in m.")] = 1.0,
    summary: Annotated[bool, typer.Option("--summary", help="Print a row for each motion.")] = False,
    as_json: Json = False,
) -> None:
    """Convert recordings that others made into demonstrations."""
    from pft_exec import convert_recordings, save_demonstrations

    demonstrations = convert_recordings(source, scale)
    save_demonstrations(target, demonstrations)
    if summary or as_json:
        _report_demonstrations(demonstrations, target, as_json)
    else:
        typer.echo(f"{len(demonstrations)} demonstrations in {target}")


def _report_demonstrations(demonstrations: Sequence[Demonstration], path: Path, as_json: bool) -> None:
    from pft_exec.report import demonstration_rows

    rows = demonstration_rows(demonstrations)
    _print_result(as_json, f"{len(demonstrations)} demonstrations in {path}", rows, {"file": path, "motions": rows})


@_command("learn demonstrations.h5 library.h5 --count 5 --held-out rest.h5")
def learn(
    demonstrations: DemonstrationFile,
    out: Annotated[Path, typer.Argument(help="Motion library to write (HDF5).")],
    method: Annotated[str, typer.Option(help="robust or dong2012.")] = "robust",
    count: Annotated[int | None, typer.Option(help="Learn from so many of each motion; default: all.", min=2)] = None,
    held_out: Annotated[Path | None, typer.Option(help="Write the demonstrations that --count left over.")] = None,
    seed: Annotated[int | None, typer.Option(help="Draw the --count at random; default: the first ones.")] = None,
    as_json: Json = False,
) -> None:
    """Learn a motion library, and print which motion variables are relevant and the numbers that decided it."""
    from pft_exec import learn_library, load_demonstrations, save_demonstrations
    from pft_exec.report import decision_rows

    taught = load_demonstrations(demonstrations)
    chosen, rest = (taught, []) if count is None else _split(taught, count, seed)
    with _progress("learning"):
        library = learn_library(chosen, method)
    library.save(out)
    if held_out is not None:
        save_demonstrations(held_out, rest)
    decisions = {label: library[label].variables.to_dict() for label in library.labels}
    result = {"file": out, "method": method, "learned_from": len(chosen), "held_out": len(rest), "motions": decisions}
    _print_result(as_json, f"{len(library)} motions in {out}", decision_rows(library), result)
    if not as_json:
        typer.echo(library.describe())


def _split(taught: Sequence[Demonstration], count: int, seed: int | None) -> tuple[list[Any], list[Any]]:
    """`count` demonstrations of each label, and the rest."""
    order = list(range(len(taught)))
    if seed is not None:
        random.Random(seed).shuffle(order)  # noqa: S311 - a draw, no secret
    chosen: list[int] = []
    for label in dict.fromkeys(demonstration.label for demonstration in taught):
        chosen += [place for place in order if taught[place].label == label][:count]
    return [taught[i] for i in sorted(chosen)], [d for i, d in enumerate(taught) if i not in chosen]


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
    right = sum(result.is_right for result in results)
    rows = recognition_rows(results)
    _print_result(as_json, f"{right} of {len(rows)} recognized", rows, {"recognized": right, "recordings": rows})
    if plot is not None:
        plot_beliefs(results, plot)


# --- execution ------------------------------------------------------------------------------------------------------


@_command("execute library.h5 reach --seed 7 --out run.h5 --plot seam.png")
def execute(
    library: LibraryFile,
    motion: Annotated[str, typer.Argument(help="Motion of the library.")],
    robot: Robot = "pr2",
    task: Task = "tabletop",
    arm: ArmName = None,
    mirror: Mirror = False,
    substitute: Substitute = None,
    seed: Seed = 0,
    out: Log = None,
    plot: Plot = None,
    gui: Gui = False,
    as_json: Json = False,
) -> None:
    """Execute a motion by itself in a scene that is drawn from the task's placements."""
    from pft_exec import MotionLibrary
    from pft_exec import execute as execute_tube

    known = MotionLibrary.load(library)
    known[motion]
    with _progress(f"executing {motion}"), _world(robot, task, arm, seed, gui) as world:
        known = known.mirrored(world.base) if mirror else known
        tube = known[motion].flow_tube(world.scene, world.tool(arm), _substitutions(substitute))
        log = execute_tube(world, tube, arm)
    _report_run(log, out, plot, as_json)


@_command("assist library.h5 reach --seed 7 --out run.h5 --plot seam.png")
def assist(
    library: LibraryFile,
    motion: Annotated[str, typer.Argument(help="Motion that the synthetic hand begins, without saying so.")],
    robot: Robot = "pr2",
    task: Task = "tabletop",
    arm: ArmName = None,
    mirror: Mirror = False,
    seed: Seed = 0,
    out: Log = None,
    plot: Plot = None,
    gui: Gui = False,
    as_json: Json = False,
) -> None:
    """A hand begins a motion; the robot recognizes it, takes over and finishes it."""
    from pft_exec import MotionLibrary
    from pft_exec import assist as assist_hand

    known = MotionLibrary.load(library)
    known[motion]
    with _progress(f"assisting {motion}"), _world(robot, task, arm, seed, gui) as world:
        log = assist_hand(world, known.mirrored(world.base) if mirror else known, motion, arm)
    _report_run(log, out, plot, as_json)


@contextmanager
def _world(robot: str, task: str, arm: str | None, seed: int, gui: bool) -> Iterator[World]:
    """A world in a scene drawn for that arm."""
    from pft_exec import World

    with World(robot, task, gui=gui, seed=seed) as world:
        world.reset(world.draw_scene(seed, arm))
        yield world


def _substitutions(pairs: Sequence[str] | None) -> dict[str, str]:
    """``["bottle=can"]`` as a mapping from the taught object to the one that takes its place."""
    named = dict(pair.partition("=")[::2] for pair in pairs or ())
    if not all(named) or not all(named.values()):
        raise typer.BadParameter("a substitution names two objects, such as bottle=can.")
    return named


def _report_run(log: ExecutionLog, out: Path | None, plot: Path | None, as_json: bool) -> None:
    from pft_exec.report import log_rows, log_summary, plot_seam

    if out is not None:
        log.save(out)
    if plot is not None:
        plot_seam(log, plot)
    _print_result(as_json, f"{log.label}: {log.reason}", log_rows(log), log_summary(log))


# --- evidence -------------------------------------------------------------------------------------------------------


@_command("demo --out runs/demo --seed 0")
def demo(
    out: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("runs/demo"),
    seed: Seed = 0,
    video: Annotated[bool, typer.Option(help="Write demo.mp4.")] = True,
    strict: Strict = False,
    as_json: Json = False,
) -> None:
    """Teach four motions on the PR2, learn, recognize, take over and finish, with both arms; write a report."""
    from pft_exec.evaluation.demo import run_demo

    with _progress("opening the world") as advance:
        report = run_demo(out, seed=seed, progress=advance, video=video)
    _report_figures(as_json, f"report in {out}", report, strict)


@_command("evaluate --seeds 20 --out runs/evaluation")
def evaluate(
    seeds: Annotated[int, typer.Option(help="Number of runs of the demo.", min=1)] = 20,
    seed: Annotated[int, typer.Option(help="Seed of the first run.", min=0)] = 0,
    jobs: Annotated[int, typer.Option(help="Processes.", min=1)] = 1,
    out: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("runs/evaluation"),
    strict: Strict = False,
    as_json: Json = False,
) -> None:
    """Run the demo over many seeds and hold every figure against its floor."""
    from pft_exec.evaluation.study import run_study

    with _progress("evaluating") as advance:
        report = run_study(range(seed, seed + seeds), out=out, jobs=jobs, progress=advance)
    _report_figures(as_json, f"report in {out}", report, strict)


def _report_figures(as_json: bool, title: str, report: Mapping[str, Any], strict: bool) -> None:
    """The table of figures that closes a report; with `strict`, exit status 1 where a floor is missed."""
    rows = [{"figure": name, **figure} for name, figure in report["figures"].items()]
    _print_result(as_json, title, rows, report)
    if strict and not all(row["ok"] for row in rows):
        raise typer.Exit(1)


@_command("reproduce table1 --seeds 5")
def reproduce(
    what: Annotated[str, typer.Argument(help="Table or figure of the paper: table1, table2, real, all.")],
    seeds: Annotated[int, typer.Option(help="Number of seeds.", min=1)] = 5,
    out: Annotated[Path | None, typer.Option(help="Folder for the result and its pictures.")] = None,
    as_json: Json = False,
) -> None:
    """Reproduce a table of the paper, ours and its baselines beside the published figures."""
    from pft_exec.evaluation import reproduce as reproduce_tables

    with _progress(f"reproducing {what}") as advance:
        result = reproduce_tables(what, seeds=seeds, out=out, progress=advance)
    _print_tables(as_json, result)


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
    _print_tables(as_json, result)


@_command("show library.h5")
def show(
    file: Annotated[Path, typer.Argument(help="Demonstrations, motion library, or log of a run (HDF5).")],
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Show what a file holds: a table, and with --plot a picture."""
    from pft_exec.report import plot_contents, read_contents

    contents = read_contents(file)
    _print_result(as_json, contents.title, contents.rows, {"file": file, "kind": contents.kind, "rows": contents.rows})
    if plot is not None:
        plot_contents(contents, plot)


@_command("check robot my_robot/")
def check(
    kind: Annotated[str, typer.Argument(help="robot or task.")],
    name: Annotated[str, typer.Argument(help="Its name, or the path of its folder.")],
    as_json: Json = False,
) -> None:
    """Check a robot or task of yours, and say what to mend."""
    from pft_exec.report.check import check_description

    with _progress(f"checking {name}"):
        rows = check_description(kind, name)
    _print_result(as_json, f"{kind} {name}", rows, {"checks": rows})
    if not all(row["ok"] for row in rows):
        raise typer.Exit(1)


# --- entry ----------------------------------------------------------------------------------------------------------


def run(arguments: Sequence[str]) -> int:
    """Run the command line and return its exit status: 0, 1 where a check failed, 2 for a mistake of the user's."""
    try:
        status = app(list(arguments), prog_name="pft-exec", standalone_mode=False)
    except typer.TyperException as mistake:
        return _complain(mistake.format_message())
    except (PFTError, OSError) as mistake:
        return _complain(str(mistake))
    return status if isinstance(status, int) else 0


def _complain(message: str) -> int:
    if message:  # none where the help was printed instead
        typer.echo(f"pft-exec: {' '.join(message.split())}", err=True)
    return 2


def main() -> None:
    """Entry of ``pft-exec``."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # small matrices: threads cost more than they bring
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.exit(run(sys.argv[1:]))
