"""Options and arguments that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
Seed = Annotated[int, typer.Option(help="Same seed, same numbers.", min=0)]
Robot = Annotated[str, typer.Option(help="Name of a robot, or path of a folder with a robot.toml.")]
Task = Annotated[str, typer.Option(help="Name of a task, or path of a folder with a task.toml.")]
ArmName = Annotated[str | None, typer.Option(help="Arm of the robot; default: the only one, else right.")]
Tool = Annotated[str | None, typer.Option(help="Attachment of the robot, such as gripper for the wam.")]
Pace = Annotated[float, typer.Option(help="Speed beside the taught one.", min=0.1, max=3.0)]
Softness = Annotated[float, typer.Option(help="Of the tube: 0.03 is stiff, 0.1 usual, 0.3 soft (s^4/m^2).", min=1e-3)]
Solver = Annotated[str, typer.Option(help="Of the quadratic program: daqp, osqp, or another that qpsolvers has.")]
Jobs = Annotated[int, typer.Option(help="Processes.", min=1)]
Gui = Annotated[bool, typer.Option("--gui", help="Show the world in a window.")]
Plot = Annotated[Path | None, typer.Option(help="Write a picture (.png, .pdf, .svg).")]
Log = Annotated[Path | None, typer.Option(help="Write the log of the run (HDF5).")]
Mirror = Annotated[bool, typer.Option("--mirror", help="The library was taught with the other arm.")]
Substitute = Annotated[list[str] | None, typer.Option(help="Object in place of the taught one, such as bottle=can.")]
Avoid = Annotated[list[str] | None, typer.Option(help="Object to keep clear of; may be repeated.")]
Grasp = Annotated[str, typer.Option(help="What holds an object in a gripper: friction or constraint.")]
Strict = Annotated[bool, typer.Option("--strict", help="Exit status 1 where a figure misses its floor.")]
LibraryFile = Annotated[Path, typer.Argument(help="Motion library (HDF5) that `learn` wrote.")]
DemonstrationFile = Annotated[Path, typer.Argument(help="Demonstrations (HDF5) that `teach` or `convert` wrote.")]


def _named_h5(path: Path) -> Path:
    if path.suffix not in (".h5", ".hdf5"):
        raise typer.BadParameter(f"a file to write is named .h5 or .hdf5; got {str(path)!r}.")
    return path


Written = Annotated[Path, typer.Argument(help="File to write (HDF5, .h5).", callback=_named_h5)]
