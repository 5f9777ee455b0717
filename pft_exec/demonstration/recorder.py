"""The recorder: samples of one teaching as they come, on disk too if asked, until they make a demonstration.

A recording on disk is text, one JSON object a line: a header, then a sample a line, each handed to the operating
system before `Recorder.add` returns. A process that is killed loses at most the line it was writing;
`recover_recording` reads the rest.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.demonstration.demonstration import Demonstration
from pft_exec.exceptions import InvalidDemonstrationError, StorageError

FORMAT = "pft_exec recording"
RECORDING = ".recording"
"""Suffix of recordings in a folder."""
VERSION = 1

_SCHEDULE_TOLERANCE = 1e-6  # of a period: by how much a clock's rounding may make a sample early


class Recorder:
    """Collects the samples of one teaching at a fixed rate.

    Parameters
    ----------
    label : str
        The motion that is shown.
    period : float, s
        One sample is kept in each period, counted from the first; samples may come faster.
    path : str, Path or None
        Where to keep the recording in progress as well; an existing file is replaced.

    Raises
    ------
    InvalidDemonstrationError
        If the label is empty or the period is not positive.
    StorageError
        If nothing can be written at `path`.
    """

    def __init__(self, label: str, period: float = 0.01, path: str | Path | None = None) -> None:
        if not label:
            raise InvalidDemonstrationError("a demonstration needs a label, such as 'reach'; got an empty one.")
        if not (math.isfinite(period) and period > 0.0):
            raise InvalidDemonstrationError(f"the recording period must be positive, in s; got {period}.")
        self.label = label
        self.period = float(period)
        self._samples: list[dict[str, Any]] = []
        self._keyframes: list[float] = []
        self._slot = -1
        self._file = None if path is None else _opened(Path(path), label, period)

    def __len__(self) -> int:
        return len(self._samples)

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file of the recording, if there is one; the samples stay."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def add(
        self,
        time: float,
        position: ArrayLike,
        quaternion: ArrayLike | None = None,
        continuous: Mapping[str, float] | None = None,
        discrete: Mapping[str, int] | None = None,
        objects: Mapping[str, ArrayLike] | None = None,
        configuration: ArrayLike | None = None,
    ) -> bool:
        """Offer one sample; it is kept unless its period already has one.

        Parameters
        ----------
        time : float, s
            On any clock; the demonstration counts from the first sample.
        position : (3,), m, world frame
        quaternion : (4,), (x, y, z, w), or None
            Tool orientation, world frame.
        continuous, discrete : {name: value}
        objects : {name: (7,)}
            Position, m, and quaternion (x, y, z, w), world frame.
        configuration : (n,), rad or m, or None
            Joint state.

        Returns
        -------
        bool
            Whether the sample was kept.

        Raises
        ------
        InvalidDemonstrationError
            If time or position are not finite or time goes back, or if the sample has other channels than the first.
        """
        sample: dict[str, Any] = {
            "time": float(time),
            "position": _listed(position),
            "quaternion": _listed(quaternion),
            "continuous": {name: float(value) for name, value in (continuous or {}).items()},
            "discrete": {name: int(value) for name, value in (discrete or {}).items()},
            "objects": {name: _listed(pose) for name, pose in (objects or {}).items()},
            "configuration": _listed(configuration),
        }
        self._check(sample)
        first = self._samples[0]["time"] if self._samples else sample["time"]
        slot = math.floor((sample["time"] - first) / self.period + _SCHEDULE_TOLERANCE)
        if slot <= self._slot:
            return False
        self._slot = slot
        self._samples.append(sample)
        self._write(sample)
        return True

    def mark_keyframe(self, time: float) -> None:
        """Split the motion at `time`, s, on the clock of the samples ([Dong2012]_, section 4.1)."""
        self._keyframes.append(float(time))
        self._write({"keyframe": float(time)})

    def demonstration(self) -> Demonstration:
        """What was recorded so far; time counts from the first sample.

        Raises
        ------
        InvalidDemonstrationError
            If fewer than two samples came, or they make no demonstration.
        """
        return _demonstration(self.label, self._samples, self._keyframes)

    def _check(self, sample: Mapping[str, Any]) -> None:
        if not (math.isfinite(sample["time"]) and np.isfinite(sample["position"]).all()):
            raise InvalidDemonstrationError(
                f"recording of {self.label!r}: time and position must be finite; got {sample['time']} s and "
                f"{sample['position']} m at sample {len(self)}."
            )
        if not self._samples:
            return
        if sample["time"] < self._samples[-1]["time"]:
            raise InvalidDemonstrationError(
                f"recording of {self.label!r}: time must not go back; it goes from {self._samples[-1]['time']:.6g} s "
                f"to {sample['time']:.6g} s."
            )
        expected, got = _channels(self._samples[0]), _channels(sample)
        if expected != got:
            raise InvalidDemonstrationError(
                f"recording of {self.label!r}: each sample must have the channels of the first; "
                f"missing {sorted(expected - got)}, new {sorted(got - expected)}."
            )

    def _write(self, line: Mapping[str, Any]) -> None:
        if self._file is not None:
            _write_line(self._file, line)


def recover_recording(path: str | Path) -> Demonstration:
    """The demonstration that a recording on disk makes, as far as it was written.

    Raises
    ------
    StorageError
        If the file is missing, is no recording, or was written by a newer version.
    InvalidDemonstrationError
        If fewer than two samples were written.
    """
    path = Path(path)
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise StorageError(f"the recording {path} cannot be read ({error.strerror}).") from error
    header = _parsed(lines[0]) if lines else None
    if not header or header.get("format") != FORMAT:
        raise StorageError(f"{path} is no recording: its first line does not name the format {FORMAT!r}.")
    if header["version"] > VERSION:
        raise StorageError(
            f"{path} was written by a newer pft_exec: its schema has version {header['version']}, this one reads up to "
            f"{VERSION}. Update pft_exec."
        )
    entries = [entry for entry in map(_parsed, lines[1:]) if entry is not None]
    samples = [entry for entry in entries if "position" in entry]
    keyframes = [entry["keyframe"] for entry in entries if "keyframe" in entry]
    return _demonstration(header["label"], samples, [t for t in keyframes if samples and t < samples[-1]["time"]])


def recover_recordings(folder: str | Path) -> list[Demonstration]:
    """The demonstrations of all recordings in a folder, by name; those with fewer than two samples are left out.

    Raises
    ------
    StorageError
        If there is no such folder, or one of its files with the suffix of recordings is none.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise StorageError(f"there is no folder {folder} of recordings.")
    recovered = []
    for path in sorted(folder.glob(f"*{RECORDING}")):
        try:
            recovered.append(recover_recording(path))
        except InvalidDemonstrationError:
            continue  # killed before its second sample
    return recovered


