"""Yielding: the arm floats for a person, from whatever it did before, without a bump and never too fast."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np

from pft_exec.control import Command, GravityCompensation
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.force_watch import ForceWatch
from pft_exec.execution.log import Stage
from pft_exec.geometry import Array
from pft_exec.model import Arm

FADE = (0.006, 0.03)
"""s, at least and at most, over which the torque of a command before becomes that of floating."""
FADE_STEP = 0.44
"""N m by which no joint's torque changes more in a control period of the fade, unless it would take too long."""
BRAKE_SHARE = 0.4
"""Share of each joint's velocity limit from which fast motion is braked."""
BRAKE_TIME = 0.05
"""s; time constant of the brake on each joint's own inertia."""
SETTLE_TIME = 0.3
"""s; time constant with which an arm comes to rest that was taken back and let go of: a push does not fling it."""
RACING_SHARE = 0.5
"""Share of each joint's velocity limit from which it is braked as firmly as its inertia bears."""
FIRM_SHARE = 0.5
"""Share of that excess which is taken away in a control period."""
CALM = (8.0, 0.05)
"""N and rad/s: with less force and motion than this nobody moves the arm."""
CALM_TIME = 0.3
"""s for which it must have been calm before the robot goes on."""
LONGEST = 10.0
"""s after which it does not go on any more."""


class Yielding:
    """Let an arm float under a person's hand.

    Parameters
    ----------
    arm : Arm
    control_period : float, s
    """

    def __init__(self, arm: Arm, control_period: float) -> None:
        self.arm = arm
        self._period = control_period
        self._floating = GravityCompensation(arm)
        self._before: Array | None = None
        self._offset = np.zeros(len(arm.joint_names))
        self._since, self._fade = -np.inf, FADE[0]
        self._settling = 0.0
        self.brake = np.zeros(len(arm.joint_names))
        """(n,), N m: what the last torque held against motion, beside what helps a hand; fades out at a take-over."""

    def begin(self, time: float, before: Command | None) -> None:
        """Float from a time on, s, and let the torque of the command before fade out."""
        self._before = None if before is None else before.torque
        self._since = time
        self._settling = 0.0 if before is None else 1.0 / SETTLE_TIME

    def is_free(self, time: float) -> bool:
        """Whether nothing is left at a time, s, of the command before."""
        return time - self._since >= self._fade - 1e-9

    def update(self, time: float, q: Array, v: Array) -> Command:
        """Torque for one control period; never raises.

        Parameters
        ----------
        time : float, s
        q, v : (n,), rad, rad/s
            Measured.
        """
        command = self._floating.update(time, q, v)
        self.brake = self._brake(command.configuration, v)
        free = command.torque - self.brake
        if self._before is not None:
            self._offset, self._before = self._before - free, None
            periods = np.max(np.abs(self._offset)) / FADE_STEP
            self._fade = float(np.clip(periods * self._period, *FADE))
        left = max(0.0, 1.0 - (time - self._since + self._period) / self._fade)
        torque = free + left * self._offset
        limit = self.arm.limits.torque
        return replace(command, torque=np.minimum(np.maximum(torque, -limit), limit))

    def _brake(self, q: Array, v: Array) -> Array:
        """Torque (n,), N m, against motion after a take-back, and against joints that turn too fast."""
        excess = np.abs(v) - BRAKE_SHARE * self.arm.limits.velocity
        if not (self._settling or (excess > 0.0).any()):
            return np.zeros(len(q))
        slowing = self._settling * v + np.maximum(excess, 0.0) / BRAKE_TIME * np.sign(v)
        mass_matrix = self.arm.mass_matrix(q)
        racing = np.abs(v) - RACING_SHARE * self.arm.limits.velocity
        firm = FIRM_SHARE / self._period / np.diag(np.linalg.inv(mass_matrix)) * np.maximum(racing, 0.0) * np.sign(v)
        brake: Array = np.diag(mass_matrix) * slowing + firm
        return brake

    def carry(self, arm: Arm) -> None:
        """Go on with another model of the same arm: a payload was grasped or released."""
        self.arm = arm
        self._floating.carry(arm)


class Calm:
    """Notice that nobody moves the arm."""

    def __init__(self, time: float) -> None:
        self._restless = time

    def update(self, time: float, force: Array, v: Array) -> bool:
        """Whether force (3,), N, and joint speeds (n,), rad/s, have been small for `CALM_TIME`, at a time, s."""
        if np.linalg.norm(force) > CALM[0] or np.max(np.abs(v)) > CALM[1]:
            self._restless = time
        return time - self._restless >= CALM_TIME


def give_way(loop: ControlLoop, force: ForceWatch, before: Command | None) -> bool:
    """Float while a person moves the arm; True once nobody has for a while, False where that takes too long.

    Parameters
    ----------
    loop : ControlLoop
    force : ForceWatch
    before : Command or None
        What acted until now.
    """
    loop.log.event(loop.time, "take_back", f"a force of {force.size:.0f} N at the tool: the arm gives way")
    arm, load, usual = loop.arm, force.unknown_mass, force.usual  # it would fall under what only the observer knows of
    yielding, begin, command = Yielding(arm.with_payload(load), loop.world.control_period), loop.time, before
    yielding.begin(begin, before)
    calm = Calm(begin)
    while loop.time - begin < LONGEST and not loop.guard.is_lost:
        started = perf_counter()
        q, v = loop.sense()
        force.feel(q, v, command)
        if calm.update(loop.time, force.force - usual, v):
            return True
        if loop.arm is not arm:
            arm = loop.arm
            yielding.carry(arm.with_payload(load))
        command = yielding.update(loop.time, q, v)
        loop.apply(command, Stage.GUIDED, perf_counter() - started)
    return False
