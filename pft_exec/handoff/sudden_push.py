r"""A sudden push, found as early as it can be told from noise: a cumulative sum of its impulse.

Of the force of each control period alone, :math:`F_k`, all that is beyond what is allowed is summed up,

.. math:: s \leftarrow s + h F_k, \qquad s \leftarrow s\,\max(0, 1 - h F_0 / \lVert s \rVert),

the multivariate cumulative sum of [Crosier1988]_: of all tests with the same rate of false alarms, a cumulative sum
notices a lasting change first [Lorden1971]_. Where the force that is allowed lies midway between the strongest push
that must not take back and the weakest that must, it is the likelihood ratio of the two. Noise of the measured
velocities does not pile up in the sum, for it is a change of momentum: it adds the noise of two readings, whatever lies
between. An arm is heavy at its tool in some directions and light in others, and its noise of momentum with it, by a
factor of three and more; so a push stands out in the metric of that noise, not by its size.
"""

from __future__ import annotations

import numpy as np

from pft_exec.geometry import Array
from pft_exec.handoff.felt import follow_scatter, gather, standing_out

IMPULSE = 0.01
"""N s beyond what is allowed; what 20 N give in 2 ms where 15 N are allowed."""
NOISE_TIME = 0.3
"""s over which the noise of the felt force is averaged."""
OUTSTANDING = 6.0
"""Standard deviations of the impulse of noise, in its own metric, by which a push stands out. With 5 one is found up to
5 ms sooner, but a lasting 14 N of the 15 that are allowed is often taken for one (measured, encoders of 1e-4 rad)."""
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
        self._scatter, self._change, self._count = np.zeros((3, 3)), np.zeros(3), 0
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
        size = gather(self._total, self._force, self._change, force, usual, allowed, period)
        self._learn(period)
        is_large = size > IMPULSE and self.outstanding(self._total, period) > OUTSTANDING
        if not is_large or self._count < LEARNING:
            self._since = None
            return False
        self._since = time if self._since is None else self._since
        return time - self._since >= self.hold_time - 1e-9

    def outstanding(self, impulse: Array, period: float) -> float:
        """Deviations of the noise by which an impulse (3,), N s, stands out where forces are told with a period, s."""
        return float(standing_out(impulse, (period**2 / 3.0) * self._scatter))

    def _learn(self, period: float) -> None:
        """Follow the noise, N^2: with white velocities, a change of force has three times the impulse's variance."""
        self._count += 1
        follow_scatter(self._scatter, self._change, max(1.0 / self._count, period / (period + NOISE_TIME)))
