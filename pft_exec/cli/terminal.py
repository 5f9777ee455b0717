"""What the terminal shows: progress, tables, one line for a mistake."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column, Table


@contextmanager
def progress(stage: str, shown: bool = True) -> Iterator[Callable[[str, float], None]]:
    """A bar on standard error; the function that moves it takes the stage and the share done, 0 to 1."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not (shown and console.is_terminal)) as bar:
        task = bar.add_task(stage, total=None)
        yield lambda stage, done: bar.update(task, description=stage, total=1.0, completed=done)


def print_tables(as_json: bool, result: Mapping[str, Any], tables: Mapping[str, Sequence[Mapping[str, Any]]]) -> None:
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


def say(message: str) -> None:
    """One line on standard error."""
    typer.echo(f"pft-exec: {' '.join(message.split())}", err=True)
