"""What the demonstrations behind a tube say: residuals of position, direction and orientation at each step.

In the flow: `FlowTube.aligned` is read through the motion's clock; `emission` makes densities of it, `timing` the
probabilities of the next step. A tube made from plain arrays stands for a few demonstrations spread as its covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pft_exec.geometry import Array, conjugate, multiply
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.recognition.motion_clock import ClockScales, read_clock, read_path
from pft_exec.recognition.roughness import measure_noise
from pft_exec.recognition.settings import PhaseSettings

PLAIN_COUNT = 5  # demonstrations that a tube from plain arrays stands for, where it does not say
FEW = 5  # demonstrations from which a tube's own covariance counts half
PLAIN_DIRECTION = 0.2  # rad, standard deviation of its direction of motion
_TINY_EXTENT = 1e-9  # m
_TINY_DURATION = 1e-9  # s
_LONGEST_WINDOW = 0.1  # of a motion, for its direction, however noisy: beyond it there are no turns left
_LEAST_ROTATION = 0.2  # rad: motions that turn less have no rotation extent of their own


@dataclass(frozen=True, eq=False)
class TubeEvidence:
    """One tube's evidence; K demonstrations, N steps.

    Parameters
    ----------
    count : int
        K, or what stands for it.
    clock : (N,), s
        Mean time on the motion's clock at each step.
    clocks : (K, N), s
        That of each demonstration; (0, N) where there is none.
    position, direction, rotation : (K, N, 3)
        Residuals from the mean: m, weighted heading, and twice the vector part of ``mean^-1 * sample``;
        zero demonstrations where there is none, and a scatter of its own.
    mean_direction : (N, 3)
    lengths : (K, N)
        Of the direction now, which falls where the hand slows down; (1, N) where there is no demonstration.
    scatter : (3, N, 3, 3)
        Sums of outer products of the three.
    promised : (3, N, 3, 3)
        Covariances that the tube itself states, for a scene nobody demonstrated, less what timing adds along the path
        (the filter has a timing of its own); zeros for the direction.
    follow : (N,)
        How much of a residual at the start is left at each step; zeros until `follow_starts`.
    """

    count: int
    clock: Array
    clocks: Array
    position: Array
    direction: Array
    rotation: Array
    mean_direction: Array
    lengths: Array
    scatter: Array
    promised: Array
    follow: Array

    @property
    def conditioned(self) -> Array:
        """(K, N, 3), m: what is left of `position` once the residual at the start is known."""
        return self.position - self.follow[:, None] * self.position[:, :1]

    @property
    def cross(self) -> Array:
        """(N, 3, 3): sums of products of the residuals of direction (rows) and `conditioned` position (columns)."""
        products: Array = np.einsum("kni,knj->nij", self.direction, self.conditioned)
        return products


def measure_scales(tubes: Sequence[FlowTube], signals: Sequence[str]) -> ClockScales:
    """Medians over the library that movement is measured by."""
    extents = [float(np.linalg.norm(np.ptp(tube.position, axis=0))) for tube in tubes]
    extent = max(float(np.median(extents)), _TINY_EXTENT)
    turns = [0.0 if t.quaternion is None else 2.0 * float(np.linalg.norm(np.ptp(t.quaternion, axis=0))) for t in tubes]
    rotation = max(float(np.median(turns)), _LEAST_ROTATION)
    ranges = {}
    for name in signals:
        values = np.concatenate([tube.continuous[name] for tube in tubes])
        spread = max(float(np.ptp(values)), max(float(t.continuous_deviation[name].max()) for t in tubes))
        if spread > 0.0:
            ranges[name] = spread
    duration = max(float(np.median([tube.duration for tube in tubes])), 1e-6)
    return ClockScales(extent, rotation, ranges, duration, measure_noise(tubes) / extent)


def clock_constants(scales: ClockScales, settings: PhaseSettings) -> Array:
    """Leash, patience (s), pace while standing, window (s) and softness (m) of the motion's clock."""
    return np.array(
        [
            settings.leash,
            settings.patience * scales.duration,
            settings.standing_clock,
            window_share(scales, settings) * scales.duration,
            settings.direction_softness * scales.extent,
        ]
    )


