r"""Synthetic people: tool paths such as a human hand makes, each time a little different.

A path runs through waypoints without stopping: every piece between two of them is a submovement with the minimum-jerk
profile :math:`m(u) = 10 u^3 - 15 u^4 + 6 u^5` [Flash1985]_, neighbouring submovements overlap in time and add up
[Henis1995]_. To that come a bow of the whole path, the pace of the day, an occasional pause, tremor, and a small error
at the end. All of it is smooth: position, velocity and acceleration are continuous and the hand rests at both ends.

Neither learner nor recognizer knows this module: what they find in a demonstration they find by themselves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.exceptions import InvalidDemonstrationError
from pft_exec.geometry import (
    Array,
    multiply,
    normalize_quaternion,
    quaternion_from_rotation_vector,
    relative_rotation_vector,
    rotate,
)

_CLOCK_STEP = 0.005  # s; at which the person's clock is inverted


@dataclass(frozen=True)
class HumanStyle:
    """How a synthetic person moves; zeros give the bare minimum-jerk path.

    Parameters
    ----------
    overlap : float
        Share of the shorter neighbour by which two submovements overlap, in [0, 1); 0 stops at every waypoint.
    bow : float
        Standard deviation of the sideways deviation of the path's middle, as a share of its length.
    wobble : float, rad
        Standard deviation of the orientation's deviation in the middle, per axis.
    pace : float
        Standard deviation of the logarithm of the duration; never more than 1.5 times that off.
    pause_probability : float
        How likely a path holds a pause.
    pause : (float, float), s
        Shortest and longest time that a pause costs.
    tremor, tremor_angle : float, m and rad
        Amplitude (root mean square, per axis) of the trembling.
    tremor_band : (float, float), Hz
        Physiological tremor of the hand: 8 to 12 Hz.
    end_error, end_angle : float, m and rad
        Standard deviation, per axis, of where the path ends.
    curve_size, curve_tilt : float, of the size and rad
        Standard deviation of the logarithm of a curve's size, and, per axis, of the turn of its plane.

    Notes
    -----
    The figures are of the size that is common for unhurried reaching; none is a measurement of one person.
    """

    overlap: float = 0.5
    bow: float = 0.04
    wobble: float = 0.02
    pace: float = 0.12
    pause_probability: float = 0.3
    pause: tuple[float, float] = (0.1, 0.35)
    tremor: float = 1.5e-4
    tremor_angle: float = 5e-4
    tremor_band: tuple[float, float] = (8.0, 12.0)
    end_error: float = 1.5e-3
    end_angle: float = 0.012
    curve_size: float = 0.03
    curve_tilt: float = 0.03


STEADY = HumanStyle(0.0, 0.0, 0.0, 0.0, 0.0, (0.0, 0.0), 0.0, 0.0, (8.0, 12.0), 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class HumanPath:
    """A tool path that can be asked for any time; before 0 it rests at the start, after `duration` at the end.

    Parameters
    ----------
    origin : (3,), m
    first : (4,), (x, y, z, w)
    steps, turns : (S, 3), m and rad
        Displacement and rotation vector (in the frame turned so far) of each submovement.
    onsets, spans : (S,), s
        When each begins on the person's own clock, and how long it lasts.
    bows, wobbles : (2, 3), m and rad
        Amplitudes of the deviation's first and second half wave.
    tremor, tremor_angle : (2, T, 3), m and rad
        Amplitudes of sines and cosines at `tremor_rates`.
    tremor_rates : (T,), rad/s
    pause_at, pause_cost : float, s
        Middle of a pause on the wall clock and what it costs; cost 0 is no pause.
    legs : (L, 2), s
        From one standstill to the next, on the person's own clock; a path without stops is one leg.
    leg_weights : (L,)
        Share of the bows in each leg.
    own_arrivals : (W - 1,), s
        At the waypoints, on the person's own clock.
    curve : (M, 3), m, or None
        Displacement at even shares of its time.
    curve_onset, curve_span : float, s
        On the person's own clock.
    """

    origin: Array
    first: Array
    steps: Array
    turns: Array
    onsets: Array
    spans: Array
    bows: Array
    wobbles: Array
    tremor: Array
    tremor_angle: Array
    tremor_rates: Array
    pause_at: float
    pause_cost: float
    legs: Array
    leg_weights: Array
    own_arrivals: Array
    curve: Array | None = None
    curve_onset: float = 0.0
    curve_span: float = 0.0

    @property
    def duration(self) -> float:
        """From the first movement to the last, s."""
        return float(self.legs[-1, 1]) + self.pause_cost

    @property
    def arrivals(self) -> Array:
        """When the hand is at each waypoint after the start, (W - 1,), s."""
        wall = np.arange(0.0, self.duration + _CLOCK_STEP, _CLOCK_STEP)
        return np.asarray(np.interp(self.own_arrivals, self._own_clock(wall), wall), dtype=float)

    def at(self, time: ArrayLike) -> tuple[Array, Array]:
        """Position (..., 3), m, and orientation (..., 4), (x, y, z, w), at times (...), s."""
        wall = np.clip(np.asarray(time, dtype=float), 0.0, self.duration)
        own = self._own_clock(wall)
        share = minimum_jerk((own[..., None] - self.onsets) / self.spans)
        shaking = _envelope(wall / self.duration)[..., None] * self._shaking(wall)
        waves = self._waves(own)
        position = self.origin + share @ self.steps + waves @ self.bows + shaking[..., :3]
        if self.curve is not None:
            position = position + _curve_at(self.curve, (own - self.curve_onset) / self.curve_span)
        quaternion = np.broadcast_to(self.first, (*wall.shape, 4))
        for index, turn in enumerate(self.turns):
            quaternion = multiply(quaternion, quaternion_from_rotation_vector(share[..., index, None] * turn))
        deviation = waves @ self.wobbles + shaking[..., 3:]
        return position, normalize_quaternion(multiply(quaternion, quaternion_from_rotation_vector(deviation)))

    def _waves(self, own: Array) -> Array:
        """First and second half wave (..., 2), leg by leg: none at a standstill."""
        begins, ends = self.legs.T
        phase = minimum_jerk((own[..., None] - begins) / (ends - begins))
        waves: Array = np.einsum("...lk,l->...k", _waves(phase), self.leg_weights)
        return waves

    def sample(self, period: float) -> tuple[Array, Array, Array]:
        """Time (N,), s, position (N, 3), m, and orientation (N, 4), (x, y, z, w), every `period` s and at the end."""
        time = np.append(np.arange(0.0, self.duration - 0.5 * period, period), self.duration)
        return time, *self.at(time)

    def _own_clock(self, time: Array) -> Array:
        """Time on the person's clock, which all but stands still during the pause."""
        if self.pause_cost == 0.0:
            return time
        width = 2.0 * self.pause_cost  # of a raised cosine, whose area is half its width
        inside = np.clip((time - self.pause_at) / width + 0.5, 0.0, 1.0)
        lost = width * (0.5 * inside - np.sin(2.0 * np.pi * inside) / (4.0 * np.pi))
        own: Array = time - lost
        return own

    def _shaking(self, time: Array) -> Array:
        angle = time[..., None] * self.tremor_rates
        sine, cosine = np.sin(angle), np.cos(angle)
        position = sine @ self.tremor[0] + cosine @ self.tremor[1]
        rotation = sine @ self.tremor_angle[0] + cosine @ self.tremor_angle[1]
        return np.concatenate([position, rotation], axis=-1)


