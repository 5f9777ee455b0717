"""Commands that look: `show` at a file, `check` at a robot or a task."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pft_exec.cli.application import command
from pft_exec.cli.options import Json, Plot
from pft_exec.cli.terminal import print_tables, progress


@command("show library.h5 --plot tubes.png")
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
    print_tables(as_json, {"kind": contents.kind, "rows": contents.rows}, {contents.title: contents.rows})


@command("check robot my_robot/")
def check(
    kind: Annotated[str, typer.Argument(help="robot or task.")],
    name: Annotated[str, typer.Argument(help="Its name, or the path of its folder.")],
    as_json: Json = False,
) -> None:
    """Check a robot or task of yours, and say what to mend; exit status 1 where something is to be mended."""
    from pft_exec.report.check import check_description

    with progress(f"checking {name}"):
        rows = check_description(kind, name)
    print_tables(as_json, {"checks": rows}, {f"{kind} {name}": rows})
    if not all(row["ok"] for row in rows):
        raise typer.Exit(1)
