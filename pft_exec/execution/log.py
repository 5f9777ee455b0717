"""The log of one run: what was measured, what was commanded and what was decided, period by period."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import IntEnum
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pft_exec.control import Command
from pft_exec.demonstration.hdf5 import read_file, write_file
from pft_exec.exceptions import PFTError, StorageError
from pft_exec.execution.control_history import ControlHistory, control_history
from pft_exec.geometry import Array

FORMAT = "pft_exec execution log"
VERSION = 2
"""2 added the control history; logs of version 1 are read without it."""


class Stage(IntEnum):
    """Who moves the arm."""

    GUIDED = 0  # the hand leads, the arm floats in gravity compensation
    TRANSITION = 1  # the jerk-limited move onto the tube
    TUBE = 2  # the tracking controller follows the tube
    HOLD = 3  # the tracking controller rests at the tube's end
    STOPPED = 4  # damped gravity compensation after a fault or a refusal


class Event(NamedTuple):
    """Something that happened once: when (s), what ("take_over", "fault", "slow", "resume", "stop", ...), and why."""

    time: float
    name: str
    detail: str


@dataclass(frozen=True, eq=False)
class BeliefHistory:
    """The recognizer's belief at each of B samples.

    Parameters
    ----------
    labels : (L,)
        Sorted.
    time : (B,), s
    probability : (B, L)
        Posterior over the labels.
    unknown : (B,)
        Probability that the motion is none of them.
    """

    labels: tuple[str, ...] = ()
    time: Array = field(default_factory=lambda: np.empty(0))
    probability: Array = field(default_factory=lambda: np.empty((0, 0)))
    unknown: Array = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, eq=False)
class ExecutionLog:
    """One run, a row per control period.

    Parameters
    ----------
    time : (T,), s since the run began
    configuration, velocity : (T, n), rad or m, and per s
        Measured, in the arm's joint order.
    torque : (T, n), N m or N
        Commanded motor torque, counterbalance apart.
    position : (T, 3), m; quaternion : (T, 4), (x, y, z, w)
        Measured tool pose, world frame.
    phase : (T,)
        Place along the tube in [0, 1]; NaN while the hand leads.
    success : bool
        Whether the task's own predicate on the scene holds at the end.
    reason : str
        Why the run ended as it did.
    events : tuple of Event
    robot, task, arm, label : str
        What ran; `label` is the motion that was executed, empty where none was.
    reference_position, reference_velocity, reference_acceleration : (T, n)
        Commanded joint reference; under the hand, the measured motion with zero acceleration.
    stage : (T,) int
        `Stage` of each row.
    hand_force : (T,), N
        Size of the force with which the hand or a push acted on the tool; the controller never sees it.
    tick : (T,), s
        Computing time of the control period; the one field that differs from run to run.
    belief : BeliefHistory
    control : ControlHistory
        What each control period decided: costs, active constraints, solver, timing.
    details : {name: float}
        Figures of the run, such as the end error (m).
    """

    time: Array
    configuration: Array
    velocity: Array
    torque: Array
    position: Array
    quaternion: Array
    phase: Array
    success: bool
    reason: str
    events: tuple[Event, ...] = ()
    robot: str = ""
    task: str = ""
    arm: str = ""
    label: str = ""
    reference_position: Array = field(default_factory=lambda: np.empty((0, 0)))
    reference_velocity: Array = field(default_factory=lambda: np.empty((0, 0)))
    reference_acceleration: Array = field(default_factory=lambda: np.empty((0, 0)))
    stage: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    hand_force: Array = field(default_factory=lambda: np.empty(0))
    tick: Array = field(default_factory=lambda: np.empty(0))
    belief: BeliefHistory = field(default_factory=BeliefHistory)
    control: ControlHistory = field(default_factory=ControlHistory)
    details: Mapping[str, float] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.time)

    def event(self, name: str) -> Event | None:
        """The first event of that name, or None."""
        return next((event for event in self.events if event.name == name), None)

    def save(self, path: str | Path) -> None:
        """Write the log as HDF5, beside the target and renamed."""
        content: dict[str, Any] = {f.name: getattr(self, f.name) for f in fields(self)}
        content["details"] = dict(self.details)
        content["events"] = {
            "time": np.array([event.time for event in self.events]),
            "name": [event.name for event in self.events],
            "detail": [event.detail for event in self.events],
        }
        belief = self.belief
        content["control"] = self.control.tree()
        content["belief"] = {
            "labels": list(belief.labels),
            "time": belief.time,
            "probability": belief.probability,
            "unknown": belief.unknown,
        }
        write_file(path, content, FORMAT, VERSION)

    @classmethod
    def load(cls, path: str | Path) -> ExecutionLog:
        """Read a log.

        Raises
        ------
        StorageError
            If the file is missing, truncated, of another kind, or newer than this version.
        """
        content = read_file(path, FORMAT, VERSION)
        try:
            events, belief = content.pop("events"), content.pop("belief")
            control = content.pop("control", None)
            return cls(
                events=tuple(
                    Event(float(t), str(n), str(d))
                    for t, n, d in zip(events["time"], events["name"], events["detail"], strict=True)
                ),
                belief=BeliefHistory(tuple(belief["labels"]), belief["time"], belief["probability"], belief["unknown"]),
                control=ControlHistory() if control is None else ControlHistory.from_tree(control),
                **content,
            )
        except (KeyError, TypeError, ValueError, PFTError) as error:
            raise StorageError(f"{path} is marked as an execution log but lacks a part of one: {error}.") from error


class LogRecorder:
    """Collects rows while a run goes on and makes the `ExecutionLog` of it."""

    def __init__(self) -> None:
        self._rows: dict[str, list[Any]] = {name: [] for name in _ROW_FIELDS}
        self._commands: list[Command] = []
        self._rates: list[float] = []
        self._events: list[Event] = []
        self._beliefs: list[tuple[float, dict[str, float], float]] = []

    def add(self, command: Command | None = None, rate: float = 1.0, **row: ArrayLike) -> None:
        """One row; names are the row fields of `ExecutionLog`; `command` and its clock's `rate` make the history."""
        if command is not None:
            self._commands.append(command)
            self._rates.append(rate)
        for name, values in self._rows.items():
            values.append(row[name])

    def event(self, time: float, name: str, detail: str = "") -> None:
        """Something that happened once."""
        self._events.append(Event(time, name, detail))

    def belief(self, time: float, probability: Mapping[str, float], unknown: float) -> None:
        """The recognizer's belief after a sample."""
        self._beliefs.append((time, dict(probability), unknown))

    def finish(self, success: bool, reason: str, **about: Any) -> ExecutionLog:
        """The log; `about` holds its fields that are not rows."""
        rows: dict[str, Any] = {name: np.asarray(values) for name, values in self._rows.items()}
        rows["stage"] = rows["stage"].astype(np.int64)
        return ExecutionLog(
            success=success,
            reason=reason,
            events=tuple(self._events),
            belief=self._history(),
            control=control_history(self._commands, self._rates),
            **rows,
            **about,
        )

    def _history(self) -> BeliefHistory:
        if not self._beliefs:
            return BeliefHistory()
        labels = tuple(sorted(self._beliefs[0][1]))
        return BeliefHistory(
            labels,
            np.array([time for time, _, _ in self._beliefs]),
            np.array([[probability[label] for label in labels] for _, probability, _ in self._beliefs]),
            np.array([unknown for _, _, unknown in self._beliefs]),
        )


_ROW_FIELDS = (
    "time",
    "configuration",
    "velocity",
    "torque",
    "position",
    "quaternion",
    "phase",
    "reference_position",
    "reference_velocity",
    "reference_acceleration",
    "stage",
    "hand_force",
    "tick",
)
