"""Interchange: recordings that others made, in NumPy and text files, as demonstrations."""

from __future__ import annotations

import csv
import warnings
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pft_exec.demonstration.demonstration import Demonstration
from pft_exec.exceptions import InvalidDemonstrationError, StorageError
from pft_exec.geometry import Array, normalize_quaternion, quaternion_from_matrix

_POSITION = ("x", "y", "z")
_QUATERNION = ("qx", "qy", "qz", "qw")
_NUMBERS = "biuf"  # kinds of arrays that hold real numbers


def convert_recordings(path: str | Path, scale: float = 1.0) -> list[Demonstration]:
    """Read recordings from a ``.npz`` or ``.csv`` file.

    Parameters
    ----------
    path : str or Path
        ``.npz``: ``label[i]`` names the motion of recording i; ``pos_000i`` (N, 2 or 3), ``t_000i`` (N,),
        optionally ``quat_000i`` (N, 4) (x, y, z, w), ``frame<j>_A_000i`` (d, d) and ``frame<j>_b_000i`` (d,):
        rotation and origin of a frame, which becomes the object "frame<j>".
        ``.csv``: a header with ``time``, ``x``, ``y`` and optionally ``z``, ``qx qy qz qw``, ``label``, and
        ``demonstration`` (rows with the same value make one; without it, the file is one). Further columns
        become continuous signals; an empty cell counts as not finite.
    scale : float
        What one unit of the file's positions is in m.

    Returns
    -------
    list of Demonstration
        Planar recordings have z = 0. Time counts from the first sample. Samples that are not finite or not later than
        those before are left out with a `RuntimeWarning`.

    Raises
    ------
    StorageError
        If the file is missing, of another kind, or holds no recordings in one of these layouts.
    InvalidDemonstrationError
        If a recording's arrays make no demonstration.
    """
    path = Path(path)
    readers = {".npz": _from_npz, ".csv": _from_csv}
    if path.suffix.lower() not in readers:
        raise StorageError(
            f"{path}: recordings are converted from .npz or .csv files; got {path.suffix or 'no suffix'!r}."
        )
    if not path.is_file():
        raise StorageError(f"there is no file {path}." if not path.exists() else f"{path} is a folder, not a file.")
    return readers[path.suffix.lower()](path, float(scale))


def _from_npz(path: Path, scale: float) -> list[Demonstration]:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise StorageError(f"{path} is truncated or no NumPy archive of plain arrays ({error}).") from error
    if "label" not in arrays:
        raise StorageError(f"{path} holds no recordings: the array 'label' is missing; it has {sorted(arrays)[:5]}.")
    if arrays["label"].size == 0:
        raise StorageError(f"{path} holds no recordings: the array 'label' is empty.")
    return [_npz_demonstration(path, arrays, index, scale) for index in range(arrays["label"].size)]


def _npz_demonstration(path: Path, arrays: Mapping[str, Any], index: int, scale: float) -> Demonstration:
    def named(kind: str) -> Any:
        key = f"{kind}_{index:04d}"
        if key not in arrays:
            raise StorageError(f"{path}: recording {index} lacks the array {key!r}.")

        if arrays[key].dtype.kind not in _NUMBERS:
            raise StorageError(f"{path}: the array {key!r} must hold real numbers; it holds {arrays[key].dtype}.")
        return arrays[key]

    time = np.asarray(named("t"), dtype=float)
    quaternion = named("quat") if f"quat_{index:04d}" in arrays else None
    parts = (f"_A_{index:04d}", f"_b_{index:04d}")
    frames = sorted({key.split("_")[0] for key in arrays if key.startswith("frame") and key.endswith(parts)})
    return _demonstration(
        f"recording {index} of {path.name}",
        time,
        scale * _spatial(named("pos")),
        quaternion,
        label=_text(arrays["label"].ravel()[index]),
        objects={
            frame: np.concatenate([scale * _spatial(named(f"{frame}_b")), _frame_quaternion(named(f"{frame}_A"))])
            for frame in frames
        },
    )


def _text(label: Any) -> str:
    return label.decode("utf-8", "replace") if isinstance(label, bytes) else str(label)


