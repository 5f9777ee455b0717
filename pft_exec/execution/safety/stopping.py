"""Stopping: damped gravity compensation until the arm is at rest; how every run ends that cannot go on."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np

from pft_exec.control import GravityCompensation, stop_damping
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.log import Stage
from pft_exec.execution.safety.yielding import racing_brake

REST_SPEED = 0.02
"""rad/s; all joints slower than this are at rest."""
REST_TIME = 0.1
"""s for which they must be."""
BLIND_TIME = 0.01
"""s of gravity compensation before the drives brake an arm that is not seen."""
BRAKE_TIME = 0.5
"""s for which they brake before the run is over; no joint takes so long from its greatest speed."""
LONGEST = 2.0
"""s after which a stop is over, at rest or not."""


def stop(loop: ControlLoop, reason: str) -> None:
    """Log why, and hold the arm in damped gravity compensation until it rests.

    A joint near its velocity limit is braked the more firmly: others that come to rest would speed it up. Joints whose
    speed is not seen are held up, no more: a believed state would be a push. Where none is seen at all, no
    controller can keep the arm slow: once the motors have held its weight for `BLIND_TIME`, the drives go on with that
    torque and brake by themselves, as dry friction does and within the motors' limits, until `BRAKE_TIME` is over.

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
            _brake(loop, floating, reason)
            return
        if not np.max(np.abs(v)) < REST_SPEED:
            moved = loop.time
        if loop.arm is not floating.arm:
            floating.carry(loop.arm)
        unseen = loop.guard.unseen
        seen = np.where(unseen, 0.0, v)
        command = floating.update(loop.time, q, seen, f"stopped: {reason}", unseen)
        firm = command.torque - racing_brake(loop.arm, q, seen, loop.world.control_period)
        command = replace(command, torque=np.clip(firm, -loop.arm.limits.torque, loop.arm.limits.torque))
        loop.apply(command, Stage.STOPPED, perf_counter() - started)


def _brake(loop: ControlLoop, floating: GravityCompensation, reason: str) -> None:
    """Let the drives of an arm that is not seen brake it."""
    loop.log.event(loop.time, "brake", f"no joint is seen ({loop.guard.reason}): the drives brake within their limits")
    loop.brake()
    begin = loop.time
    while loop.time - begin < BRAKE_TIME:
        started = perf_counter()
        q, v = loop.sense()
        command = floating.update(loop.time, q, v, f"braked: {reason}", np.full_like(q, True, dtype=bool))
        loop.apply(replace(command, torque=loop.world.torque(loop.name)), Stage.STOPPED, perf_counter() - started)