def minimum_jerk(ratio: ArrayLike) -> Array:
    """Share of the way at shares of the time (...), clipped to [0, 1]: 10 u^3 - 15 u^4 + 6 u^5 [Flash1985]_."""
    u = np.clip(np.asarray(ratio, dtype=float), 0.0, 1.0)
    share: Array = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    return share


def human_path(
    positions: ArrayLike,
    quaternions: ArrayLike | None,
    durations: ArrayLike,
    rng: np.random.Generator,
    style: HumanStyle | None = None,
    *,
    planar: bool = False,
    rests: ArrayLike | None = None,
    curve: ArrayLike | None = None,
    curve_duration: float = 0.0,
) -> HumanPath:
    """Let a synthetic person move through waypoints, and then along a curve.

    Parameters
    ----------
    positions : (W, 3), m
        W >= 2, or 1 where there is a curve; the path begins exactly at the first and ends near the last.
    quaternions : (W, 4), (x, y, z, w), or None
        None leaves the orientation at identity.
    durations : (W - 1,), s
        From each waypoint to the next, of an average person.
    rng : Generator
        All that is of chance: the same generator state gives the same path.
    style : HumanStyle, optional
    planar : bool
        Nothing of chance leaves the xy plane or turns the tool.
    rests : (W - 1,), s, optional
        For which the hand stands still at each waypoint after the start; after the last only a curve waits for it.
    curve : (M, 3), m, optional
        Displacement from the last waypoint at even shares of `curve_duration`, s.

    Raises
    ------
    InvalidDemonstrationError
        If shapes do not fit, a number is not finite, or a duration is not above 0.
    """
    style = style or HumanStyle()
    drawn = None if curve is None else np.asarray(curve, dtype=float)
    is_alone = drawn is not None and len(np.asarray(positions)) == 1
    positions, quaternions, durations = _checked(*_resting(positions, quaternions, durations, drawn, curve_duration))
    still = np.zeros(len(durations)) if rests is None or np.size(rests) == 0 else np.asarray(rests, dtype=float)
    pace = np.exp(style.pace * np.clip(rng.standard_normal(), -1.5, 1.5))
    steps, turns = _draw_steps(positions, quaternions, style, rng, planar)
    onsets, spans, arrivals = _timing(durations * pace, style.overlap, still)
    lengths = np.linalg.norm(steps, axis=1)
    deviations = _draw_deviations(style, rng, planar, float(lengths.sum()), positions[-1] - positions[0])
    curve_onset = float(arrivals[-1] + still[-1]) if drawn is not None and not is_alone else 0.0
    drawn = None if drawn is None else _varied(drawn, style, rng)
    over = max(float(np.max(onsets + spans)), curve_onset + pace * curve_duration)
    return HumanPath(
        positions[0],
        quaternions[0],
        steps,
        turns,
        onsets,
        spans,
        *deviations,
        *_draw_pause(style, rng, over),
        *_legs(arrivals, still, lengths, over),
        arrivals,
        drawn,
        curve_onset,
        pace * curve_duration,
    )