def window_share(scales: ClockScales, settings: PhaseSettings) -> float:
    """The direction's window, as a share of the median duration: long enough for the noise of the demonstrations."""
    noisy = settings.noise_window * float(np.sqrt(scales.noise))
    return min(max(settings.window, noisy), _LONGEST_WINDOW)


def gather_evidence(tube: FlowTube, scales: ClockScales, settings: PhaseSettings) -> TubeEvidence:
    """Read one tube through the motion's clock."""
    constants = clock_constants(scales, settings)
    weight = settings.direction_weight * scales.extent
    if tube.aligned is None:
        return _plain(tube, scales, constants, weight)
    aligned, signals = tube.aligned, dict(tube.continuous)
    count, steps = aligned.time.shape
    clocks, lengths, directions = np.empty((count, steps)), np.empty((count, steps)), np.empty((count, steps, 3))
    paths = []
    for k in range(count):
        turn = None if aligned.quaternion is None else aligned.quaternion[k]
        paths.append((aligned.time[k], aligned.position[k], scales.points(aligned.position[k], turn, signals)))
        clocks[k] = read_clock(*paths[k], constants)
    tempos = clocks[:, -1].mean() / np.maximum(clocks[:, -1], _TINY_DURATION)
    for k, (path, tempo) in enumerate(zip(paths, tempos, strict=True)):
        lengths[k], directions[k] = read_path(*path, constants, float(tempo))
    directions *= weight
    rotation = np.zeros((count, steps, 3))
    if aligned.quaternion is not None and tube.quaternion is not None:
        difference = multiply(conjugate(tube.quaternion), aligned.quaternion)
        rotation = 2.0 * difference[..., :3] * np.where(difference[..., 3:] < 0.0, -1.0, 1.0)
        rotation = rotation - rotation.mean(axis=0)
    position = aligned.position - aligned.position.mean(axis=0)
    mean_direction = directions.mean(axis=0)
    direction = directions - mean_direction
    scatter = np.stack([np.einsum("kni,knj->nij", r, r) for r in (position, direction, rotation)])
    promised = _promised(tube, count)
    return TubeEvidence(
        count, clocks.mean(axis=0), clocks, position, direction, rotation, mean_direction, lengths, scatter, promised,
        np.zeros(steps),
    )  # fmt: skip


def _plain(tube: FlowTube, scales: ClockScales, constants: Array, weight: float) -> TubeEvidence:
    path = tube.time, tube.position, scales.points(tube.position, tube.quaternion, dict(tube.continuous))
    clock, (length, direction) = read_clock(*path, constants), read_path(*path, constants)
    count, steps = tube.count or PLAIN_COUNT, len(tube)
    scatter = np.zeros((3, steps, 3, 3))
    scatter[0] = tube.covariance[:, :3, :3]
    scatter[1] = np.eye(3) * (PLAIN_DIRECTION * weight) ** 2
    if tube.quaternion is not None:
        scatter[2] = tube.covariance[:, 3:, 3:]
    none = np.zeros((0, steps, 3))
    return TubeEvidence(
        count, clock, np.zeros((0, steps)), none, none, none, direction * weight, length[None],
        scatter * max(count - 1, 1), scatter, np.zeros(steps),
    )  # fmt: skip


def _promised(tube: FlowTube, count: int) -> Array:
    steps = len(tube)
    promised = np.zeros((3, steps, 3, 3))
    velocity = np.gradient(tube.position, axis=0) / (np.gradient(tube.time)[:, None] + _TINY_EXTENT)
    deviation = np.zeros(steps) if tube.time_deviation is None else tube.time_deviation
    drift = velocity * deviation[:, None] * np.sqrt(min(1.0, FEW / count))
    promised[0] = tube.covariance[:, :3, :3] - drift[:, :, None] * drift[:, None, :]
    if tube.quaternion is not None:
        promised[2] = tube.covariance[:, 3:, 3:]
    return promised
