"""The hand of a synthetic person: a bounded spring-damper that leads the tool along a path, and lets go.

It stands where a real person's hand would: it knows where it wants to be, feels nothing but the tool, and pushes with
limited force. What comes of it is up to the arm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.exceptions import SimulationError
from pft_exec.geometry import Array, conjugate, multiply, rotation_vector_from_quaternion

_LOST = 1e-12  # N or N m; below it there is no direction to bound


class ToolPath(Protocol):
    """A path of the tool, world frame: at rest before time 0 and after its duration."""

    @property
    def duration(self) -> float:
        """From the first movement to the last, s."""

    def at(self, time: ArrayLike) -> tuple[Array, Array]:
        """Position (N, 3), m, and orientation (N, 4), (x, y, z, w), at times (N,), s."""


@dataclass(frozen=True)
class HandGrip:
    """How a hand holds the tool; stiffness, damping and bounds of a firm human grip.

    Parameters
    ----------
    stiffness, damping : float, N/m and N s/m
    rotational_stiffness, rotational_damping : float, N m/rad and N m s/rad
    force_limit, torque_limit : float, N and N m

    Notes
    -----
    Measured on the PR2 with joint friction 0.5 N m: 24 cm in 2 s follow within 2.2 mm rms at 6 N. A damping above
    1000 N s/m chatters at a step of 1 ms.
    """

    stiffness: float = 1500.0
    damping: float = 80.0
    rotational_stiffness: float = 30.0
    rotational_damping: float = 1.0
    force_limit: float = 30.0
    torque_limit: float = 3.0


class HandGuide:
    """A hand that leads the tool along a path, from time 0 on its own clock.

    Parameters
    ----------
    path : ToolPath
        World frame; such as a `HumanPath` or `recorded_path`.
    grip : HandGrip
    step : float, s
        The path is sampled that finely, once; the physics step of the world that it acts in.

    Raises
    ------
    SimulationError
        If the step is not positive or the path is not finite.
    """

    def __init__(self, path: ToolPath, grip: HandGrip | None = None, step: float = 1e-3) -> None:
        if not step > 0.0:
            raise SimulationError(f"the step at which a hand's path is sampled must be positive; got {step} s.")
        self.grip = grip or HandGrip()
        self.duration = path.duration
        self._step = step
        time = step * np.arange(math.ceil(path.duration / step) + 2)
        self._position, quaternion = path.at(time)
        if not (np.isfinite(self._position).all() and np.isfinite(quaternion).all()):
            raise SimulationError("the path of a hand must be finite.")
        self._quaternion = quaternion
        self._velocity = np.hstack([np.gradient(self._position, step, axis=0), _angular_velocity(quaternion, step)])
        self._velocity[[0, -1]] = 0.0
        self._last = len(time) - 1
        self._released: float | None = None
        self._fade = 0.0

    def let_go(self, time: float, fade: float = 0.0) -> None:
        """Let go at a time, s, at once or with a force that fades out over `fade` s."""
        self._released, self._fade = time, fade

    def hold(self) -> None:
        """Take hold (again): the hand is where its path is by now."""
        self._released = None

    def strength(self, time: float) -> float:
        """Share of its force that the hand exerts at a time, s: 1 holding, 0 gone."""
        if self._released is None or time < self._released:
            return 1.0
        since = time - self._released
        return 1.0 - since / self._fade if since < self._fade else 0.0

    def pose(self, time: float) -> tuple[Array, Array]:
        """Where the hand wants the tool at a time, s: position (3,), m, quaternion (4,), (x, y, z, w), world frame."""
        index = self._index(time)
        return self._position[index].copy(), self._quaternion[index].copy()

    def wrench(self, time: float, position: Array, quaternion: Array, velocity: Array) -> tuple[Array, Array]:
        """Force (3,), N, and torque (3,), N m, on the tool, world frame.

        Parameters
        ----------
        time : float, s
            On the clock of the path.
        position : (3,), m
        quaternion : (4,), (x, y, z, w)
        velocity : (6,), m/s and rad/s
            Of the tool now, linear then angular, world frame.
        """
        strength = self.strength(time)
        if strength == 0.0:
            return np.zeros(3), np.zeros(3)
        index, grip = self._index(time), self.grip
        slip = self._velocity[index] - velocity
        force = grip.stiffness * (self._position[index] - position) + grip.damping * slip[:3]
        turn = _rotation_between(quaternion, self._quaternion[index])
        torque = grip.rotational_stiffness * turn + grip.rotational_damping * slip[3:]
        return strength * _bounded(force, grip.force_limit), strength * _bounded(torque, grip.torque_limit)

    def _index(self, time: float) -> int:
        return min(max(round(time / self._step), 0), self._last)


def _angular_velocity(quaternion: Array, step: float) -> Array:
    """Angular velocity (N, 3), rad/s, world frame, by central differences of quaternions (N, 4), (x, y, z, w)."""
    before = np.vstack([quaternion[:1], quaternion[:-1]])
    after = np.vstack([quaternion[1:], quaternion[-1:]])
    turn = rotation_vector_from_quaternion(multiply(after, conjugate(before)))
    spans = np.full((len(quaternion), 1), 2.0 * step)
    spans[[0, -1]] = step
    velocity: Array = turn / spans
    return velocity


def _rotation_between(start: Array, end: Array) -> Array:
    """Rotation vector (3,), rad, world frame, that turns one quaternion (x, y, z, w) into another; in plain floats."""
    ax, ay, az, aw = end.tolist()
    bx, by, bz, bw = start.tolist()
    x = -aw * bx + ax * bw - ay * bz + az * by
    y = -aw * by + ax * bz + ay * bw - az * bx
    z = -aw * bz - ax * by + ay * bx + az * bw
    w = aw * bw + ax * bx + ay * by + az * bz
    sine = math.sqrt(x * x + y * y + z * z)
    angle = 2.0 * math.atan2(sine, abs(w))
    ratio = math.copysign(angle / sine if sine > _LOST else 2.0, w)
    return np.array([ratio * x, ratio * y, ratio * z])


def _bounded(vector: Array, limit: float) -> Array:
    """The vector, shortened to a length."""
    length = math.sqrt(float(vector @ vector))
    return vector if length <= limit else vector * (limit / length)
