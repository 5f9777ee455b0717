"""Yielding: the arm floats for a person, from whatever it did before, without a bump and never too fast."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np

from pft_exec.control import Command, GravityCompensation
from pft_exec.control.friction import friction_torque
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.log import Stage
from pft_exec.execution.safety.force_watch import ForceWatch
from pft_exec.geometry import Array
from pft_exec.model import Arm

FADE_RATE = 490.0
"""N m/s by which a joint's torque changes at most, beside that of gravity, as long as no joint turns too fast."""
FREE = 0.5
"""N m; with less left of what pulled towards the tube in every joint, the arm is free."""
EASE_TIME = 0.08
"""s over which what helps a hand, and what slows the arm down, comes in where a friction feed-forward goes out."""
BRAKE_SHARE = 0.4
"""Share of each joint's velocity limit from which fast motion is braked."""
BRAKE_TIME = 0.05
"""s; time constant of the brake on each joint's own inertia."""
SETTLE_TIME = 0.3
"""s; time constant with which an arm comes to rest that was taken back and let go of: a push does not fling it."""
RACING_SHARE = 0.5
"""Share of each joint's velocity limit from which it is braked the more firmly, the faster it turns."""
FIRM_RATES = (50.0, 500.0)
"""1/s; rates at which that excess is taken away, at `RACING_SHARE` and at the velocity limit itself."""
HURRY = (0.78, 0.95, 10.0)
"""Shares of each joint's velocity limit between which its torque may change faster, and how much: felt or not."""
STABLE_SHARE = 0.5
"""Share of it that is taken away in a control period at most."""
CALM = (8.0, 0.05)
"""N and rad/s: with less force and motion than this nobody moves the arm."""
CALM_TIME = 0.3
"""s for which it must have been calm before the robot goes on."""
LONGEST = 10.0
"""s after which it does not go on any more."""


class Yielding:
    """Let an arm float under a person's hand.

    The torque goes from that of a command before to that of floating as fast as a hand does not feel it, joint for
    joint. The feed-forward of friction, which pulls nowhere, goes out more slowly, as what helps a hand comes in.

    Parameters
    ----------
    arm : Arm
    control_period : float, s
    """

    def __init__(self, arm: Arm, control_period: float) -> None:
        self.arm = arm
        self._period = control_period
        self._floating = GravityCompensation(arm, period=control_period)
        zero = np.zeros(len(arm.joint_names))
        self._before: Command | None = None
        self._eased, self._eased_since = zero, -np.inf
        self._last: Array | None = None
        self._left = zero
        self._settling = 0.0
        self.brake = zero
        """(n,), N m: what the last torque held against motion, beside what helps a hand; fades out at a take-over."""

    def begin(self, time: float, before: Command | None) -> None:
        """Float from a time on, s, and let the torque of the command before fade out."""
        self._before = before
        self._eased_since = -np.inf if before is None else time
        self._settling = 0.0 if before is None else 1.0 / SETTLE_TIME

    @property
    def is_free(self) -> bool:
        """Whether next to nothing is left of what pulled towards the tube, less than `FREE` in every joint."""
        return self._before is None and bool(np.all(np.abs(self._left) < FREE))

    def update(self, time: float, q: Array, v: Array) -> Command:
        """Torque for one control period; never raises.

        Parameters
        ----------
        time : float, s
        q, v : (n,), rad, rad/s
            Measured.
        """
        command = self._floating.update(time, q, v)
        q = command.configuration
        gravity = self.arm.gravity(q) - self.arm.counterbalance(q)
        if self._before is not None:
            self._eased = friction_torque(self.arm.friction, self._before.velocity)
            self._last, self._before = self._before.torque - gravity, None
        share = float(np.clip((time - self._eased_since + self._period) / EASE_TIME, 0.0, 1.0))
        self.brake = share * self._brake(q, v) + racing_brake(self.arm, q, v, self._period)
        wanted = share * (command.torque - gravity) + (1.0 - share) * self._eased - self.brake
        torque = gravity + self._approach(wanted, v)
        limit = self.arm.limits.torque
        return replace(command, torque=np.minimum(np.maximum(torque, -limit), limit))

    def _approach(self, wanted: Array, v: Array) -> Array:
        """Torque (n,), N m, beside gravity: towards what is wanted, at a rate that no hand feels."""
        if self._last is None:
            self._last = wanted
        hurry = np.clip((np.abs(v) / self.arm.limits.velocity - HURRY[0]) / (HURRY[1] - HURRY[0]), 0.0, 1.0)
        step = FADE_RATE * self._period * (1.0 + (HURRY[2] - 1.0) * hurry)
        self._last = self._last + np.clip(wanted - self._last, -step, step)
        self._left = wanted - self._last
        given: Array = self._last
        return given

    def _brake(self, q: Array, v: Array) -> Array:
        """Torque (n,), N m, against motion after a take-back, and against joints that turn fast."""
        excess = np.maximum(np.abs(v) - BRAKE_SHARE * self.arm.limits.velocity, 0.0)
        if not (self._settling or excess.any()):
            return np.zeros(len(q))
        brake: Array = np.diag(self.arm.mass_matrix(q)) * (self._settling * v + excess / BRAKE_TIME * np.sign(v))
        return brake

    def carry(self, arm: Arm) -> None:
        """Go on with another model of the same arm: a payload was grasped or released."""
        self.arm = arm
        self._floating.carry(arm)


