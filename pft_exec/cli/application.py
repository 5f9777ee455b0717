"""The application that commands register with."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

import typer

from pft_exec import __version__

app = typer.Typer(add_completion=False, rich_markup_mode="rich", pretty_exceptions_enable=False)


def command(example: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Register a command whose help closes with an example."""
    return app.command(epilog=f"Example: [bold]pft-exec {example}[/bold]")


@app.callback(invoke_without_command=True)
def _about(
    context: typer.Context, version: Annotated[bool, typer.Option("--version", help="Print it.")] = False
) -> None:
    """Teach a robot arm by hand; learn, recognize and execute motions as probabilistic flow tubes."""
    if context.invoked_subcommand is None:
        typer.echo(__version__ if version else context.get_help())
