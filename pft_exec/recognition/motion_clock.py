"""The motion's clock and direction: time that stops while the tool stands, and where it has been heading.

In the flow: both the demonstrations behind a tube and the stream of samples are read through this clock, so that a
pause, an idle start or a break costs a motion nothing. The direction is that of the displacement over the last short
while of the same clock, as the tempo of the person has it; it is short where the hand is slow. A hand that stands heads
nowhere new, and what is left of its movement is tremor: so the heading, by which a motion is judged, is then the last
direction that was more than that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from pft_exec.geometry import Array

RING = 17  # remembered places: the window and a little more, in eighths of it
_CLOCK, _TIME, _HEAD, _COUNT, _PUSHED, _STILL, _PACED = range(7)
SCALARS = 7
_CALM = 0.33  # of the patience: time constant of the place that stands or moves, for tremor is neither
_HEADED = 0.5  # length of a direction that is more than tremor: the displacement is that of the softness


@njit(cache=True, error_model="numpy")
def _seek(clock, ring, scalars, wanted, position, before):  # type: ignore[no-untyped-def]
    """Place at which the clock showed `wanted`, between remembered places, into `before`."""
    count, head = int(scalars[_COUNT]), int(scalars[_HEAD])
    later_clock = clock
    later = position
    for back in range(count):
        slot = (head - 1 - back) % RING
        if ring[slot, 0] <= wanted or back == count - 1:
            span = later_clock - ring[slot, 0]
            ratio = (wanted - ring[slot, 0]) / span if span > 1e-12 else 0.0
            ratio = min(max(ratio, 0.0), 1.0)
            for a in range(3):
                before[a] = ring[slot, 1 + a] + ratio * (later[a] - ring[slot, 1 + a])
            return
        later_clock = ring[slot, 0]
        later = ring[slot, 1:]
    before[:] = position


@njit(cache=True, error_model="numpy")
def _has_left(anchor, point, leash):  # type: ignore[no-untyped-def]
    """Whether a point is farther than `leash` from where it stood; then it stands here."""
    square = 0.0
    for a in range(len(anchor)):
        square += (point[a] - anchor[a]) ** 2
    if square <= leash * leash:
        return False
    anchor[:] = point
    return True


@njit(cache=True, error_model="numpy")
def advance_clock(  # type: ignore[no-untyped-def]
    scalars, ring, anchor, calm, direction, last, heading, time, position, point, tempo, constants
):
    """Take one sample; return by how much the clock went on, and write direction and heading (3,)."""
    leash, patience, slowest, window, softness = constants
    before = np.empty(3)
    elapsed = 0.0
    if scalars[_COUNT] == 0.0:
        anchor[:] = point
        calm[:] = point
        before[:] = position
    else:
        passed = time - scalars[_TIME]
        share = 1.0 - np.exp(-passed / (_CALM * patience))
        for a in range(len(point)):
            calm[a] += share * (point[a] - calm[a])
        scalars[_STILL] = 0.0 if _has_left(anchor, calm, leash) else scalars[_STILL] + passed
        elapsed = passed if scalars[_STILL] <= patience else slowest * passed
        scalars[_CLOCK] += elapsed
        scalars[_PACED] += tempo * elapsed
        _seek(scalars[_PACED], ring, scalars, scalars[_PACED] - window, position, before)
    scalars[_TIME] = time
    if scalars[_COUNT] == 0.0 or scalars[_PACED] - scalars[_PUSHED] >= 0.125 * window:
        head = int(scalars[_HEAD])
        ring[head, 0] = scalars[_PACED]
        ring[head, 1:] = position
        scalars[_PUSHED] = scalars[_PACED]
        scalars[_HEAD] = (head + 1) % RING
        scalars[_COUNT] = min(scalars[_COUNT] + 1.0, RING)
    square = 0.0
    for a in range(3):
        direction[a] = position[a] - before[a]
        square += direction[a] ** 2
    length = np.sqrt(square) + softness
    for a in range(3):
        direction[a] /= length
    if np.sqrt(square) >= _HEADED * length:
        last[:] = direction
    heading[:] = last if scalars[_STILL] > patience else direction
    return elapsed


@njit(cache=True, error_model="numpy")
def _read(time, position, point, tempo, constants):  # type: ignore[no-untyped-def]
    count = len(time)
    scalars, ring = np.zeros(SCALARS), np.zeros((RING, 4))
    anchor, calm = np.zeros(point.shape[1]), np.zeros(point.shape[1])
    clock, lengths, headings = np.zeros(count), np.zeros(count), np.zeros((count, 3))
    direction, last, heading = np.zeros(3), np.zeros(3), np.zeros(3)
    for n in range(count):
        advance_clock(
            scalars, ring, anchor, calm, direction, last, heading, time[n], position[n], point[n], tempo, constants
        )
        clock[n] = scalars[_CLOCK]
        lengths[n] = np.sqrt((direction**2).sum())
        headings[n] = heading
    return clock, lengths, headings


@dataclass(frozen=True)
class ClockScales:
    """What the clock measures movement by; one set for the library.

    Parameters
    ----------
    extent, rotation : float, m and rad
        Median extents of the motions.
    signals : {name: float}
        Pooled ranges of the continuous signals.
    duration : float, s
        Median duration.
    noise : float
        How rough the demonstrations' paths are, in extents.
    """

    extent: float
    rotation: float
    signals: dict[str, float]
    duration: float
    noise: float = 0.0

    def per_unit(self) -> Array:
        """What the components of a sample (position, orientation and signals) are multiplied by."""
        scales = [self.extent] * 3 + [0.5 * self.rotation] * 4 + list(self.signals.values())
        return 1.0 / np.array(scales)

    def points(self, position: Array, quaternion: Array | None, signals: dict[str, Array]) -> Array:
        """Rows (N, 7 + signals): position, orientation and signals, each in its own extent."""
        count = len(position)
        turn = np.zeros((count, 4)) if quaternion is None else 2.0 * quaternion / self.rotation
        columns = [
            signals[name] / scale if name in signals else np.zeros(count) for name, scale in self.signals.items()
        ]
        return np.ascontiguousarray(np.hstack([position / self.extent, turn, *(c[:, None] for c in columns)]))


def read_clock(time: Array, position: Array, points: Array, constants: Array) -> Array:
    """Clock (N,), s, along a path that was recorded at `time` (N,)."""
    clock: Array = _read(time, np.ascontiguousarray(position), points, 1.0, constants)[0]
    return clock


def read_path(time: Array, position: Array, points: Array, constants: Array, tempo: float = 1.0) -> tuple[Array, Array]:
    """Lengths (N,) of the direction and heading (N, 3) along a path of somebody so much faster than the others."""
    _, lengths, headings = _read(time, np.ascontiguousarray(position), points, tempo, constants)
    return lengths, headings


class MotionClock:
    """The clock of a stream of samples; memory is constant.

    Parameters
    ----------
    constants : (5,)
        Leash, patience (s), pace while standing, window (s), softness (m).
    size : int
        Components of a point.
    """

    def __init__(self, constants: Array, size: int) -> None:
        self._constants = constants
        self._scalars = np.zeros(SCALARS)
        self._ring = np.zeros((RING, 4))
        self._anchor, self._calm = np.zeros(size), np.zeros(size)
        self._last: Array = np.zeros(3)
        self.direction: Array = np.zeros(3)
        """Displacement d over the window, as d / (|d| + softness): where the tool moves now, and how fast."""
        self.heading: Array = np.zeros(3)
        """The last direction that was more than tremor."""

    @property
    def clock(self) -> float:
        """Time on the motion's clock, s."""
        return float(self._scalars[_CLOCK])

    def advance(self, time: float, position: Array, point: Array, tempo: float = 1.0) -> float:
        """Take one sample; by how much the clock went on, s. `direction` and `heading` are those after it.

        They are taken over so much less time, the higher the person's `tempo` is beside the tubes'.
        """
        state = self._scalars, self._ring, self._anchor, self._calm, self.direction, self._last, self.heading
        elapsed = advance_clock(*state, time, position, point, tempo, self._constants)
        return float(elapsed)
