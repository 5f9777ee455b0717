r"""The rolling trajectory: the image of a tube in joint space, computed a few samples per control period.

A path of three seconds takes ten milliseconds of inverse kinematics, ten control periods. So it is begun while a person
still leads, and goes on while the arm already follows it: the next second is always there. The tube's mean is smoothed
first, once per tube (`smooth_tube`); the joints of a sample then depend on the samples before it alone, and a cubic
B-spline, which is local, passes near them. What was computed never changes, so the reference is twice continuously
differentiable wherever the window was extended.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from pft_exec.control.joint_trajectory import (
    GRID,
    LIMIT_SHARE,
    evaluate_spline,
    sample_tube,
    smooth,
    stopping_time,
)
from pft_exec.control.reference import JointReference
from pft_exec.control.time_law import TimeLaw
from pft_exec.exceptions import ControlError
from pft_exec.geometry import Array, normalize_quaternion, read_only, rotation_matrix
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.model import Arm
from pft_exec.model.descent import descend

_FIRST_ITERATIONS, _ITERATIONS = 60, 20
_LEAST_SAMPLES = 3


@dataclass(frozen=True, eq=False)
class SmoothTube:
    """A tube's mean tool poses on an even grid that ends where the tube ends.

    Parameters
    ----------
    start : float, s
        Tube time of the first sample.
    position : (M, 3), m; rotation : (M, 3, 3)
        In the robot's base frame.
    stopping : float, s
        Over which the motion comes to rest at its end.
    time, phase : (N,), s and 1
        Of the tube's own steps.
    """

    start: float
    position: Array
    rotation: Array
    stopping: float
    time: Array
    phase: Array

    @property
    def end(self) -> float:
        """Tube time of the last sample, s."""
        return float(self.time[-1])


def smooth_tube(tube: FlowTube, orientation: Array) -> SmoothTube:
    """Smooth a tube's mean, once per tube.

    Parameters
    ----------
    tube : FlowTube
        In the robot's base frame.
    orientation : (4,), (x, y, z, w)
        Of the tool, along tubes that have none.
    """
    span = float(tube.time[-1] - tube.time[0])
    count = max(_LEAST_SAMPLES, int(np.ceil(span / GRID - 1e-9)) + 1)
    time = float(tube.time[-1]) - GRID * np.arange(count - 1, -1, -1, dtype=float)
    position, quaternion = sample_tube(tube, np.maximum(time, tube.time[0]), orientation)
    smoothed = normalize_quaternion(smooth(quaternion))
    return SmoothTube(
        float(time[0]),
        read_only(smooth(position)),
        read_only(rotation_matrix(smoothed)),
        stopping_time(position, quaternion),
        read_only(tube.time),
        read_only(tube.phase),
    )


class RollingTrajectory:
    """A joint path along a tube that is extended sample by sample.

    Parameters
    ----------
    arm : Arm
    tube : SmoothTube
    q : (n,), rad
        Posture that the elbow continues from.
    begin : float, s
        Tube time from which the path is wanted.

    Raises
    ------
    ControlError
        If `begin` is not finite.
    """

    def __init__(self, arm: Arm, tube: SmoothTube, q: Array, begin: float = 0.0) -> None:
        if not np.isfinite(begin):
            raise ControlError(f"a path begins at a finite tube time; got {begin} s.")
        self.arm, self.tube = arm, tube
        self._first = int(np.clip((begin - tube.start) / GRID, 0, len(tube.position) - _LEAST_SAMPLES))
        count = len(tube.position) - self._first
        self._samples = np.empty((count, len(q)))
        self._points = np.empty((count + 2, len(q)))
        self._posture = np.clip(np.asarray(q, dtype=float), arm.limits.lower, arm.limits.upper)
        self._done = self._judged = 0
        self._fastest = self._hardest = 1e-9
        self.position_error = 0.0
        """Largest distance, m, of the path's tool from the tube's so far: what is out of the arm's reach."""
        self.rotation_error = 0.0
        """The same of orientation, rad."""

    @property
    def begin(self) -> float:
        """Tube time of the first sample, s."""
        return self.tube.start + GRID * self._first

    @property
    def is_complete(self) -> bool:
        """Whether the path is known to the tube's end."""
        return self._done == len(self._samples)

    @property
    def known_until(self) -> float:
        """Tube time up to which the path is known, s."""
        return self.tube.end if self.is_complete else self.begin + GRID * max(0, self._done - _LEAST_SAMPLES)

    @property
    def highest_rate(self) -> float:
        """Largest rate of the tube's clock at which what is known keeps velocity and acceleration limits."""
        return float(min(LIMIT_SHARE / self._fastest, np.sqrt(LIMIT_SHARE / self._hardest)))

    def extend(self, count: int) -> None:
        """Compute so many further samples, or fewer where the tube ends."""
        if self.is_complete:
            return
        for index in range(self._done, min(self._done + count, len(self._samples))):
            before = self._samples[index - 1] if index else self._posture
            goal = self.tube.position[self._first + index], self.tube.rotation[self._first + index]
            found = descend(self.arm, goal, before, self._posture, _ITERATIONS if index else _FIRST_ITERATIONS)
            self._samples[index] = found.configuration
            self.position_error = max(self.position_error, float(np.linalg.norm(found.error[:3])))
            self.rotation_error = max(self.rotation_error, float(np.linalg.norm(found.error[3:])))
            self._done = index + 1
        self._add_points()

    def extend_until(self, time: float) -> None:
        """Compute up to a tube time, s, or the tube's end."""
        while not self.is_complete and self.known_until <= time:
            self.extend(_LEAST_SAMPLES + int(np.ceil((min(time, self.tube.end) - self.known_until) / GRID)))

    def reference(self, theta: float, rate: float, change: float) -> JointReference:
        """Reference at a tube time, s, whose clock runs at a rate with a change, 1/s; computed now if it was not."""
        self.extend_until(theta)
        q, velocity, acceleration = _state_at(self._points, theta - self.begin, rate, change)
        return JointReference(q, velocity, acceleration, _phase_at(theta, self.tube.time, self.tube.phase))

    def _add_points(self) -> None:
        """Control points near the samples that have both neighbors, and beyond the last one at the end."""
        done, samples, points = self._done, self._samples, self._points
        for k in range(max(self._judged, 1), done - 1):
            points[k + 1] = samples[k] - (samples[k + 1] - 2.0 * samples[k] + samples[k - 1]) / 6.0
        if self._judged < 2 <= done - 1:
            points[1] = samples[0]
            points[0] = 2.0 * points[1] - points[2]
        if self.is_complete:
            points[-2] = samples[-1]
            points[-1] = 2.0 * points[-2] - points[-3]
        self._judge(max(self._judged - 1, 0), len(points) if self.is_complete else done)
        self._judged = max(done - 1, 0)

    def _judge(self, first: int, last: int) -> None:
        """Speed and acceleration, beside their limits, that the control points from first to last ask for."""
        points, limits = self._points[first:last], self.arm.limits
        speed = np.abs(np.diff(points, axis=0)) / (limits.velocity * GRID)
        acceleration = np.abs(np.diff(points, 2, axis=0)) / (limits.acceleration * GRID**2)
        self._fastest = float(np.max(speed, initial=self._fastest))
        self._hardest = float(np.max(acceleration, initial=self._hardest))


