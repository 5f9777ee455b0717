r"""The time law: how fast the clock of a tube runs, so that a motion keeps its limits and ends at rest.

The tube's own time :math:`\theta` runs at a constant rate, from where it is taken up, and comes to rest at the end of
the tube along a smooth step :math:`\dot\theta = \rho\,(1 - 3x^2 + 2x^3)`, x from 0 to 1 over the stopping time; from a
standstill, or from a share of the rate, it comes up to the rate along the same step. Rate and acceleration of the clock
are continuous.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property


@dataclass(frozen=True)
class TimeLaw:
    """Tube time as a function of the clock since the take-up.

    Parameters
    ----------
    begin, end : float, s
        Tube time at clock zero, and where it comes to rest.
    rate : float
        Tube seconds per second; 1 is the taught speed.
    stopping : float, s
        Clock time of the smooth stop; shortened where less than half of it is left.
    starting : float, s
        Clock time of the smooth start; 0 where the motion is under way. Shortened where the stop leaves less room.
    onset : float
        Share of the rate, in [0, 1], with which the smooth start begins; 0 is a standstill.
    """

    begin: float
    end: float
    rate: float = 1.0
    stopping: float = 0.1
    starting: float = 0.0
    onset: float = 0.0

    @cached_property
    def _ramp(self) -> float:
        """Clock time of the stop, s: it covers half of what the full rate would."""
        return min(self.stopping, 2.0 * (self.end - self.begin) / self.rate)

    @cached_property
    def _start(self) -> float:
        """Clock time of the start, s: from a standstill, as the stop, it covers half of what the full rate would."""
        room = (self.end - self.begin) / self.rate - 0.5 * self._ramp
        return min(self.starting, 2.0 * room / (1.0 + self.onset))

    @cached_property
    def duration(self) -> float:
        """Clock time until rest, s."""
        return (self.end - self.begin) / self.rate + 0.5 * (self._ramp + (1.0 - self.onset) * self._start)

    def at(self, time: float) -> tuple[float, float, float]:
        """Tube time, s, its rate, and the rate's change, 1/s, at a clock time, s; at rest after the end."""
        ramp = self._ramp
        left = self.duration - time
        if left <= 0.0 or ramp <= 0.0:
            return self.end, 0.0, 0.0
        if left >= ramp:
            return self._before_the_stop(time)
        y = left / ramp  # 1 - x; the remaining tube time is the integral of rate (3 y^2 - 2 y^3)
        remaining = self.rate * ramp * (y**3 - 0.5 * y**4)
        return self.end - remaining, self.rate * (3.0 - 2.0 * y) * y**2, -self.rate * 6.0 * y * (1.0 - y) / ramp

    def _before_the_stop(self, time: float) -> tuple[float, float, float]:
        start, gain = self._start, self.rate * (1.0 - self.onset)
        if time >= start:
            return self.begin + self.rate * time - 0.5 * gain * start, self.rate, 0.0
        x = max(time, 0.0) / start
        passed = self.rate * self.onset * max(time, 0.0) + gain * start * (x**3 - 0.5 * x**4)
        rate = self.rate * self.onset + gain * (3.0 - 2.0 * x) * x**2
        return self.begin + passed, rate, gain * 6.0 * x * (1.0 - x) / start
