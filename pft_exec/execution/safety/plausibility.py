r"""Plausibility of the measured state: readings that cannot be are left out, and the model goes on in their place.

Between two periods h apart a joint that was at :math:`q^-` is expected at :math:`\hat q = q^- + h\,(v^- + v)/2`. A
reading farther off than

.. math:: \epsilon + \tfrac12 A h^2,

with room :math:`\epsilon` for noise and the largest acceleration A that an impact gives a joint, is no motion of the
arm; where the joint has not been seen for a while, the room grows with that time. What is then believed is the
prediction. Where an encoder has slipped, its increments are still right: they are followed, its offset is not. How long
something has been in doubt is for a supervisor to judge.

The readings of a live arm carry noise in all their positions and velocities: the last one over again, to the last bit,
says that nothing was measured. In a moving arm that is certain at once; one that rests is given a moment.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pft_exec.geometry import Array
from pft_exec.model import JointLimits

Flags = NDArray[np.bool_]

ROOM = 0.002
"""rad; twenty standard deviations of ordinary encoder noise (1e-4 rad)."""
IMPACT = 1000.0
"""rad/s^2; a wrist of 0.02 kg m^2 that is hit with 100 N at 0.2 m."""
COAST_TIME = 0.02
"""s for which the model may stand in for readings that cannot be."""
FASTEST = 3.0
"""Multiple of a joint's velocity limit beyond which no reading of its velocity is believed."""
FADING = 0.05
"""s; time constant with which the velocity of a joint that is not seen is believed to fade."""
UNSEEN_SPEED = 0.2
"""rad/s; error of the velocity with which a joint that is not seen is believed to go on."""
STILL = 0.01
"""rad/s; joints that move faster cannot repeat a reading to the last bit."""
STILL_TIME = 0.03
"""s for which an arm that seems to rest may repeat a reading; simulated ones never do, not for one period."""


class StateGuard:
    """Believe what is plausible of an arm's measured states.

    Parameters
    ----------
    limits : JointLimits
    period : float, s
        Between two readings.
    still_time : float, s
        For which an arm that seems to rest may repeat a reading to the last bit: more for encoders so coarse that they
        do, infinite where nothing is to be concluded from it.
    """

    def __init__(self, limits: JointLimits, period: float, still_time: float = STILL_TIME) -> None:
        self._limits, self._period, self._still_time = limits, period, still_time
        self._tolerance = ROOM + 0.5 * IMPACT * period**2
        self._fading = math.exp(-period / FADING)
        self._reading: tuple[Array, Array] | None = None
        self._believed: tuple[Array, Array] | None = None
        self._offset: Array = np.zeros(len(limits.lower))
        self._dark: Array = np.zeros(len(limits.lower))  # s for which each joint has not been read at all
        self._repeating = 0.0  # s for which the last reading has come over again
        self.doubt = 0.0
        """s for which a reading has been in doubt without a break."""
        self.unseen: Flags = np.zeros(len(limits.lower), dtype=bool)
        """(n,): joints whose velocity is believed, not seen."""
        self.reason = ""
        """What was in doubt last; empty where nothing is."""

    def update(self, q: Array, v: Array) -> tuple[Array, Array]:
        """The state to believe, (n,), (n,), rad, rad/s, after a reading."""
        q, v = q.copy(), v.copy()  # a driver may write its next reading into the same arrays
        if self._believed is None:
            return self._begin(q, v)
        believed, speed = self._believed
        stale = self._is_repeated(q, v)
        fastest = FASTEST * self._limits.velocity
        is_clear = self.doubt == 0.0 and not stale
        if is_clear and _is_ordinary(q, v, believed, speed, self._period, self._tolerance, fastest):
            self._reading = self._believed = q, v
            return self._believed
        self._reading = q, v
        fast = ~(np.abs(v) <= fastest)  # NaN is too fast
        rate = np.where(fast, self._fading * speed, v)
        expected = believed + 0.5 * self._period * (speed + rate)
        self._dark = np.where(np.isfinite(q) & (not stale), self._dark, self._dark + self._period)
        wrong = ~(np.abs(q - expected) <= self._room)
        if not (wrong.any() or fast.any() or stale):
            self._clear()
            self._believed = q, v
            return self._believed
        self.doubt += self._period
        self.reason = self._describe(wrong, fast, stale, q - expected)
        self.unseen = np.full_like(fast, True) if stale else fast
        if stale:
            self._believed = expected, self._fading * speed
        else:
            self._believed = self._guess(q, expected, wrong), rate
        return self._believed

    @property
    def _room(self) -> Array:
        """(n,), rad: by how much a reading may differ from what is expected."""
        room: Array = self._tolerance + UNSEEN_SPEED * self._dark
        return room

    @property
    def is_lost(self) -> bool:
        """Whether the state has been in doubt for longer than the model may stand in."""
        return self.doubt > COAST_TIME

    def _begin(self, q: Array, v: Array) -> tuple[Array, Array]:
        """The first reading is believed as far as it is a number."""
        middle = 0.5 * (np.maximum(self._limits.lower, -np.pi) + np.minimum(self._limits.upper, np.pi))
        self._reading = q, v
        if np.isfinite(q).all() and np.isfinite(v).all():
            self._clear()
            self._believed = q, v
            return q, v
        self.doubt += self._period
        self.reason = "the first reading is not finite"
        return np.where(np.isfinite(q), q, middle), np.where(np.isfinite(v), v, 0.0)

    def _clear(self) -> None:
        self.doubt, self.reason = 0.0, ""
        self._offset[:] = 0.0
        self._dark[:] = 0.0
        self.unseen[:] = False

    def _is_repeated(self, q: Array, v: Array) -> bool:
        """Whether a reading is the last one over again, of an arm that moves or for too long."""
        last = self._reading
        if last is None or q.tobytes() != last[0].tobytes() or v.tobytes() != last[1].tobytes():
            self._repeating = 0.0
            return False
        self._repeating += self._period
        return self._repeating > self._still_time + 0.5 * self._period or bool((np.abs(v) > STILL).any())

    def _guess(self, q: Array, expected: Array, wrong: Flags) -> Array:
        """Positions (n,): as read, by the increments of an encoder that has slipped, or as expected."""
        slipped = q - self._offset
        follows = np.abs(slipped - expected) <= self._room
        fresh = wrong & ~follows
        self._offset = np.where(wrong, np.where(fresh & np.isfinite(q), q - expected, self._offset), 0.0)
        guess: Array = np.where(wrong, np.where(follows, slipped, expected), q)
        return guess

    def _describe(self, wrong: Flags, fast: Flags, stale: bool, step: Array) -> str:
        if stale:
            return "the encoders repeat their last reading"
        joint = int(np.argmax(wrong | fast))
        if wrong[joint] and np.isfinite(step[joint]):
            return f"the encoder of joint {joint + 1} jumped by {step[joint]:.3f} rad"
        return f"the encoder of joint {joint + 1} reports no number that could be"


@njit(cache=True)
def _is_ordinary(q: Array, v: Array, believed: Array, speed: Array, period: float, room: float, fastest: Array) -> bool:
    """Whether a reading is as expected in every joint."""
    for k in range(len(q)):
        if not abs(v[k]) <= fastest[k]:
            return False
        if not abs(q[k] - (believed[k] + 0.5 * period * (speed[k] + v[k]))) <= room:
            return False
    return True
