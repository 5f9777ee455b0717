"""A probabilistic flow tube: a Gaussian over tool poses at each step, in one scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pft_exec.exceptions import InvalidFlowTubeError
from pft_exec.geometry import (
    Array,
    Pose,
    interpolate_quaternion,
    is_nearly_unit,
    mend_quaternions,
    mirror_covariance,
    mirror_positions,
    mirror_quaternions,
    multiply,
    read_only,
    rotate,
)
from pft_exec.learning.events import TubeEvent, find_events

_ASYMMETRY = 1e-6  # of its largest entry: how far a covariance may be from symmetric before it counts as an error


def _is_covariance(matrices: Array) -> bool:
    """Whether all matrices (N, d, d) are symmetric and positive definite."""
    difference = np.abs(matrices - matrices.swapaxes(1, 2)).max(axis=(1, 2))
    if (difference > _ASYMMETRY * np.abs(matrices).max(axis=(1, 2))).any():
        return False
    try:
        np.linalg.cholesky(matrices)
    except np.linalg.LinAlgError:
        return False
    return True


@dataclass(frozen=True, eq=False)
class AlignedDemonstrations:
    """The demonstrations a tube came from, carried into its scene and aligned to its N steps.

    Parameters
    ----------
    position : (K, N, 3), m, world frame
    quaternion : (K, N, 4), (x, y, z, w), or None
    time : (K, N), s
        When demonstration k passed step n; non-decreasing along n, 0 where its motion begins.
    """

    position: Array
    quaternion: Array | None
    time: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", read_only(self.position))
        object.__setattr__(self, "time", read_only(self.time))
        if self.quaternion is not None:
            object.__setattr__(self, "quaternion", read_only(self.quaternion))


@dataclass(frozen=True, eq=False)
class TubeState:
    """One instant of a tube: what `FlowTube.at` returns. Units and frames are those of `FlowTube`."""

    time: float
    position: Array
    quaternion: Array | None
    covariance: Array
    time_deviation: float
    continuous: Mapping[str, float]
    continuous_deviation: Mapping[str, float]
    discrete: Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class FlowTube:
    """A Gaussian over tool poses at each of N steps, for one scene.

    Parameters
    ----------
    label : str
        The motion.
    time : (N,), s
        Mean time at which each step is passed; non-decreasing from 0.
    position : (N, 3), m, world frame
    quaternion : (N, 4), (x, y, z, w), or None
    covariance : (N, 3, 3) or (N, 6, 6), m^2, rad^2
        Of position (world axes), then of the rotation vector of ``mean^-1 * sample`` (tool frame); positive definite.
    time_deviation : (N,), s
        Standard deviation of `time`; zeros where None.
    continuous, continuous_deviation : {name: (N,)}
        Mean and standard deviation of each continuous signal; a deviation that is not given is 0.
    discrete : {name: (N, V)}
        Probability of each value of each discrete signal; the values are ``discrete_values[name]`` (V,), 0 to V - 1
        where they are not given.
    count : int
        Number of demonstrations the tube came from; 0 where it was made from plain arrays.
    aligned : AlignedDemonstrations or None
        Evidence the recognizer and the pictures use.

    Raises
    ------
    InvalidFlowTubeError
        If a shape is wrong, a number is not finite, time decreases, a quaternion is not unit within 1e-3, a deviation
        or probability is negative, or a covariance is not symmetric and positive definite.

    Notes
    -----
    [Dong2012]_, section 3: ``PFT = <T, Sigma, I, G>``; `precision` is I and `log_normalizer` is G of Algorithm 1.
    """

    label: str
    time: Array
    position: Array
    quaternion: Array | None = None
    covariance: Array = field(default_factory=lambda: np.empty(0))
    time_deviation: Array | None = None
    continuous: Mapping[str, Array] = field(default_factory=dict)
    continuous_deviation: Mapping[str, Array] = field(default_factory=dict)
    discrete: Mapping[str, Array] = field(default_factory=dict)
    discrete_values: Mapping[str, NDArray[np.int64]] = field(default_factory=dict)
    count: int = 0
    aligned: AlignedDemonstrations | None = None

    def __post_init__(self) -> None:
        count = np.asarray(self.time).size
        size = 3 if self.quaternion is None else 6
        time = self._array("time", self.time, (count,))
        if count < 2:
            raise self._error(f"at least 2 steps are needed; got {count}.")
        if (np.diff(time) < 0.0).any():
            raise self._error("time must not decrease from step to step.")
        deviation = np.zeros(count) if self.time_deviation is None else self.time_deviation
        covariance = self._array("covariance", self.covariance, (count, size, size))
        if not _is_covariance(covariance):
            raise self._error("each covariance must be symmetric and positive definite.")
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "position", self._array("position", self.position, (count, 3)))
        object.__setattr__(self, "covariance", covariance)
        object.__setattr__(self, "time_deviation", self._positive("time_deviation", deviation, (count,)))
        if self.quaternion is not None:
            quaternion = self._array("quaternion", self.quaternion, (count, 4))
            if not is_nearly_unit(quaternion).all():
                raise self._error("each quaternion (x, y, z, w) must have length 1 within 1e-3.")
            object.__setattr__(self, "quaternion", read_only(mend_quaternions(quaternion)))
        for name, values in self._signals(count).items():
            object.__setattr__(self, name, MappingProxyType(values))

    def _signals(self, count: int) -> dict[str, dict[str, Any]]:
        """The signals, checked and complete."""
        continuous = {n: self._array(f"continuous {n!r}", v, (count,)) for n, v in self.continuous.items()}
        given = {n: np.zeros(count) for n in continuous} | dict(self.continuous_deviation)
        columns = {name: np.shape(v)[-1] if np.ndim(v) == 2 else 1 for name, v in self.discrete.items()}
        values = {name: np.arange(size) for name, size in columns.items()} | dict(self.discrete_values)
        for name, size in columns.items():
            if np.shape(values[name]) != (size,):
                raise self._error(f"discrete_values {name!r} must have shape ({size},), one a column of probabilities.")
        return {
            "continuous": continuous,
            "continuous_deviation": {n: self._positive(f"deviation {n!r}", v, (count,)) for n, v in given.items()},
            "discrete": {
                n: self._positive(f"discrete {n!r}", v, (count, columns[n])) for n, v in self.discrete.items()
            },
            "discrete_values": {name: np.array(v, dtype=np.int64) for name, v in values.items()},
        }

    def __reduce__(self) -> tuple[Any, ...]:
        mappings = ("continuous", "continuous_deviation", "discrete", "discrete_values")
        names = tuple(self.__dataclass_fields__)
        return FlowTube, tuple(dict(getattr(self, n)) if n in mappings else getattr(self, n) for n in names)

    def _error(self, message: str) -> InvalidFlowTubeError:
        return InvalidFlowTubeError(f"flow tube of {self.label!r}: {message}")

    def _positive(self, name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
        array = self._array(name, values, shape)
        if (array < 0.0).any():
            raise self._error(f"{name} must not be negative; got {array.min():.4g}.")
        return array

    def _array(self, name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
        try:
            array = read_only(values)
        except (TypeError, ValueError) as error:
            raise self._error(f"{name} must be numbers of shape {shape}; got {type(values).__name__}.") from error
        if array.shape != shape:
            raise self._error(f"{name} must have shape {shape}; got {array.shape}.")
        if not np.isfinite(array).all():
            raise self._error(f"{name} must be finite.")
        return array

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def precision(self) -> Array:
        """Inverse covariance (N, d, d): I of [Dong2012]_, Algorithm 1."""
        inverse: Array = np.linalg.inv(self.covariance).astype(float)
        return inverse

    @cached_property
    def log_normalizer(self) -> Array:
        """(N,): ``-log((2 pi)^(d/2) |Sigma|^(1/2))``: G of [Dong2012]_, Algorithm 1."""
        size = self.covariance.shape[-1]
        normalizer: Array = -0.5 * (size * np.log(2.0 * np.pi) + np.linalg.slogdet(self.covariance)[1].astype(float))
        return normalizer

    @property
    def duration(self) -> float:
        """Mean duration, s."""
        return float(self.time[-1] - self.time[0])

    @cached_property
    def phase(self) -> Array:
        """(N,): phase of each step, evenly from 0 to 1."""
        return np.linspace(0.0, 1.0, len(self))

    @property
    def start(self) -> Pose:
        """Mean tool pose at the first step, world frame; identity orientation where the tube has none."""
        return self._pose(0)

    @property
    def end(self) -> Pose:
        """Mean tool pose at the last step, world frame; identity orientation where the tube has none."""
        return self._pose(-1)

    def _pose(self, index: int) -> Pose:
        return (
            Pose(self.position[index])
            if self.quaternion is None
            else Pose(self.position[index], self.quaternion[index])
        )

    def at(self, phase: float) -> TubeState:
        """The tube at a phase in [0, 1], linearly (orientation geodesically) interpolated between steps.

        Raises
        ------
        InvalidFlowTubeError
            If the phase lies outside [0, 1].
        """
        if not 0.0 <= phase <= 1.0:
            raise self._error(f"phase must lie in [0, 1]; got {phase}.")
        place = phase * (len(self) - 1)
        index = min(int(place), len(self) - 2)
        ratio = place - index

        def between(values: Array) -> Any:
            return (1.0 - ratio) * values[index] + ratio * values[index + 1]

        quaternion = self.quaternion
        deviation = self.time_deviation if self.time_deviation is not None else np.zeros(len(self))
        return TubeState(
            time=float(between(self.time)),
            position=between(self.position),
            quaternion=None
            if quaternion is None
            else interpolate_quaternion(quaternion[index], quaternion[index + 1], ratio),
            covariance=between(self.covariance),
            time_deviation=float(between(deviation)),
            continuous={name: float(between(values)) for name, values in self.continuous.items()},
            continuous_deviation={name: float(between(values)) for name, values in self.continuous_deviation.items()},
            discrete={name: between(values) for name, values in self.discrete.items()},
        )

    def events(self) -> list[TubeEvent]:
        """Changes of the most probable value of each discrete signal, in the order of their phases.

        The values at phase 0 are no events: `initial_values` holds them.
        """
        found = [
            event
            for name in sorted(self.discrete)
            for event in find_events(name, self.phase, self.discrete[name], self.discrete_values[name])
        ]
        return sorted(found, key=lambda event: event.phase)

    @cached_property
    def initial_values(self) -> Mapping[str, int]:
        """Most probable value of each discrete signal at phase 0."""
        return {name: int(self.discrete_values[name][np.argmax(p[0])]) for name, p in self.discrete.items()}

    def mirrored(self, plane: Pose | None = None) -> FlowTube:
        """The tube mirrored in the xz plane of `plane` (identity where None)."""
        aligned = self.aligned
        return replace(
            self,
            position=mirror_positions(self.position, plane),
            quaternion=None if self.quaternion is None else mirror_quaternions(self.quaternion, plane),
            covariance=mirror_covariance(self.covariance, plane),
            aligned=None
            if aligned is None
            else AlignedDemonstrations(
                mirror_positions(aligned.position, plane),
                None if aligned.quaternion is None else mirror_quaternions(aligned.quaternion, plane),
                aligned.time,
            ),
        )

    def transformed(self, transform: Pose) -> FlowTube:
        """The tube seen from another frame: `transform` is the pose of today's frame in the new one."""
        turn = np.eye(self.covariance.shape[-1])
        turn[:3, :3] = transform.rotation
        aligned = self.aligned
        return replace(
            self,
            position=transform.apply(self.position),
            quaternion=None if self.quaternion is None else multiply(transform.quaternion, self.quaternion),
            covariance=turn @ self.covariance @ turn.T,
            aligned=None
            if aligned is None
            else AlignedDemonstrations(
                rotate(transform.quaternion, aligned.position) + transform.position,
                None if aligned.quaternion is None else multiply(transform.quaternion, aligned.quaternion),
                aligned.time,
            ),
        )
