"""Faults: what can break while an arm runs, injected on purpose, to see that it does no harm.

A `Fault` says what, when, for how long and how much. `execute`, `assist` and `teach` take a sequence of them; a
`FaultInjector` lets each act where it would act on a real arm: in the encoders, the motors, the load, the camera, the
recognizer's stream, the solver. No controller sees it; the log names it, as an event "fault".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from pft_exec.description import random_stream
from pft_exec.exceptions import ControlError, UnknownNameError
from pft_exec.geometry import Array


@dataclass(frozen=True)
class FaultKind:
    """One kind of fault.

    Parameters
    ----------
    meaning : str
        What breaks.
    answer : str
        What the arm does then.
    size : float
        How much, where a fault does not say.
    unit : str
        Of the size; empty where it has none.
    duration : float, s
        How long, where a fault does not say; infinite: to the end of the run.
    """

    meaning: str
    answer: str
    size: float = 0.0
    unit: str = ""
    duration: float = np.inf


_COAST = "goes on with the state that the model predicts, slowing down; stops when it lasts longer than 20 ms"
_RECOGNIZE = "goes on: the sample is left out and flagged, the belief stays"
KINDS: Mapping[str, FaultKind] = MappingProxyType(
    {
        "solver_fails": FaultKind(
            "the solver finds nothing",
            "damped gravity compensation for the period, slows down along the tube; stops after 50 ms in a row",
            duration=0.02,
        ),
        "solver_nan": FaultKind(
            "the solver calls NaN a solution", "as where it finds nothing: the answer is looked at", duration=0.02
        ),
        "sample_late": FaultKind("samples reach the recognizer late", _RECOGNIZE, 0.1, "s", 0.3),
        "sample_repeated": FaultKind("samples reach the recognizer twice", _RECOGNIZE, duration=0.3),
        "sample_out_of_order": FaultKind("samples reach the recognizer in the wrong order", _RECOGNIZE, duration=0.3),
        "sample_nan": FaultKind("samples are not numbers", _RECOGNIZE, duration=0.3),
        "encoder_spike": FaultKind("single readings of one encoder are off", _COAST, 0.3, "rad", 0.5),
        "encoder_jump": FaultKind("one encoder jumps and stays off", _COAST, 0.2, "rad"),
        "encoder_nan": FaultKind("one encoder reports no number", _COAST, duration=0.1),
        "encoder_frozen": FaultKind(
            "all encoders repeat their last reading",
            "as above; an arm that is not seen cannot be damped: its drives brake it, within the motors' limits",
        ),
        "object_lost": FaultKind("the camera loses an object", "goes on with the object's last pose", duration=1.0),
        "object_jump": FaultKind(
            "the camera sees an object elsewhere",
            "goes on with the last pose; while a hand leads, a pose that stays is believed after 0.2 s",
            0.15,
            "m",
            0.1,
        ),
        "gripper_opens": FaultKind("the gripper lets the object go", "goes on and says that the task failed"),
        "push": FaultKind(
            "something pushes the tool",
            "gives way as the tube allows, slows down along it, goes on; hands over to a person who keeps pushing",
            20.0,
            "N",
            0.3,
        ),
        "payload": FaultKind("the tool carries a mass that no model knows", "goes on, slower where it sags", 0.5, "kg"),
        "saturation": FaultKind(
            "motors deliver a share of their limit",
            "slows down along the tube; stops where it cannot stay within it for 2 s",
            0.1,
            "of the limit",
            1.0,
        ),
        "wrong_recognition": FaultKind(
            "the recognizer is sure of another motion",
            "takes that motion over; the person takes back by a push, and the log names both",
        ),
        "beyond_reach": FaultKind(
            "the tube lies where the arm cannot be", "does not begin, and says by how much", 0.8, "m"
        ),
    }
)
"""Every kind of fault, what it breaks and what the arm does then."""


@dataclass(frozen=True)
class Fault:
    """One fault to be injected.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    start : float, s
        Since the run began.
    duration : float or None, s
        None is the kind's own.
    size : float or None
        In the kind's unit; None is the kind's own.
    name : str
        Of the object that is lost or jumps (empty: one that the seed draws), or of the motion that is recognized.
    seed : int
        Draws what is not said: which joint, which object, which direction.

    Raises
    ------
    UnknownNameError
        If there is no such kind.
    ControlError
        If a time is negative or not a number.
    """

    kind: str
    start: float = 0.0
    duration: float | None = None
    size: float | None = None
    name: str = ""
    seed: int = 0

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UnknownNameError("kind of fault", self.kind, KINDS)
        kind = KINDS[self.kind]
        for name, default in (("duration", kind.duration), ("size", kind.size)):
            if getattr(self, name) is None:
                object.__setattr__(self, name, default)
        if not (self.start >= 0.0 and self.length >= 0.0 and np.isfinite(self.amount)):
            raise ControlError(
                f"a fault needs a start and a duration of at least 0 s and a finite size; "
                f"got {self.start}, {self.duration} and {self.size}."
            )

    @property
    def length(self) -> float:
        """Duration, s."""
        return float(self.duration or 0.0)

    @property
    def amount(self) -> float:
        """Size, in the kind's unit."""
        return float(self.size or 0.0)

    def is_active(self, time: float) -> bool:
        """Whether it acts at a time, s."""
        return self.start <= time < self.start + self.length

    def generator(self) -> np.random.Generator:
        """What draws the details; the same each time."""
        return random_stream(self.seed, "fault", self.kind)

    def joint(self, count: int) -> int:
        """Which of `count` joints it hits."""
        return int(self.generator().integers(count))

    def direction(self) -> Array:
        """Unit vector (3,) of a push or a displacement, world frame."""
        vector = self.generator().standard_normal(3)
        direction: Array = vector / np.linalg.norm(vector)
        return direction

    def __str__(self) -> str:
        kind = KINDS[self.kind]
        amount = f", {self.amount:g} {kind.unit}" if kind.unit else ""
        lasting = "" if np.isinf(self.length) else f" for {self.length:g} s"
        return f"{self.kind}: {kind.meaning}{amount}{lasting}"


def draw_fault(rng: np.random.Generator, duration: float, kinds: tuple[str, ...] = tuple(KINDS)) -> Fault:
    """A random fault within a run of a duration, s: kind, time, length and size.

    Sizes lie between half and twice the kind's own; pushes are of 10, 20 or 40 N.
    """
    kind = str(rng.choice(kinds))
    usual = KINDS[kind]
    length = usual.duration if np.isinf(usual.duration) else usual.duration * rng.uniform(0.5, 2.0)
    size = usual.size * rng.uniform(0.5, 2.0)
    if kind == "push":
        size = float(rng.choice([10.0, 20.0, 40.0]))
    if kind == "saturation":
        size = float(rng.uniform(0.02, 0.5))
    return Fault(kind, float(rng.uniform(0.0, duration)), float(length), float(size), seed=int(rng.integers(2**31)))
