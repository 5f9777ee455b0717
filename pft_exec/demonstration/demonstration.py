"""A demonstration: one recorded teaching, as arrays over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pft_exec.demonstration.scene import Scene
from pft_exec.exceptions import InvalidDemonstrationError
from pft_exec.geometry import (
    UNIT_TOLERANCE,
    Array,
    Pose,
    is_nearly_unit,
    mend_quaternions,
    mirror_poses,
    mirror_positions,
    mirror_quaternions,
)


@dataclass(frozen=True, eq=False)
class Demonstration:
    """One recorded teaching: N samples of the tool and of what was around it.

    Parameters
    ----------
    label : str
        The motion that was shown.
    time : (N,), s
        Strictly increasing, N >= 2.
    position : (N, 3), m
        Tool, world frame; planar data have z = 0.
    quaternion : (N, 4), (x, y, z, w), or None
        Tool orientation, world frame. Within 1e-3 of unit length: normalized; sign flips are mended.
    continuous : {name: (N,)}
        Scalar signals, such as the width of the gripper, m.
    discrete : {name: (N,) int}
        Discrete signals, such as gripper closed (1) or open (0).
    objects : {name: (N, 7) or (7,)}
        Position, m, and quaternion (x, y, z, w) of each object, world frame; (7,) or a `Pose` where it stood still.
    configuration : (N, n), rad or m, or None
        Joint state; recorded, never a motion variable.
    keyframes : sequence of float, s
        Instants at which a compound motion is split; strictly inside the recording.

    Raises
    ------
    InvalidDemonstrationError
        If a shape is wrong, a number is not finite, time does not increase, or a quaternion is not unit.
    """

    label: str
    time: Array
    position: Array
    quaternion: Array | None = None
    continuous: Mapping[str, Array] = field(default_factory=dict)
    discrete: Mapping[str, NDArray[np.int64]] = field(default_factory=dict)
    objects: Mapping[str, Array] = field(default_factory=dict)
    configuration: Array | None = None
    keyframes: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        check = _Checker(str(self.label))
        time = check.times(self.time)
        count = len(time)
        fields: dict[str, Any] = {
            "time": time,
            "position": check.array("position", self.position, (count, 3)),
            "continuous": check.signals("continuous", self.continuous, count),
            "discrete": check.discrete(self.discrete, count),
            "objects": check.objects(self.objects, count),
            "keyframes": check.keyframes(self.keyframes, time),
        }
        if self.quaternion is not None:
            fields["quaternion"] = check.quaternions("quaternion", self.quaternion, (count, 4))
        if self.configuration is not None:
            columns = np.asarray(self.configuration).shape[-1] if np.ndim(self.configuration) == 2 else 0
            fields["configuration"] = check.array("configuration", self.configuration, (count, columns))
        for name, value in fields.items():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
            elif isinstance(value, dict):
                for item in value.values():
                    item.setflags(write=False)
                value = MappingProxyType(value)
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.time)

    def __reduce__(self) -> tuple[Any, ...]:
        return Demonstration, (
            self.label,
            self.time,
            self.position,
            self.quaternion,
            dict(self.continuous),
            dict(self.discrete),
            dict(self.objects),
            self.configuration,
            self.keyframes,
        )

    @property
    def duration(self) -> float:
        """Last time minus first, s."""
        return float(self.time[-1] - self.time[0])

    @cached_property
    def scene(self) -> Scene:
        """The objects as they stood at the first sample, world frame."""
        return Scene({name: Pose.from_array(np.atleast_2d(poses)[0]) for name, poses in self.objects.items()})

    @property
    def start(self) -> Pose:
        """Tool pose at the first sample, world frame; identity orientation where none was recorded."""
        return self._pose(0)

    @property
    def end(self) -> Pose:
        """Tool pose at the last sample, world frame; identity orientation where none was recorded."""
        return self._pose(-1)

    def _pose(self, index: int) -> Pose:
        if self.quaternion is None:
            return Pose(self.position[index])
        return Pose(self.position[index], self.quaternion[index])

    def segment(self, start: int, stop: int) -> Demonstration:
        """Samples `start` to `stop` (exclusive) as a demonstration of their own; keyframes inside are kept."""
        part = slice(start, stop)
        inside = (self.time[start], self.time[stop - 1])
        return replace(
            self,
            time=self.time[part],
            position=self.position[part],
            quaternion=None if self.quaternion is None else self.quaternion[part],
            continuous={name: values[part] for name, values in self.continuous.items()},
            discrete={name: values[part] for name, values in self.discrete.items()},
            objects={name: poses if poses.ndim == 1 else poses[part] for name, poses in self.objects.items()},
            configuration=None if self.configuration is None else self.configuration[part],
            keyframes=tuple(t for t in self.keyframes if inside[0] < t < inside[1]),
        )

    def mirrored(self, plane: Pose | None = None) -> Demonstration:
        """Tool and objects mirrored in the xz plane of `plane` (identity where None).

        The joint state has no mirror image that this module could know: it is left out.
        """
        quaternion = self.quaternion
        return replace(
            self,
            position=mirror_positions(self.position, plane),
            quaternion=None if quaternion is None else mirror_quaternions(quaternion, plane),
            objects={name: mirror_poses(poses, plane) for name, poses in self.objects.items()},
            configuration=None,
        )


class _Checker:
    """Checks the arrays of one demonstration; each message names the label, the field, the sample and the remedy."""

    def __init__(self, label: str) -> None:
        if not label:
            raise InvalidDemonstrationError("a demonstration needs a label, such as 'reach'; got an empty one.")
        self.label = label

    def fail(self, message: str) -> InvalidDemonstrationError:
        return InvalidDemonstrationError(f"demonstration of {self.label!r}: {message}")

    def array(self, name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
        try:
            array = np.array(values, dtype=float)
        except (TypeError, ValueError) as error:
            raise self.fail(f"{name} must be numbers of shape {shape}; got {type(values).__name__}.") from error
        if array.shape != shape:
            raise self.fail(f"{name} must have shape {shape}, one row per sample; got {array.shape}.")
        bad = ~np.isfinite(array)
        if bad.any():
            first = int(np.argwhere(bad)[0][0])
            raise self.fail(
                f"{name} must be finite; sample {first} is {array[first]} ({int(bad.sum())} such values). "
                f"Remove or interpolate those samples."
            )
        return array

    def times(self, values: ArrayLike) -> Array:
        count = np.asarray(values).size
        time = self.array("time", values, (count,))
        if count < 2:
            raise self.fail(f"at least 2 samples are needed; got {count}.")
        steps = np.diff(time)
        if (steps <= 0.0).any():
            first = int(np.argmax(steps <= 0.0))
            raise self.fail(
                f"time must increase from sample to sample, in s; it goes from {time[first]:.6g} s to "
                f"{time[first + 1]:.6g} s at sample {first + 1}. Sort the samples or drop the repeated ones."
            )
        return time

    def quaternions(self, name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
        quaternions = self.array(name, values, shape)
        unit = is_nearly_unit(quaternions)
        if not unit.all():
            first = int(np.argmin(unit))
            raise self.fail(
                f"{name} (x, y, z, w) must have length 1 within {UNIT_TOLERANCE}; sample {first} has "
                f"{np.linalg.norm(quaternions[first]):.4g}. Normalize it, and check that it is a quaternion."
            )
        return mend_quaternions(quaternions)

    def by_name(self, name: str, values: Any) -> Mapping[str, Any]:
        if not isinstance(values, Mapping):
            raise self.fail(f"{name} must be a mapping of names to arrays; got {type(values).__name__}.")
        return values

    def signals(self, name: str, given: Any, count: int) -> dict[str, Array]:
        signals = self.by_name(name, given)
        return {key: self.array(f"{name} {key!r}", values, (count,)) for key, values in signals.items()}

    def discrete(self, signals: Any, count: int) -> dict[str, NDArray[np.int64]]:
        checked = {}
        for key, values in self.signals("discrete", signals, count).items():
            if (values != np.round(values)).any():
                raise self.fail(f"discrete {key!r} must be whole numbers; it is a continuous signal.")
            checked[key] = values.astype(np.int64)
        return checked

    def objects(self, objects: Any, count: int) -> dict[str, Array]:
        checked = {}
        for name, values in self.by_name("objects", objects).items():
            given = values.array if isinstance(values, Pose) else values
            still = np.ndim(given) == 1
            poses = self.array(f"object {name!r}", given, (7,) if still else (count, 7))
            rows = np.atleast_2d(poses)
            rows[:, 3:] = self.quaternions(f"quaternion of object {name!r}", rows[:, 3:], (len(rows), 4))
            checked[name] = rows[0] if still else rows
        return checked

    def keyframes(self, keyframes: ArrayLike, time: Array) -> tuple[float, ...]:
        instants = tuple(sorted(self.array("keyframes", np.atleast_1d(keyframes), (np.size(keyframes),)).tolist()))
        for instant in instants:
            if not time[0] < instant < time[-1]:
                raise self.fail(
                    f"a keyframe must lie inside the recording, {time[0]:.4g} to {time[-1]:.4g} s; got {instant:.4g} s."
                )
        return instants
