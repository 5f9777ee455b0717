r"""The supervisor: whether a pursuit goes on, slows down along the tube, or stops, and why.

It watches what a controller cannot judge by itself: whether the measured state is to be believed, whether the solver
answers, how far the tool is from the tube, and whether the motors have anything left. Its distance is that of
Mahalanobis between the measured tool and the reference,

.. math:: d^2 = e^T (\Sigma + F)^{-1} e,

with the tube's covariance and a floor F of what ordinary errors of the model do. Between `NEAR` and `FAR` the wanted
rate of the reference falls linearly from one to zero: pushed off, the motion waits; back, it goes on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pft_exec.control import Command, TubeMetric
from pft_exec.execution.log import LogRecorder
from pft_exec.execution.pursuit import GO_ON, Instant, Verdict
from pft_exec.execution.safety.plausibility import COAST_TIME, StateGuard
from pft_exec.learning.flow_tube import FlowTube

FLOOR = (0.01, 0.1)
"""m, rad; ordinary errors of the model (half a kilogram unknown, friction a fifth wrong) move the tool by less."""
UNTAUGHT_ROTATION = 0.3
"""rad; deviation of the orientation along tubes that have none."""
NEAR, FAR = 4.0, 8.0
"""Mahalanobis distances; 4 is exceeded by chance once in 70 (6 degrees of freedom)."""
OFF_TIME = 2.0
"""s for which the tool may stay so far off that the motion waits, before it is stopped."""
FALLBACK_TIME = 0.05
"""s for which the solver may fail in a row."""
SATURATED_TIME = 0.1
"""s for which a joint may be at its torque limit before the motion slows down."""
SATURATED_RATE = 0.3
"""Rate of a motion whose joints are at their torque limits: a third of the speed takes a tenth of the acceleration."""
EXHAUSTED_TIME = 3.0
"""s for which a joint may be at its torque limit before the motion is stopped."""
QUIET_TIME = 0.1
"""s without a reason to slow down after which the log says that the motion goes on."""
SLOW = 0.9
"""Wanted rate below which a run counts as slowed down, and above which as going on again."""


@dataclass
class Duration:
    """How long something has been so without a break, s."""

    lasting: float = 0.0

    def update(self, is_so: bool, period: float) -> float:
        """Count a period in which it is so or not."""
        self.lasting = self.lasting + period if is_so else 0.0
        return self.lasting


class SafetySupervisor:
    """Judge each control period of a pursuit; call it with an `Instant`.

    Parameters
    ----------
    tube : FlowTube
        Base frame.
    guard : StateGuard
        Of the measured states.
    period : float, s
    log : LogRecorder
        Where each change between going on and slowing down is noted, with its reason.
    """

    def __init__(self, tube: FlowTube, guard: StateGuard, period: float, log: LogRecorder) -> None:
        self._metric = TubeMetric(tube, FLOOR, UNTAUGHT_ROTATION)
        self._guard, self._period, self._log = guard, period, log
        self._failing, self._saturated, self._off = Duration(), Duration(), Duration()
        self._is_slow, self._slow_until = False, 0.0
        self.distance = 0.0
        """Mahalanobis distance of the tool from the reference in the period before."""

    def __call__(self, instant: Instant) -> Verdict:
        """Go on, at which rate, or stop."""
        slowest = self._judge_state()
        if instant.command is not None and slowest.ending is None:
            for judge in (self._judge_solver, self._judge_distance, self._judge_torque):
                verdict = judge(instant.command)
                if verdict.ending is not None:
                    return verdict
                slowest = verdict if verdict.rate < slowest.rate else slowest
        if slowest.ending is None:
            self._note(instant.time, slowest)
        return slowest

    def _judge_state(self) -> Verdict:
        doubt, reason = self._guard.doubt, self._guard.reason
        if doubt <= 0.0:
            return GO_ON
        if self._guard.is_lost:
            return Verdict(0.0, "stopped", f"{reason}, for longer than {1e3 * COAST_TIME:.0f} ms")
        return Verdict(0.0, None, reason)

    def _judge_solver(self, command: Command) -> Verdict:
        failing = self._failing.update(command.fallback, self._period)
        if failing > FALLBACK_TIME:
            return Verdict(0.0, "stopped", f"{command.status}, for longer than {1e3 * FALLBACK_TIME:.0f} ms")
        return Verdict(0.0, None, command.status) if failing else GO_ON

    def _judge_distance(self, command: Command) -> Verdict:
        if command.fallback:
            return GO_ON  # it has no reference to be away from
        self.distance = self._metric.distance(command.phase, command.error)
        rate = min(max((FAR - self.distance) / (FAR - NEAR), 0.0), 1.0)
        lasting = self._off.update(rate <= 0.0, self._period)
        if rate >= 1.0:
            return GO_ON
        reason = f"the tool is {self.distance:.1f} deviations from its tube"
        if lasting > OFF_TIME:
            return Verdict(0.0, "stopped", f"{reason}, for longer than {OFF_TIME:g} s")
        return Verdict(rate, None, reason)

    def _judge_torque(self, command: Command) -> Verdict:
        saturated = self._saturated.update(bool(command.torque_active.any()), self._period)
        if saturated <= SATURATED_TIME:
            return GO_ON
        joints = ", ".join(str(joint + 1) for joint in np.flatnonzero(command.torque_active))
        reason = f"joint {joints} is at its torque limit"
        if saturated > EXHAUSTED_TIME:
            return Verdict(0.0, "stopped", f"{reason}, for longer than {EXHAUSTED_TIME:g} s")
        return Verdict(SATURATED_RATE, None, reason)

    def _note(self, time: float, verdict: Verdict) -> None:
        """Log where the motion begins to slow down, and where it goes on again."""
        if verdict.rate < SLOW:
            if not self._is_slow:
                self._log.event(time, "slow", verdict.reason)
            self._is_slow, self._slow_until = True, time + QUIET_TIME
        elif self._is_slow and verdict.rate == 1.0 and time >= self._slow_until:
            self._log.event(time, "resume", "what slowed the motion down is over")
            self._is_slow = False
