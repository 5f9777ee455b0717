"""The options of every command that moves a robot, written once: a dataclass that becomes options of a command."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Any, get_type_hints

import typer

from pft_exec.cli.options import (
    ArmName,
    Avoid,
    Grasp,
    Gui,
    Json,
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

COMMAND_PARAMETER = "options"
"""Name of the parameter of a command in whose place its dataclass's options stand."""


@dataclass(frozen=True)
class RunOptions:
    """What a run needs to know besides the library and the motion; each field is an option of the command line."""

    robot: Robot = "pr2"
    task: Task = "tabletop"
    tool: Tool = None
    arm: ArmName = None
    mirror: Mirror = False
    grasp: Grasp = "friction"
    substitute: Substitute = None
    avoid: Avoid = None
    pace: Pace = 1.0
    softness: Softness = 0.1
    solver: Solver = "daqp"
    seed: Seed = 0
    log: Log = None
    plot: Plot = None
    gui: Gui = False
    as_json: Json = False

    @property
    def swaps(self) -> dict[str, str]:
        """``["bottle=can"]`` as a mapping from the taught object to the one that takes its place."""
        named = {taught: now for taught, _, now in (pair.partition("=") for pair in self.substitute or ())}
        if not all((*named, *named.values())):
            raise typer.BadParameter("a substitution names two objects, such as bottle=can.")
        return named

    def of_a_run(self) -> dict[str, Any]:
        """Keywords that `execute` and `assist` share."""
        return {
            "avoid": self.avoid or (),
            "pace": self.pace,
            "softness": self.softness,
            "solver": self.solver,
            "substitute": self.swaps,
        }


def with_options(kind: type) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Make the fields of a dataclass, all with defaults, options of a command that takes one as `options`.

    Parameters
    ----------
    kind : type
        Its fields are annotated as options.
    """
    hints = get_type_hints(kind, include_extras=True)
    shared = [
        Parameter(field.name, Parameter.KEYWORD_ONLY, default=field.default, annotation=hints[field.name])
        for field in fields(kind)
    ]

    def spread(function: Callable[..., None]) -> Callable[..., None]:
        own = get_type_hints(function, include_extras=True)
        kept = [
            parameter.replace(kind=Parameter.KEYWORD_ONLY, annotation=own[name])
            for name, parameter in signature(function).parameters.items()
            if name != COMMAND_PARAMETER
        ]

        @wraps(function)
        def run(**given: Any) -> None:
            chosen = kind(**{parameter.name: given.pop(parameter.name) for parameter in shared})
            function(**given, **{COMMAND_PARAMETER: chosen})

        described: Any = run
        described.__signature__ = Signature([*kept, *shared])
        described.__annotations__ = {each.name: each.annotation for each in (*kept, *shared)}
        return run

    return spread
