"""Commands that make demonstrations: `teach` and `convert`."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pft_exec.cli.application import command
from pft_exec.cli.options import ArmName, Grasp, Gui, Json, Robot, Seed, Task, Tool, Written
from pft_exec.cli.terminal import print_tables, progress

if TYPE_CHECKING:
    from pft_exec.demonstration import Demonstration


@command("teach demonstrations.h5 --motion reach --motion go_home --count 5 --seed 1")
def teach(
    out: Written,
    motion: Annotated[list[str] | None, typer.Option(help="Motion of the task; may be repeated. Default: all.")] = None,
    count: Annotated[int, typer.Option(help="Demonstrations of each motion.", min=1)] = 5,
    robot: Robot = "pr2",
    task: Task = "tabletop",
    tool: Tool = None,
    arm: ArmName = None,
    grasp: Grasp = "friction",
    seed: Seed = 0,
    gui: Gui = False,
    as_json: Json = False,
) -> None:
    """Teach motions in simulation: a synthetic hand guides the floating arm, and what the arm did is recorded.

    Until the file is written, each recording is on disk in a folder beside it, sample by sample: `convert` makes
    demonstrations of what a killed run left there.
    """
    from pft_exec import World, load_robot, load_task, save_demonstrations
    from pft_exec import teach as teach_motion

    description = load_task(task)
    labels = motion or list(description.labels)
    [description.motion(label) for label in labels]  # refused before any world opens
    demonstrations: list[Demonstration] = []
    model, record = load_robot(robot, tool), _recordings_beside(out)
    with progress("opening the world") as advance, World(model, description, gui=gui, seed=seed, grasp=grasp) as world:
        for place, label in enumerate(labels):
            advance(f"teaching {label}", place / len(labels))
            demonstrations += teach_motion(world, label, arm, count, seed=seed, record=record)
    save_demonstrations(out, demonstrations)
    shutil.rmtree(record)
    _report_demonstrations(demonstrations, out, as_json)


def _recordings_beside(out: Path) -> Path:
    """The folder of the recordings that are under way."""
    folder = out.with_name(f"{out.stem}.recordings")
    if folder.is_dir() and any(folder.iterdir()):
        raise typer.BadParameter(
            f"{folder} holds recordings of a run that was interrupted. Keep them with `pft-exec convert {folder} "
            f"rescued.h5` and remove the folder, or write to another file."
        )
    return folder


@command("convert recordings.npz demonstrations.h5 --summary")
def convert(
    source: Annotated[
        Path, typer.Argument(help="Recordings of others: .npz or .csv; or the folder that an interrupted `teach` left.")
    ],
    target: Written,
    scale: Annotated[float, typer.Option(help="What one unit of the file's positions is in m.")] = 1.0,
    summary: Annotated[bool, typer.Option("--summary", help="Print a row for each motion.")] = False,
    as_json: Json = False,
) -> None:
    """Convert recordings that others made into demonstrations."""
    from pft_exec import convert_recordings, save_demonstrations
    from pft_exec.demonstration import recover_recordings

    demonstrations = recover_recordings(source) if source.is_dir() else convert_recordings(source, scale)
    save_demonstrations(target, demonstrations)
    _report_demonstrations(demonstrations, target, as_json, summary)


def _report_demonstrations(taught: Sequence[Demonstration], path: Path, as_json: bool, table: bool = True) -> None:
    from pft_exec.report import demonstration_rows

    rows = demonstration_rows(taught)
    print_tables(as_json, {"file": path, "motions": rows}, {f"{len(taught)} demonstrations in {path}": rows * table})
