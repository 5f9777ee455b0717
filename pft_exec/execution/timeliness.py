"""Timeliness: what would make a control period late is done before a loop runs, or after it.

Compiled code is loaded when it is first called, 60 ms at a take-over, once in a process. Python's collector of cyclic
garbage looks through all objects from time to time, for 110 ms in the third run of a process (both measured).
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from pft_exec.control import TrackingController, constant_compliance, holding, joined, load_solver
from pft_exec.control.tracking import BLENDING_TIME
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.log import Stage
from pft_exec.execution.pursuit import Instant
from pft_exec.execution.safety.force_watch import ForceWatch
from pft_exec.execution.takeover import frechet_distance
from pft_exec.geometry import Pose
from pft_exec.model import Obstacle, Sphere

_BESIDE = np.array([0.0, 0.15, 0.0])
"""m; where an obstacle is near the tool, and not in its way."""


@contextmanager
def undisturbed() -> Iterator[None]:
    """Keep the collector of cyclic garbage from running meanwhile; what counts no references is freed as ever."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def warm_up(loop: ControlLoop, solver: str = "daqp") -> None:
    """Go through some control periods, where the arm is, with controller and force observer of their own.

    Nobody gets their commands.

    Raises
    ------
    UnknownMethodError
        If there is no such solver.
    """
    period, is_careful = loop.world.control_period, loop.surroundings is not None
    q, v = loop.sense()
    controller = TrackingController(loop.arm, period, load_solver(solver), is_careful)
    room = replace(constant_compliance(100.0), deviation=np.tile(0.05 * np.eye(3), (2, 1, 1)))
    controller.follow(joined(lambda _: (q, 0.0 * q, 0.0 * q), BLENDING_TIME, holding(q)), room, 0.0)
    watch, command = ForceWatch(loop), None
    for time in (0.0, period, 2.0 * period, BLENDING_TIME, BLENDING_TIME + period):
        watch.supervise(Instant(time, time, Stage.TUBE, q, v, command))
        if is_careful:
            near = Pose(loop.arm.forward(q).position + _BESIDE)
            controller.avoid([Obstacle("near", Sphere(0.03), near, np.full(6, 0.01))], time)
        command = controller.update(time, q, v)
    frechet_distance(np.zeros((2, 2)))
