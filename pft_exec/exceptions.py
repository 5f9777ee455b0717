"""Every exception of the project: one base, and leaves that are built-in exceptions as well.

A message says what was expected, what came, and what to do; the same facts are attributes.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class PFTError(Exception):
    """Base of everything that this package raises on purpose."""


class UnknownNameError(PFTError, LookupError):
    """A name that is not among the choices.

    Parameters
    ----------
    kind : str
        What the name should have named, such as "robot" or "motion".
    name : str
        The name that came.
    choices : iterable of str
        The names that exist.
    hint : str
        What else to try; appended to the message.
    """

    def __init__(self, kind: str, name: str, choices: Iterable[str], hint: str = "") -> None:
        self.kind = kind
        self.name = name
        self.choices = tuple(choices)
        super().__init__(self._message(hint))

    def _message(self, hint: str) -> str:
        nearest = get_close_matches(self.name, self.choices, n=1, cutoff=0.5)
        message = f"no {self.kind} is named {self.name!r}."
        if nearest:
            message += f" Did you mean {nearest[0]!r}?"
        listed = ", ".join(repr(choice) for choice in self.choices) or "none"
        message += f" Choices: {listed}."
        return f"{message} {hint}".rstrip()


class UnknownRobotError(UnknownNameError):
    """No robot folder has that name."""


class UnknownTaskError(UnknownNameError):
    """No task folder has that name."""


class UnknownMotionError(UnknownNameError):
    """A task or library has no motion of that label."""


class UnknownArmError(UnknownNameError):
    """The robot has no arm of that name."""


class UnknownMethodError(UnknownNameError, ValueError):
    """A ``method=`` or ``solver=`` that does not exist."""


class MissingObjectError(UnknownNameError):
    """The scene lacks an object that is named: by a relevant motion variable, a substitution or a task."""


class DescriptionError(PFTError, ValueError):
    """A robot.toml or task.toml that cannot be read as one."""


class ConfigurationError(PFTError, ValueError):
    """Joint values that do not fit the arm."""


class InvalidDemonstrationError(PFTError, ValueError):
    """Arrays that do not make a demonstration."""


class InvalidFlowTubeError(PFTError, ValueError):
    """Arrays that do not make a flow tube."""


class InvalidSceneError(PFTError, ValueError):
    """A scene or pose that cannot be one."""


class LearningError(PFTError, ValueError):
    """Demonstrations from which no motion can be learned."""


class RecognitionError(PFTError, ValueError):
    """Tubes or samples with which the recognizer cannot work."""


class StorageError(PFTError, OSError):
    """A file that is missing, truncated, foreign, or newer than this version."""


class MissingPackageError(PFTError, ImportError):
    """A package that only some of the comparisons need is not installed."""


class UnreachableError(PFTError, ValueError):
    """A pose, placement or path that the arm cannot reach."""


class ControlError(PFTError, ValueError):
    """A controller, limit or solver set up with values it cannot work with."""


class SimulationError(PFTError, RuntimeError):
    """The world cannot be built or stepped as asked."""