@njit(cache=True)
def _state_at(points: Array, time: float, rate: float, change: float) -> tuple[Array, Array, Array]:
    """State at a time since the first sample, s, by a clock that runs at a rate with a change, 1/s."""
    state = evaluate_spline(points, time / GRID)
    slope, curvature = state[1] / GRID, state[2] / GRID**2
    return state[0], rate * slope, rate**2 * curvature + change * slope


@njit(cache=True)
def _phase_at(theta: float, time: Array, phase: Array) -> float:
    """Phase at a tube time, s, between those of the tube's steps (N,); held beyond either end."""
    later = np.searchsorted(time, theta)
    if later == 0:
        return float(phase[0])
    if later == len(time):
        return float(phase[-1])
    share = (theta - time[later - 1]) / (time[later] - time[later - 1])
    return float(phase[later - 1] + share * (phase[later] - phase[later - 1]))


class TakenUp:
    """A rolling trajectory on the clock of one take-over.

    Parameters
    ----------
    path : RollingTrajectory
    begin : float, s
        Tube time at clock zero; not before the path's own beginning.
    pace : float
        Speed relative to the tube's own; lowered where what is known of the path asks for it.
    starting : float, s
        Clock time in which it comes up to this speed; 0 where the motion is under way.
    onset : float
        Share of this speed, in [0, 1], from which it comes up.

    Raises
    ------
    ControlError
        If the pace is not positive.
    """

    def __init__(
        self, path: RollingTrajectory, begin: float, pace: float = 1.0, starting: float = 0.0, onset: float = 0.0
    ) -> None:
        if not pace > 0.0:
            raise ControlError(f"pace must be positive; got {pace}.")
        tube = path.tube
        rate = min(pace, path.highest_rate)
        self.path = path
        begin = float(np.clip(begin, path.begin, tube.end))
        self.time_law = TimeLaw(begin, tube.end, rate, tube.stopping, starting, onset)

    @property
    def duration(self) -> float:
        """Clock time until rest, s."""
        return self.time_law.duration

    @property
    def slower(self) -> float:
        """At most 1: the share of its rate that parts of the path that were computed later allow."""
        return min(1.0, self.path.highest_rate / self.time_law.rate)

    def at(self, time: float) -> JointReference:
        """Reference at a clock time, s, since the tube was taken up; at rest after its end."""
        return self.path.reference(*self.time_law.at(time))

    def foreseen(self, time: float) -> JointReference:
        """The same as far as the path is known, at rest there; nothing is computed for it."""
        known = self.path.known_until if self.path.is_complete else self.path.known_until - GRID
        theta = min(self.time_law.at(time)[0], max(known, self.path.begin))
        return self.path.reference(theta, 0.0, 0.0)
