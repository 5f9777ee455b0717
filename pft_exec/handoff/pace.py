r"""The pace: a clock for a reference that may be slowed down, stopped and let go on, without a jump.

The rate r of the clock follows the wanted one as a critically damped oscillator,
:math:`\ddot r = \omega^2 (r_w - r) - 2 \omega \dot r`, solved exactly over each control period. Reference position,
velocity and acceleration, the derivatives of :math:`x(\theta(t))`, stay continuous whatever is wanted when.
"""

from __future__ import annotations

import math

RESPONSE = 12.0
"""1/s; a stop along the tube takes about 0.4 s."""


class PacedClock:
    """Time of a reference, s, that begins at zero and runs at rate 1 until another rate is wanted."""

    def __init__(self) -> None:
        self.time = 0.0
        self.rate = 1.0
        self.change = 0.0
        """1/s; derivative of the rate."""

    def advance(self, period: float, wanted: float = 1.0) -> None:
        """Run for a control period, s, towards a wanted rate."""
        fade = math.exp(-RESPONSE * period)
        offset = self.rate - wanted
        slope = self.change + RESPONSE * offset
        self.time += wanted * period + offset * (1.0 - fade) / RESPONSE
        self.time += slope * (1.0 - fade * (1.0 + RESPONSE * period)) / RESPONSE**2
        self.rate = wanted + (offset + slope * period) * fade
        self.change = (slope - RESPONSE * (offset + slope * period)) * fade
