"""Pacing: how the duration of a motion goes with the length of its path.

In the flow: learned with the robust method; gives the tube of a scene its times. A hand that has farther to go takes
longer, but less than in proportion; a rest, a turn in place or a grasp takes as long as ever. Where the mean duration
stands for every scene, a short way in a new scene looks like the hurried beginning of a long one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pft_exec.geometry import Array

EXPONENT = 0.5  # of the length, expected before any demonstration: between equal times and equal speeds
EXPONENT_DEVIATION = 0.25
BOW_EXPONENT = 0.5  # of the length, by which residuals between the ends go; set on synthetic people, other seeds
PACE_DEVIATION = 0.25  # of the logarithm of the duration, between performances in one scene, before any of them
_HELD = 4.0  # degrees of freedom of that deviation
_LEAST_LENGTH = 1e-3  # of the longest path: shorter ones count as that long
_RESTING = 0.1  # of the mean step: a step of this length counts half as moving


@dataclass(frozen=True, eq=False)
class Pacing:
    """The moving part of a motion's duration goes with ``length ** exponent``.

    Parameters
    ----------
    length : (K,), m
        Of the path predicted for each demonstration's scene; zeros where the tool only turns.
    moving : (N - 1,)
        Share of each step that counts as moving, in [0, 1].
    exponent : float
        In [0, 1].
    """

    length: Array
    moving: Array
    exponent: float

    def carried(self, time: Array, position: Array) -> Array:
        """Times (K, N), s, of demonstrations as they would be along the path (N, 3), m, of another scene."""
        factor = 1.0 + (self._ratio(position) ** self.exponent - 1.0)[:, None] * self.moving
        gone = np.cumsum(np.diff(time, axis=1) * factor, axis=1)
        return np.hstack([time[:, :1], time[:, :1] + gone])

    def bowed(self, residual: Array, position: Array) -> Array:
        """Residuals (K, N, 3), m, as they would be along the path (N, 3), m, of another scene.

        Errors at the ends are errors of places, as large in any scene; how far a hand swings out between them goes
        with the length of its way, to a power between none and all of it.
        """
        steps = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(position, axis=0), axis=1)))
        share = (steps / steps[-1] if steps[-1] > 0.0 else np.linspace(0.0, 1.0, len(position)))[:, None]
        between = (1.0 - share) * residual[:, :1] + share * residual[:, -1:]
        bowed: Array = between + self._ratio(position)[:, None, None] ** BOW_EXPONENT * (residual - between)
        return bowed

    def _ratio(self, position: Array) -> Array:
        """(K,): how many times as long as in each demonstrated scene the way is here."""
        return _clamped(path_lengths(position[None]), self.length) / _clamped(self.length, self.length)


def path_lengths(position: Array) -> Array:
    """Lengths (K,), m, of paths (K, N, 3)."""
    length: Array = np.linalg.norm(np.diff(position, axis=1), axis=-1).sum(axis=1)
    return length


def learn_pacing(predicted: Array, position: Array, time: Array) -> Pacing:
    """Regress the logarithm of moving time on that of the path's length, around `EXPONENT`.

    Parameters
    ----------
    predicted, position : (K, N, 3), m
        Paths predicted for the demonstrations' scenes, and the aligned demonstrations.
    time : (K, N), s
    """
    length, moving = path_lengths(predicted), _moving_share(position)
    if length.max() <= 0.0 or not moving.any():
        return Pacing(length, moving, 0.0)
    far = np.log(_clamped(length, length))
    slow = np.log(np.maximum(np.diff(time, axis=1) @ moving, 1e-9))
    return Pacing(length, moving, _exponent(far - far.mean(), slow - slow.mean()))


def _exponent(far: Array, slow: Array) -> float:
    """Posterior mean slope of `slow` (K,) over `far` (K,), both centered; the noise is estimated with it."""
    square, product = float(far @ far), float(far @ slow)
    left = max(float(slow @ slow) - (product**2 / square if square > 0.0 else 0.0), 0.0)
    noise = (_HELD * PACE_DEVIATION**2 + left) / (_HELD + max(len(far) - 2, 0))
    held = noise / EXPONENT_DEVIATION**2
    return float(np.clip((held * EXPONENT + product) / (held + square), 0.0, 1.0))


def _moving_share(position: Array) -> Array:
    steps = np.linalg.norm(np.diff(position, axis=1), axis=-1).mean(axis=0)
    resting = _RESTING * float(steps.mean())
    share: Array = steps / (steps + resting) if resting > 0.0 else np.zeros(len(steps))
    return share


def _clamped(length: Array, all_lengths: Array) -> Array:
    """Lengths, none of them negligible beside the longest demonstrated one."""
    longest = float(all_lengths.max())
    clamped: Array = np.maximum(length, _LEAST_LENGTH * longest if longest > 0.0 else 1.0)
    return clamped