def racing_brake(arm: Arm, q: Array, v: Array, period: float) -> Array:
    """Torque (n,), N m, against joints that turn too fast; the firmer, the nearer they are to their limits.

    Parameters
    ----------
    arm : Arm
    q, v : (n,), rad, rad/s
    period : float, s
        For which the torque is held.
    """
    limit = arm.limits.velocity
    racing = np.maximum(np.abs(v) - RACING_SHARE * limit, 0.0)
    if not racing.any():
        return np.zeros(len(q))
    inertia = 1.0 / np.diag(np.linalg.inv(arm.mass_matrix(q)))
    share = np.minimum(racing / ((1.0 - RACING_SHARE) * limit), 1.0)
    rate = FIRM_RATES[0] + share * (FIRM_RATES[1] - FIRM_RATES[0])
    brake: Array = np.minimum(rate, STABLE_SHARE / period) * inertia * racing * np.sign(v)
    return brake


class Calm:
    """Notice that nobody moves the arm; forces are those beyond friction.

    Parameters
    ----------
    time : float, s
        Now.
    lasting : float, s
        For which it must have been calm.
    """

    def __init__(self, time: float, lasting: float = CALM_TIME) -> None:
        self._lasting = lasting
        self._restless = time

    def update(self, time: float, force: Array, v: Array) -> bool:
        """Whether force (3,), N, and joint speeds (n,), rad/s, have been small for long, at a time, s."""
        if np.linalg.norm(force) > CALM[0] or np.max(np.abs(v)) > CALM[1]:
            self._restless = time
        return time - self._restless >= self._lasting


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
    arm, load = loop.arm, force.unknown_mass  # it would fall under what only the observer knows of
    yielding, begin, command = Yielding(arm.with_payload(load), loop.world.control_period), loop.time, before
    yielding.begin(begin, before)
    calm = Calm(begin)
    while loop.time - begin < LONGEST and not loop.guard.is_lost:
        started = perf_counter()
        q, v = loop.sense()
        force.feel(q, v, command)
        if calm.update(loop.time, force.beyond_friction(q, v), v):
            force.go_on()
            return True
        if loop.arm is not arm:
            arm = loop.arm
            yielding.carry(arm.with_payload(load))
        command = yielding.update(loop.time, q, v)
        loop.apply(command, Stage.GUIDED, perf_counter() - started)
    return False