def _draw_steps(
    positions: Array, quaternions: Array, style: HumanStyle, rng: np.random.Generator, planar: bool
) -> tuple[Array, Array]:
    """Displacement and rotation vector (S, 3) of each submovement; the last misses its end a little."""
    steps, turns = np.diff(positions, axis=0), relative_rotation_vector(quaternions[:-1], quaternions[1:])
    axes, turning = _of_chance(planar)
    steps[-1] += style.end_error * axes * rng.standard_normal(3)
    turns[-1] += style.end_angle * turning * rng.standard_normal(3)
    return steps, turns


def _draw_deviations(
    style: HumanStyle, rng: np.random.Generator, planar: bool, length: float, direction: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Bows and wobbles (2, 3) of a way of some length, m, in a direction (3,), and the tremor on it."""
    axes, turning = _of_chance(planar)
    bows = _sideways(style.bow * length * axes * rng.standard_normal((2, 3)), direction)
    wobbles = style.wobble * turning * rng.standard_normal((2, 3))
    weights = np.array([[1.0], [0.5]])  # the second half wave makes a slight S
    return weights * bows, weights * wobbles, *_draw_tremor(style, rng, axes, turning)


def _of_chance(planar: bool) -> tuple[Array, float]:
    """Shares of chance along the axes (3,) and in rotation: in a plane, nothing leaves it and nothing turns."""
    return np.array([1.0, 1.0, 0.0 if planar else 1.0]), 0.0 if planar else 1.0


def _timing(durations: Array, overlap: float, rests: Array) -> tuple[Array, Array, Array]:
    """Onsets, spans and arrivals (S,), s, of submovements.

    Each but the first begins early, by a share of its shorter neighbour, unless the hand rests before it.
    """
    early = np.where(rests[:-1] > 0.0, 0.0, overlap * np.minimum(durations[1:], durations[:-1]))
    begins = np.append(0.0, np.cumsum(durations + rests)[:-1])
    arrivals = begins + durations
    onsets = np.append(0.0, begins[1:] - 0.5 * early)
    ends = np.append(arrivals[:-1] + 0.5 * early, arrivals[-1])
    return onsets, ends - onsets, arrivals


def _legs(arrivals: Array, rests: Array, lengths: Array, over: float) -> tuple[Array, Array]:
    """Legs (L, 2), s, from standstill to standstill, and each one's share (L,) of the way."""
    stops = [index for index in range(len(arrivals) - 1) if rests[index] > 0.0]
    begins = [0.0, *(float(arrivals[index] + rests[index]) for index in stops)]
    ends = [*(float(arrivals[index]) for index in stops), over]
    ways = np.array([part.sum() for part in np.split(lengths, [index + 1 for index in stops])])
    weights = ways / ways.sum() if ways.sum() > 0.0 else np.ones(len(ways))
    return np.stack([begins, ends], axis=1), weights


def _resting(
    positions: ArrayLike,
    quaternions: ArrayLike | None,
    durations: ArrayLike,
    curve: Array | None,
    curve_duration: float,
) -> tuple[ArrayLike, ArrayLike | None, ArrayLike]:
    """The waypoints; a curve alone goes with a movement to nowhere, over which the error at the end comes in."""
    if curve is None or len(np.asarray(positions)) != 1:
        return positions, quaternions, durations
    twice = None if quaternions is None else np.repeat(np.asarray(quaternions, dtype=float), 2, axis=0)
    return np.repeat(np.asarray(positions, dtype=float), 2, axis=0), twice, [curve_duration]


def _varied(curve: Array, style: HumanStyle, rng: np.random.Generator) -> Array:
    """A curve (M, 3) as it comes out this time: a little larger or smaller, in a plane turned a little."""
    size, tilt = np.exp(style.curve_size * rng.standard_normal()), style.curve_tilt * rng.standard_normal(3)
    varied: Array = size * rotate(quaternion_from_rotation_vector(tilt), curve)
    return varied


def _curve_at(curve: Array, share: Array) -> Array:
    """Displacement (..., 3), m, at shares (...) of a tabulated curve (M, 3): cubic between neighbours."""
    place = np.clip(share, 0.0, 1.0) * (len(curve) - 1)
    index = np.minimum(place.astype(int), len(curve) - 2)
    x = (place - index)[..., None]
    slope = np.gradient(curve, axis=0)
    first, last = curve[index], curve[index + 1]
    smooth = x * x * (3.0 - 2.0 * x)
    bent = x * (1.0 - x) * ((1.0 - x) * slope[index] - x * slope[index + 1])
    displacement: Array = first + smooth * (last - first) + bent
    return displacement


def _sideways(vectors: Array, direction: Array) -> Array:
    """Vectors (2, 3) without their part along a direction (3,); unchanged where that has no length."""
    length = float(np.linalg.norm(direction))
    if length < 1e-9:
        return vectors
    unit = direction / length
    sideways: Array = vectors - (vectors @ unit)[:, None] * unit
    return sideways


def _draw_tremor(
    style: HumanStyle, rng: np.random.Generator, axes: Array, turning: float
) -> tuple[Array, Array, Array]:
    """Amplitudes (2, T, 3) of sines and cosines at T = 3 rates, rad/s, within the band."""
    rates = 2.0 * np.pi * rng.uniform(*style.tremor_band, 3)
    shares = rng.standard_normal((2, 2, 3, 3)) / np.sqrt(3.0)
    return style.tremor * axes * shares[0], style.tremor_angle * turning * shares[1], rates


def _draw_pause(style: HumanStyle, rng: np.random.Generator, duration: float) -> tuple[float, float]:
    """When, s, and how long, s; drawn whether or not there is one, so that what follows does not depend on it."""
    happens, where, ratio = rng.random(3)
    cost = style.pause[0] + ratio * (style.pause[1] - style.pause[0])
    if happens >= style.pause_probability:
        return 0.0, 0.0
    return (0.3 + 0.4 * where) * duration + 0.5 * cost, cost


def _envelope(ratio: Array) -> Array:
    """Of the tremor: 0 at both ends, 1 between; smooth."""
    rising: Array = minimum_jerk(ratio / 0.15) * minimum_jerk((1.0 - ratio) / 0.15)
    return rising


def _waves(phase: Array) -> Array:
    """First and second half wave (..., 2) over the phase; with a minimum-jerk phase they begin and end at rest."""
    return np.stack([np.sin(np.pi * phase), np.sin(2.0 * np.pi * phase)], axis=-1)


def _checked(positions: ArrayLike, quaternions: ArrayLike | None, durations: ArrayLike) -> tuple[Array, Array, Array]:
    position, duration = np.asarray(positions, dtype=float), np.asarray(durations, dtype=float)
    count = len(position) if position.ndim == 2 else 0
    identity = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))
    quaternion = identity if quaternions is None else np.asarray(quaternions, dtype=float)
    if count < 2 or position.shape != (count, 3) or quaternion.shape != (count, 4) or duration.shape != (count - 1,):
        raise InvalidDemonstrationError(
            f"a path needs W >= 2 positions (W, 3), quaternions (W, 4) and durations (W - 1,); got {position.shape}, "
            f"{quaternion.shape} and {duration.shape}."
        )
    if not all(np.isfinite(values).all() for values in (position, quaternion, duration)) or (duration <= 0.0).any():
        raise InvalidDemonstrationError("waypoints and durations must be finite, and durations above 0 s.")
    return position, normalize_quaternion(quaternion), duration
