"""The control history: what the controller decided in each period of a run, and what held it back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pft_exec.control import Command
from pft_exec.geometry import Array

Flags = NDArray[np.bool_]


def _no_flags() -> Flags:
    return np.empty((0, 0), dtype=bool)


@dataclass(frozen=True, eq=False)
class ControlHistory:
    """One row per control period; empty in logs that were written before there was one.

    Parameters
    ----------
    acceleration : (T, n), rad/s^2
        That the torques should give.
    error : (T, 6), m, rad
        Of the measured tool from its reference: position in base axes, rotation vector in the reference tool frame.
    costs : {name: (T,)}
        What each objective costs at the solution; NaN where nothing was solved.
    torque_active, bound_active : (T, n), bool
        Joints at their torque limit, and at a position, velocity or acceleration bound.
    apart : {pair: (T,) bool}
        Pairs of bodies whose distance limited the motion, such as "r_forearm_link / bottle".
    distance : (T,), m
        Smallest distance between bodies that are kept apart; infinite where none are near.
    statuses : tuple of str
        What the solver said in this run.
    status : (T,) int
        Which of `statuses` it said.
    fallback : (T,), bool
        Whether damped gravity compensation stood in.
    solve_time : (T,), s
        Of the solver alone; like `tick`, it differs from run to run.
    iterations : (T,) int
    rate : (T,)
        Of the reference's clock beside the planned one; 1 where there is none.
    """

    acceleration: Array = field(default_factory=lambda: np.empty((0, 0)))
    error: Array = field(default_factory=lambda: np.empty((0, 6)))
    costs: Mapping[str, Array] = field(default_factory=dict)
    torque_active: Flags = field(default_factory=_no_flags)
    bound_active: Flags = field(default_factory=_no_flags)
    apart: Mapping[str, Flags] = field(default_factory=dict)
    distance: Array = field(default_factory=lambda: np.empty(0))
    statuses: tuple[str, ...] = ()
    status: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    fallback: Flags = field(default_factory=lambda: np.empty(0, dtype=bool))
    solve_time: Array = field(default_factory=lambda: np.empty(0))
    iterations: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    rate: Array = field(default_factory=lambda: np.empty(0))

    def __len__(self) -> int:
        return len(self.fallback)

    def tree(self) -> dict[str, Any]:
        """As it is stored."""
        content = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return content | {"costs": dict(self.costs), "apart": dict(self.apart), "statuses": list(self.statuses)}

    @classmethod
    def from_tree(cls, content: Mapping[str, Any]) -> ControlHistory:
        """As it was stored."""
        return cls(**{**content, "statuses": tuple(content["statuses"])})


def control_history(commands: Sequence[Command], rates: Sequence[float]) -> ControlHistory:
    """The history of a run's commands and of its clock's rates, both (T,)."""
    if not commands:
        return ControlHistory()
    statuses = tuple(dict.fromkeys(command.status for command in commands))
    place = {status: index for index, status in enumerate(statuses)}
    return ControlHistory(
        acceleration=np.array([command.acceleration for command in commands]),
        error=np.array([command.error for command in commands]),
        costs=_costs(commands),
        torque_active=np.array([command.torque_active for command in commands]),
        bound_active=np.array([command.bound_active for command in commands]),
        apart=_apart(commands),
        distance=np.array([command.distance for command in commands]),
        statuses=statuses,
        status=np.array([place[command.status] for command in commands], dtype=np.int64),
        fallback=np.array([command.fallback for command in commands]),
        solve_time=np.array([command.solve_time for command in commands]),
        iterations=np.array([command.iterations for command in commands], dtype=np.int64),
        rate=np.array(rates),
    )


def _costs(commands: Sequence[Command]) -> dict[str, Array]:
    names = sorted({name for command in commands for name in command.costs})
    return {name: np.array([command.costs.get(name, np.nan) for command in commands]) for name in names}


def _apart(commands: Sequence[Command]) -> dict[str, Flags]:
    names = sorted({name for command in commands for name in command.apart_active})
    return {name: np.array([name in command.apart_active for command in commands]) for name in names}
