"""The command line: arguments, calls and printing; everything it does can be done from Python with the same names."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Sequence
from importlib import import_module

import typer

from pft_exec.cli.application import app
from pft_exec.cli.terminal import say
from pft_exec.exceptions import PFTError

__all__ = ["app", "main", "run"]

_INTERRUPTED = 130  # exit status of a program that Ctrl-C ended

for _part in ("teaching", "learning", "running", "studies", "inspection"):  # in the order of the help
    import_module(f"pft_exec.cli.{_part}")


def run(arguments: Sequence[str]) -> int:
    """Run the command line and return its exit status.

    0, 1 where a check failed, 2 for a mistake of the user's, 130 where Ctrl-C ended it.
    """
    try:
        with warnings.catch_warnings():
            warnings.showwarning = lambda message, *_: say(f"warning: {message}")
            status = app(list(arguments), prog_name="pft-exec", standalone_mode=False)
    except (typer.TyperException, PFTError, OSError) as mistake:
        say(mistake.format_message() if isinstance(mistake, typer.TyperException) else str(mistake))
        return 2
    if status == _INTERRUPTED:
        say("interrupted.")
    return status if isinstance(status, int) else 0


def main() -> None:
    """Entry of ``pft-exec``."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # small matrices: threads cost more than they bring
        os.environ.setdefault(name, "1")
    sys.exit(run(sys.argv[1:]))
