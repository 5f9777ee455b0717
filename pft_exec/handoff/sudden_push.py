r"""A sudden push, found as early as it can be told from noise: a cumulative sum of its impulse.

Of the force of each control period alone, :math:`F_k`, all that is beyond what is allowed is summed up,

.. math:: s \leftarrow s + h F_k, \qquad s \leftarrow s\,\max(0, 1 - h F_0 / \lVert s \rVert),

the multivariate cumulative sum of [Crosier1988]_: of all tests with the same rate of false alarms, a cumulative sum
notices a lasting change first [Lorden1971]_. Where the force that is allowed lies midway between the strongest push
that must not take back and the weakest that must, it is the likelihood ratio of the two. Noise of the measured
velocities does not pile up in the sum, for it is a change of momentum: it adds the noise of two readings, whatever lies
between.
"""

from __future__ import annotations

import math

import numpy as np

from pft_exec.geometry import Array
from pft_exec.handoff.felt import gather

IMPULSE = 0.01
"""N s beyond what is allowed; what 20 N give in 2 ms where 15 N are allowed."""
NOISE_TIME = 0.3
"""s over which the noise of the felt force is averaged."""
OUTSTANDING = 6.0
"""Standard deviations of the impulse of noise by which a push stands out."""
LEARNING = 20
"""Control periods until the noise is known well enough."""


class SuddenPush:
    """Notice a push by its impulse; an impact, which is over before the hold time, is none.

    Parameters
    ----------
    hold_time : float, s
        For which the impulse must stay.
    """

    def __init__(self, hold_time: float) -> None:
        self.hold_time = hold_time
        self._variance, self._count = 0.0, 0
        self.forget()

    def forget(self) -> None:
        """Begin a new sum; what is known of the noise stays."""
        self._total: Array = np.zeros(3)
        self._force: Array = np.zeros(3)
        self._time: float | None = None
        self._since: float | None = None

    def update(self, time: float, force: Array, usual: Array, allowed: float) -> bool:
        """Whether there is a push.

        Parameters
        ----------
        time : float, s
        force, usual : (3,), N
            Of the control period that ends now, and what lasts of it.
        allowed : float, N
        """
        if self._time is None:
            self._time, self._force = time, force.copy()
            return False
        period, self._time = time - self._time, time
        size, change = gather(self._total, self._force, force, usual, allowed, period)
        self._learn(period, change)
        if size <= self.least_impulse(period) or self._count < LEARNING:
            self._since = None
            return False
        self._since = time if self._since is None else self._since
        return time - self._since >= self.hold_time - 1e-9

    def least_impulse(self, period: float) -> float:
        """Impulse, N s, from which on a push stands out of the noise of forces that are told with a period, s."""
        return max(IMPULSE, OUTSTANDING * period * math.sqrt(self._variance))

    def _learn(self, period: float, change: float) -> None:
        """Follow the noise, N^2: with white velocities, a change of force has three times the impulse's variance."""
        self._count += 1
        share = max(1.0 / self._count, period / (period + NOISE_TIME))
        self._variance += share * (change / 3.0 - self._variance)
