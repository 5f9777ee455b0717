"""The force watch: feels the person in the joints all the time, and takes the arm back for them."""

from __future__ import annotations

import numpy as np

from pft_exec.control import Command
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.pursuit import GO_ON, Instant, Verdict
from pft_exec.geometry import Array
from pft_exec.handoff import ForceObserver, TakeBack
from pft_exec.handoff.take_back import THRESHOLD

GRAVITY = 9.81
"""m/s^2, along -z of the base."""
LETTING_GO = 0.5
"""s after a take-over during which the hand may still let go."""


class ForceWatch:
    """One arm's force observer, and what follows from it while the robot has the arm.

    Parameters
    ----------
    loop : ControlLoop
    threshold : float, N
        Force at the tool from which the person takes the arm back.
    """

    def __init__(self, loop: ControlLoop, threshold: float = THRESHOLD) -> None:
        self.loop = loop
        self._observer = ForceObserver(loop.arm, loop.world.control_period)
        self._take_back = TakeBack(threshold)
        self.force: Array = np.zeros(3)
        """(3,), N: estimate at the tool, base frame."""

    @property
    def size(self) -> float:
        """Size of the force, N, apart from what is usual."""
        return float(np.linalg.norm(self.force - self.usual))

    @property
    def usual(self) -> Array:
        """Force (3,), N, base frame, that lasts: what the model does not know of."""
        return self._take_back.usual.copy()

    @property
    def unknown_mass(self) -> float:
        """What the usual force weighs, kg: a load that no model knows of; never negative."""
        return max(0.0, -float(self._take_back.usual[2]) / GRAVITY)

    def feel(self, q: Array, v: Array, command: Command | None) -> None:
        """Estimate the force from a measured state and the command of the period before; whoever has the arm."""
        if self.loop.guard.doubt > 0.0:
            q = np.full_like(q, np.nan)  # what is only believed of the joints' motion says nothing of forces
        self.force = self._observer.update(q, v, None if command is None else command.torque).force

    def begin(self, letting_go: bool) -> None:
        """The robot has the arm from now on; `letting_go`: from a hand that may take a moment to let go."""
        self._take_back.wait(self.loop.time + LETTING_GO if letting_go else -np.inf)

    def supervise(self, now: Instant) -> Verdict:
        """Take back where a force above the threshold lasts."""
        self.feel(now.configuration, now.velocity, now.command)
        if not self._take_back.update(now.time, self.force):
            return GO_ON
        return Verdict(ending="taken_back", reason=f"a force of {self.size:.0f} N at the tool: the person takes back")
