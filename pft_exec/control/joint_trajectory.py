r"""The joint trajectory: the image of a tube in joint space, from a given posture on.

Inverse kinematics follows the tube on a grid of 10 ms, seeded where the arm is, so that the elbow stays in its branch.
What it finds is smoothed (demonstrations tremble, and so does their mean) and becomes a cubic B-spline: twice
continuously differentiable, local, and with derivatives bounded by the differences of its control points, which is how
the limits are kept. Tool and joint reference are one: the tool's is the forward kinematics of the joints'.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.interpolate import PchipInterpolator
from scipy.linalg import solveh_banded

from pft_exec.control.reference import JointReference
from pft_exec.control.time_law import TimeLaw
from pft_exec.exceptions import ControlError
from pft_exec.geometry import Array, geodesic_distance, normalize_quaternion, read_only
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.model import Arm, JointLimits, follow_path

GRID = 0.01
"""s between control points."""
BANDWIDTH = 5.0
"""Hz; voluntary motion of a hand lies below, its tremor (8 to 12 Hz) above."""
STOPPING_ACCELERATION = 0.5
"""m/s^2 (rotation on a 1/8 m lever) at which a motion that was still under way at its end comes to rest."""
SHORTEST_STOP = 0.1
"""s; the clock always comes to rest over at least this time."""
LIMIT_SHARE = 0.9
"""Share of velocity and acceleration limits that a reference may ask for; the rest is for the feedback."""
_PIN = 1e6  # weight of the first and last sample in the smoothing: they keep their place
_LEVER = 0.125  # m


@dataclass(frozen=True, eq=False)
class JointTrajectory:
    """A timed path of n joints along a tube; what the tracking controller follows.

    Parameters
    ----------
    points : (P, n), rad
        Control points of a uniform cubic B-spline, one before and one after the path.
    start : float, s
        Tube time of the second control point.
    time_law : TimeLaw
    tube_time, tube_phase : (N,), (N,)
        Time, s, and phase of the tube's steps.
    position_error, rotation_error : float, m, rad
        Largest distance between the tube's and the path's tool poses: what is out of the arm's reach.
    """

    points: Array
    start: float
    time_law: TimeLaw
    tube_time: Array
    tube_phase: Array
    position_error: float = 0.0
    rotation_error: float = 0.0

    @property
    def duration(self) -> float:
        """Clock time until rest, s."""
        return self.time_law.duration

    def at(self, time: float) -> JointReference:
        """Reference at a clock time, s, since the tube was taken up; at rest after its end."""
        theta, rate, change = self.time_law.at(time)
        q, slope, curvature = self._spline(theta)
        phase = float(np.interp(theta, self.tube_time, self.tube_phase))
        return JointReference(q, slope * rate, curvature * rate**2 + slope * change, phase)

    def state_at(self, time: float) -> tuple[Array, Array, Array]:
        """Configuration, velocity, acceleration (n,) at a clock time, s: the target that a transition meets."""
        reference = self.at(time)
        return reference.configuration, reference.velocity, reference.acceleration

    def _spline(self, theta: float) -> tuple[Array, Array, Array]:
        """Position, slope and curvature (n,) at a tube time: rad, rad/s, rad/s^2."""
        state = evaluate_spline(self.points, (theta - self.start) / GRID)
        return state[0], state[1] / GRID, state[2] / GRID**2


def plan_joint_trajectory(arm: Arm, tube: FlowTube, q: Array, phase: float = 0.0, pace: float = 1.0) -> JointTrajectory:
    """Joint trajectory along a tube from a phase on.

    Parameters
    ----------
    arm : Arm
    tube : FlowTube
        In the robot's base frame. Without orientation, the tool keeps the one it has at `q`.
    q : (n,), rad
        Posture that the elbow continues from.
    phase : float
        Where along the tube the trajectory begins, in [0, 1].
    pace : float
        Speed relative to the tube's own; lowered where a joint's velocity or acceleration limit asks for it.

    Raises
    ------
    ControlError
        If phase or pace is out of range.
    """
    if not (0.0 <= phase <= 1.0 and pace > 0.0):
        raise ControlError(f"phase must lie in [0, 1] and pace be positive; got {phase} and {pace}.")
    start = float(np.interp(phase, tube.phase, tube.time))
    count = max(3, int(np.ceil((tube.time[-1] - start) / GRID)) + 1)
    time = start + GRID * np.arange(count, dtype=float)
    position, quaternion = sample_tube(tube, time, arm.forward(q).quaternion)
    path = follow_path(arm, position, quaternion, q)
    points = spline_points(smooth(path.samples))
    rate = min(pace, limit_rate(points, arm.limits))
    return JointTrajectory(
        read_only(points),
        start,
        TimeLaw(start, float(tube.time[-1]), rate, stopping_time(position, quaternion)),
        tube.time,
        tube.phase,
        path.worst_position_error,
        path.worst_rotation_error,
    )


def sample_tube(tube: FlowTube, time: Array, orientation: Array) -> tuple[Array, Array]:
    """Mean tool poses, (M, 3) m and (M, 4) (x, y, z, w), at tube times (M,), s; the end is held beyond it.

    `orientation` (4,) is the tool's along tubes that have none.
    """
    distinct = np.concatenate([[True], np.diff(tube.time) > 1e-9])
    time = np.minimum(time, tube.time[-1])
    knots = tube.time[distinct]
    if len(knots) < 2:
        return np.tile(tube.position[-1], (len(time), 1)), np.tile(orientation, (len(time), 1))
    position = PchipInterpolator(knots, tube.position[distinct])(time)
    if tube.quaternion is None:
        return position, np.tile(orientation, (len(time), 1))
    return position, normalize_quaternion(PchipInterpolator(knots, tube.quaternion[distinct])(time))


def smooth(samples: Array, bandwidth: float = BANDWIDTH, step: float = GRID) -> Array:
    r"""Smooth samples (M, n) on an even grid, first and last kept.

    Notes
    -----
    Whittaker smoothing: the minimum of :math:`\sum |x_i - y_i|^2 + \lambda \sum |\Delta^3 x_i|^2`, whose gain at an
    angular frequency w per step is :math:`1 / (1 + \lambda w^6)`: one half at the bandwidth, Hz.
    """
    count = len(samples)
    if count < 8:
        return samples
    roughness = (2.0 * np.pi * bandwidth * step) ** -6
    bands = np.zeros((4, count))
    coefficients = np.array([-1.0, 3.0, -3.0, 1.0])
    for lag in range(4):
        for k in range(4 - lag):
            product = roughness * coefficients[k] * coefficients[k + lag]
            bands[3 - lag, k + lag : count - 3 + k + lag] += product
    weight = np.ones(count)
    weight[[0, -1]] = _PIN
    bands[3] += weight
    smoothed: Array = solveh_banded(bands, weight[:, None] * samples)
    return smoothed


def spline_points(samples: Array) -> Array:
    """Control points (M + 2, n) of the cubic B-spline near samples (M, n), exact at both ends.

    Notes
    -----
    Quasi-interpolation, ``c = y - (second difference) / 6``: exact for cubics, and local, unlike interpolation.
    """
    inner = samples.copy()
    inner[1:-1] -= np.diff(samples, 2, axis=0) / 6.0
    before, after = 2.0 * inner[:1] - inner[1:2], 2.0 * inner[-1:] - inner[-2:-1]
    return np.concatenate([before, inner, after])


def limit_rate(points: Array, limits: JointLimits) -> float:
    """Largest rate of the tube's clock at which a spline (P, n) keeps velocity and acceleration limits."""
    speed = np.max(np.abs(np.diff(points, axis=0)) / limits.velocity, initial=1e-9) / GRID
    acceleration = np.max(np.abs(np.diff(points, 2, axis=0)) / limits.acceleration, initial=1e-9) / GRID**2
    return float(min(LIMIT_SHARE / speed, np.sqrt(LIMIT_SHARE / acceleration)))


