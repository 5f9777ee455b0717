"""The force watch: feels the person in the joints all the time, and takes the arm back for them."""

from __future__ import annotations

import math

import numpy as np

from pft_exec.control import Command
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.pursuit import GO_ON, Instant, Verdict
from pft_exec.geometry import Array
from pft_exec.handoff import ForceObserver, TakeBack
from pft_exec.handoff.felt import follow_means
from pft_exec.handoff.take_back import THRESHOLD, tool_wrench

GRAVITY = 9.81
"""m/s^2, along -z of the base."""
LETTING_GO = 0.5
"""s after a take-over during which the hand may still let go."""
REST_TIME = 0.1
"""s over which the torques that are felt are averaged where it is asked whether somebody holds the arm."""
OUTSTANDING = 4.0
"""Standard deviations of the felt force, while nobody moves the arm, by which a push stands out."""
BLUNTEST = 2.0
"""Multiple of the threshold that takes the arm back however much the felt force fluctuates."""
FRICTION_ERROR = 0.2
"""Share of its Coulomb friction that a joint may have more than its model."""
FRICTION_SPEED = 0.05
"""rad/s; friction of a slower joint takes any value that holds it."""


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
        self._sudden: Array = np.zeros(3)
        self._threshold = threshold
        self._share = 1.0 - math.exp(-loop.world.control_period / REST_TIME)
        self._mean = np.zeros(len(loop.arm.joint_names))
        self._mean_force, self._variance = np.zeros(3), 0.0

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
        felt = self._observer.update(q, v, None if command is None else command.torque)
        self.force, self._sudden = felt.force, felt.sudden
        means = self._mean, self._mean_force, self._variance
        self._variance = follow_means(*means, felt.torque, felt.force, self._share)

    def beyond_friction(self, q: Array, v: Array) -> Array:
        """Force (3,), N, base frame, of the last moments that neither what is usual nor friction accounts for.

        The friction of a joint at rest takes any value up to its own: a force within it may be a person's or nobody's,
        and moves nothing.

        Parameters
        ----------
        q, v : (n,), rad, rad/s
            Measured.
        """
        dynamics = self.loop.arm.dynamics(q, v)
        unusual = self._mean - dynamics.jacobian[:3].T @ self.usual
        known = np.abs(np.tanh(v / FRICTION_SPEED))  # the observer's share
        friction = self.loop.arm.friction.coulomb * (1.0 + FRICTION_ERROR - known)
        beyond = np.sign(unusual) * np.maximum(np.abs(unusual) - friction, 0.0)
        return tool_wrench(dynamics, beyond)[:3]

    def begin(self, letting_go: bool) -> None:
        """The robot has the arm from now on; `letting_go`: from a hand that may take a moment to let go."""
        if letting_go:
            self._take_back.wait(self.loop.time + LETTING_GO)

    def go_on(self) -> None:
        """The robot has the arm again, which nobody moves: what is felt now is usual, and a push stands out from it."""
        stands_out = OUTSTANDING * float(np.sqrt(self._variance))
        threshold = float(np.clip(stands_out, self._threshold, BLUNTEST * self._threshold))
        self._take_back.resume(self._mean_force, threshold)

    def supervise(self, now: Instant) -> Verdict:
        """Take back where a force above the threshold lasts."""
        self.feel(now.configuration, now.velocity, now.command)
        if not self._take_back.update(now.time, self.force, self._sudden):
            return GO_ON
        return Verdict(ending="taken_back", reason=f"a force of {self.size:.0f} N at the tool: the person takes back")
