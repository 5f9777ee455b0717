"""Stopping: damped gravity compensation until the arm is at rest; how every run ends that cannot go on."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from pft_exec.control import GravityCompensation, stop_damping
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.log import Stage

REST_SPEED = 0.02
"""rad/s; all joints slower than this are at rest."""
REST_TIME = 0.1
"""s for which they must be."""
BLIND_TIME = 0.01
"""s of gravity compensation before the brakes are set on an arm that is not seen."""
LONGEST = 2.0
"""s after which a stop is over, at rest or not."""


def stop(loop: ControlLoop, reason: str) -> None:
    """Log why, and hold the arm in damped gravity compensation until it rests.

    Joints whose speed is not seen are not damped: a believed speed would be a push. Where none is seen at all, nothing
    can keep the arm slow but its brakes: they are set once the motors have had `BLIND_TIME`.

    Parameters
    ----------
    loop : ControlLoop
    reason : str
    """
    loop.log.event(loop.time, "stop", reason)
    floating = GravityCompensation(loop.arm, stop_damping(loop.arm), loop.world.control_period)
    begin = moved = loop.time
    while loop.time - moved < REST_TIME and loop.time - begin < LONGEST:
        started = perf_counter()
        q, v = loop.sense()
        if loop.guard.unseen.all() and loop.time - begin > BLIND_TIME:
            loop.log.event(loop.time, "brake", f"no joint is seen ({loop.guard.reason}): the brakes are set")
            loop.world.brake(loop.name)
            return
        if not np.max(np.abs(v)) < REST_SPEED:
            moved = loop.time
        if loop.arm is not floating.arm:
            floating.carry(loop.arm)
        command = floating.update(loop.time, q, np.where(loop.guard.unseen, 0.0, v), f"stopped: {reason}")
        loop.apply(command, Stage.STOPPED, perf_counter() - started)