def _demonstration(label: str, samples: list[dict[str, Any]], keyframes: list[float]) -> Demonstration:
    if len(samples) < 2:
        raise InvalidDemonstrationError(
            f"recording of {label!r}: at least 2 samples are needed; got {len(samples)}. Record longer."
        )
    first = samples[0]

    def column(name: str) -> Any:
        return None if first[name] is None else np.array([sample[name] for sample in samples])

    def signals(name: str) -> dict[str, Any]:
        return {key: np.array([sample[name][key] for sample in samples]) for key in first[name]}

    return Demonstration(
        label=label,
        time=column("time") - first["time"],
        position=column("position"),
        quaternion=column("quaternion"),
        continuous=signals("continuous"),
        discrete=signals("discrete"),
        objects=signals("objects"),
        configuration=column("configuration"),
        keyframes=tuple(instant - first["time"] for instant in keyframes),
    )


def _listed(values: ArrayLike | None) -> list[float] | None:
    return None if values is None else [float(value) for value in np.asarray(values, dtype=float).ravel()]


def _channels(sample: Mapping[str, Any]) -> set[str]:
    present = {name for name in ("quaternion", "configuration") if sample[name] is not None}
    named = {f"{kind} {name!r}" for kind in ("continuous", "discrete", "objects") for name in sample[kind]}
    return present | named


def _opened(path: Path, label: str, period: float) -> TextIO:
    try:
        file = path.open("w", encoding="utf-8")
    except OSError as error:
        raise StorageError(f"the recording cannot be written to {path} ({error.strerror}).") from error
    _write_line(file, {"format": FORMAT, "version": VERSION, "label": label, "period": period})
    return file


def _write_line(file: TextIO, line: Mapping[str, Any]) -> None:
    """One line, handed to the operating system at once. Python writes floats so that they read back bit for bit."""
    try:
        file.write(json.dumps(line) + "\n")
        file.flush()
    except OSError as error:
        raise StorageError(f"the recording {file.name} cannot be continued ({error.strerror}).") from error


def _parsed(line: str) -> dict[str, Any] | None:
    """The line's object; None where it was cut short."""
    try:
        entry = json.loads(line)
    except json.JSONDecodeError:
        return None
    return entry if isinstance(entry, dict) else None
