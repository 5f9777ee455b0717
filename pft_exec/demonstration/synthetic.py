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
)


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


STEADY = HumanStyle(0.0, 0.0, 0.0, 0.0, 0.0, (0.0, 0.0), 0.0, 0.0, (8.0, 12.0), 0.0, 0.0)


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

    @property
    def duration(self) -> float:
        """From the first movement to the last, s."""
        return float(np.max(self.onsets + self.spans)) + self.pause_cost

    def at(self, time: ArrayLike) -> tuple[Array, Array]:
        """Position (..., 3), m, and orientation (..., 4), (x, y, z, w), at times (...), s."""
        wall = np.clip(np.asarray(time, dtype=float), 0.0, self.duration)
        own = self._own_clock(wall)
        share = minimum_jerk((own[..., None] - self.onsets) / self.spans)
        phase = minimum_jerk(own / np.max(self.onsets + self.spans))
        shaking = _envelope(wall / self.duration)[..., None] * self._shaking(wall)
        position = self.origin + share @ self.steps + _waves(phase) @ self.bows + shaking[..., :3]
        quaternion = np.broadcast_to(self.first, (*wall.shape, 4))
        for index, turn in enumerate(self.turns):
            quaternion = multiply(quaternion, quaternion_from_rotation_vector(share[..., index, None] * turn))
        deviation = _waves(phase) @ self.wobbles + shaking[..., 3:]
        return position, normalize_quaternion(multiply(quaternion, quaternion_from_rotation_vector(deviation)))

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
) -> HumanPath:
    """Let a synthetic person move through waypoints.

    Parameters
    ----------
    positions : (W, 3), m
        W >= 2; the path begins exactly at the first and ends near the last.
    quaternions : (W, 4), (x, y, z, w), or None
        None leaves the orientation at identity.
    durations : (W - 1,), s
        From each waypoint to the next, of an average person.
    rng : Generator
        All that is of chance: the same generator state gives the same path.
    style : HumanStyle, optional
    planar : bool
        Nothing of chance leaves the xy plane or turns the tool.

    Raises
    ------
    InvalidDemonstrationError
        If shapes do not fit, a number is not finite, or a duration is not above 0.
    """
    style = style or HumanStyle()
    positions, quaternions, durations = _checked(positions, quaternions, durations)
    axes = np.array([1.0, 1.0, 0.0 if planar else 1.0])
    turning = 0.0 if planar else 1.0
    steps, turns = np.diff(positions, axis=0), relative_rotation_vector(quaternions[:-1], quaternions[1:])
    pace = np.exp(style.pace * np.clip(rng.standard_normal(), -1.5, 1.5))
    steps[-1] += style.end_error * axes * rng.standard_normal(3)
    turns[-1] += style.end_angle * turning * rng.standard_normal(3)
    onsets, spans = _timing(durations * pace, style.overlap)
    length = float(np.linalg.norm(steps, axis=1).sum())
    bows = _sideways(style.bow * length * axes * rng.standard_normal((2, 3)), positions[-1] - positions[0])
    wobbles = style.wobble * turning * rng.standard_normal((2, 3))
    tremor, tremor_angle, rates = _draw_tremor(style, rng, axes, turning)
    pause_at, pause_cost = _draw_pause(style, rng, float(np.max(onsets + spans)))
    weights = np.array([[1.0], [0.5]])  # the second half wave makes a slight S
    return HumanPath(
        positions[0],
        quaternions[0],
        steps,
        turns,
        onsets,
        spans,
        weights * bows,
        weights * wobbles,
        tremor,
        tremor_angle,
        rates,
        pause_at,
        pause_cost,
    )


def _timing(durations: Array, overlap: float) -> tuple[Array, Array]:
    """Onsets and spans (S,), s: each submovement but the first begins early, by a share of its shorter neighbour."""
    early = overlap * np.minimum(durations[1:], durations[:-1])
    onsets = np.append(0.0, np.cumsum(durations)[:-1] - 0.5 * early)
    ends = np.append(np.cumsum(durations)[:-1] + 0.5 * early, durations.sum())
    return onsets, ends - onsets


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