def stopping_time(position: Array, quaternion: Array) -> float:
    """Time, s, over which a motion that is still under way at its end, along poses (M, 3), (M, 4), comes to rest."""
    moved = np.linalg.norm(position[-1] - position[-3]) + _LEVER * geodesic_distance(quaternion[-3], quaternion[-1])
    return max(SHORTEST_STOP, float(moved) / (2.0 * GRID) / STOPPING_ACCELERATION)


@njit(cache=True)
def evaluate_spline(points: Array, place: float) -> Array:
    """Value and first two derivatives (3, n) of a uniform cubic B-spline (P, n), `place` in [0, P - 3] intervals."""
    index = min(max(int(place), 0), len(points) - 4)
    u = place - index
    w = 1.0 - u
    state = np.empty((3, points.shape[1]))
    for j in range(points.shape[1]):
        a, b, c, d = points[index, j], points[index + 1, j], points[index + 2, j], points[index + 3, j]
        middle = b * (4.0 - 6.0 * u**2 + 3.0 * u**3) + c * (4.0 - 6.0 * w**2 + 3.0 * w**3)
        state[0, j] = (a * w**3 + middle + d * u**3) / 6.0
        state[1, j] = 0.5 * ((d - b) * u**2 + (c - a) * w**2) + 2.0 * u * w * (c - b)
        state[2, j] = w * (a - 2.0 * b + c) + u * (b - 2.0 * c + d)
    return state