def _demonstration(
    name: str,
    time: Array,
    position: Array,
    quaternion: Array | None,
    label: str,
    continuous: Mapping[str, Array] | None = None,
    objects: Mapping[str, Array] | None = None,
) -> Demonstration:
    """A demonstration of the samples that can be used; a warning says how many cannot."""
    columns = {"time": time, "position": position, "quaternion": quaternion, **(continuous or {})}
    rows = {key: np.asarray(values, dtype=float) for key, values in columns.items() if values is not None}
    if len({len(values) for values in rows.values()}) == 1:
        used = _usable(rows)
        if not used.all():
            warnings.warn(
                f"{name} ({label}): {np.sum(~used)} of {len(used)} samples are left out; they are not finite, or no "
                f"later than the sample before.",
                RuntimeWarning,
                stacklevel=4,
            )
            rows = {key: values[used] for key, values in rows.items()}
    return Demonstration(
        label=label,
        time=rows["time"] - rows["time"][:1],
        position=rows["position"],
        quaternion=None if quaternion is None else _unit(rows["quaternion"]),
        continuous={key: rows[key] for key in continuous or {}},
        objects=dict(objects or {}),
    )


def _usable(rows: Mapping[str, Array]) -> NDArray[np.bool_]:
    """(N,): which samples are finite in all columns, and later than all usable ones before."""
    finite = np.all([np.isfinite(values).reshape(len(values), -1).all(axis=1) for values in rows.values()], axis=0)
    clock = np.where(finite, rows["time"], -np.inf)
    latest = np.concatenate([[-np.inf], np.maximum.accumulate(clock)[:-1]])
    usable: NDArray[np.bool_] = finite & (clock > latest)
    return usable


def _spatial(values: ArrayLike) -> Array:
    """Positions (..., 2 or 3) as (..., 3), z = 0 where there is none."""
    array = np.asarray(values, dtype=float)
    if array.ndim == 0 or array.shape[-1] not in (2, 3):
        raise InvalidDemonstrationError(f"positions must have 2 or 3 columns; got shape {array.shape}.")
    return np.concatenate([array, np.zeros((*array.shape[:-1], 3 - array.shape[-1]))], axis=-1)


def _unit(quaternion: ArrayLike) -> Array:
    """Quaternions of foreign files, interpolated or rounded there, brought back to unit length within 5 %."""
    array = np.asarray(quaternion, dtype=float)
    norms = np.linalg.norm(array, axis=-1)
    return normalize_quaternion(array) if (np.abs(norms - 1.0) < 0.05).all() else array


def _frame_quaternion(matrix: NDArray[Any]) -> Array:
    """Quaternion (x, y, z, w) of a rotation (2, 2) about z, or (3, 3)."""
    if matrix.shape not in ((2, 2), (3, 3)) or not np.linalg.det(matrix) > 0.0:
        raise InvalidDemonstrationError(f"a frame's rotation is a matrix (2, 2) or (3, 3); got {matrix.tolist()}.")
    full = np.eye(3)
    full[: len(matrix), : len(matrix)] = matrix
    return quaternion_from_matrix(full)


def _from_csv(path: Path, scale: float) -> list[Demonstration]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file, skipinitialspace=True)
            names = reader.fieldnames = [name.strip() for name in reader.fieldnames or ()]
            rows = list(reader)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise StorageError(f"{path} is no text table ({error}).") from error
    missing = [name for name in ("time", "x", "y") if name not in names]
    if missing or not rows:
        raise StorageError(
            f"{path} holds no recordings: columns time, x, y are needed; missing {missing}, {len(rows)} rows."
        )
    twice = sorted({name for name in names if name and names.count(name) > 1})
    if twice:
        raise StorageError(f"{path}: each column needs a name of its own; twice there: {', '.join(map(repr, twice))}.")
    for number, row in enumerate(rows):
        if None in row or None in row.values():
            raise StorageError(
                f"{path}: row {number + 1} must have {len(names)} values, as the header has; it has not."
            )
    groups: dict[str, list[dict[str, str]]] = {}
    for row in rows:
        groups.setdefault(row.get("demonstration") or "0", []).append(row)
    return [_csv_demonstration(path, names, group, scale) for group in groups.values()]


def _csv_demonstration(path: Path, names: list[str], rows: list[dict[str, str]], scale: float) -> Demonstration:
    def columns(wanted: tuple[str, ...]) -> Array:
        try:
            return np.array([[float(row[name].strip() or "nan") for name in wanted] for row in rows])
        except ValueError as error:
            listed = ", ".join(wanted)
            raise StorageError(f"{path}: column {listed} must hold numbers ({error}).") from error

    known = {"time", "label", "demonstration", *_POSITION, *_QUATERNION}
    return _demonstration(
        f"a recording of {path.name}",
        columns(("time",))[:, 0],
        scale * _spatial(columns(tuple(name for name in _POSITION if name in names))),
        columns(_QUATERNION) if all(name in names for name in _QUATERNION) else None,
        label=rows[0].get("label") or path.stem,
        continuous={name: columns((name,))[:, 0] for name in names if name and name not in known},
    )
