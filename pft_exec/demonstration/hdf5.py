"""The door to HDF5: nested contents written whole or not at all, and read back only when the file is what it says.

A file is a tree. A mapping is a group; a sequence is a group with the attribute ``sequence`` and members named
"0", "1", ...; an array is a dataset (compressed, with checksums); text, numbers and None are scalar datasets. The
root carries two attributes, ``format`` (what the file holds) and ``version`` (which schema, from 1 up).
Nothing in a file is ever executed: there is no pickle.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pft_exec.exceptions import StorageError

_PLAIN = "biufcb"  # kinds of arrays that HDF5 holds bit for bit
_COMPRESS_FROM = 256  # values; smaller arrays gain nothing


def write_file(path: str | Path, contents: Mapping[str, Any], format_name: str, version: int) -> Path:
    """Write a tree beside `path`, then put it in place in one step: the old file or the new one, never half of it.

    Parameters
    ----------
    path : str or Path
        Its folder must exist.
    contents : mapping
        Values are arrays of numbers, str, bool, int, float, None, sequences of these, or mappings of the same.
    format_name : str
        What the file holds, such as "pft_exec demonstrations".
    version : int
        Version of the schema, from 1 up.

    Raises
    ------
    StorageError
        If the folder is missing, the path is a folder, nothing can be written there, or a value has no place in HDF5.
    """
    import h5py

    path = Path(path)
    _check_target(path)
    beside = path.with_name(f".{path.name}.{os.getpid()}-{secrets.token_hex(4)}.partial")
    try:
        with h5py.File(beside, "w", track_order=True) as file:
            file.attrs["format"], file.attrs["version"] = format_name, int(version)
            for name, value in contents.items():
                _write(file, name, value)
        _to_disk(beside)
        beside.replace(path)
    except StorageError as error:
        raise StorageError(f"cannot write {path}: {error}") from error
    except (OSError, ValueError) as error:
        raise StorageError(f"cannot write {path}: {error}.") from error
    finally:
        beside.unlink(missing_ok=True)
    return path


def read_file(path: str | Path, format_name: str, version: int) -> dict[str, Any]:
    """Read the tree that `write_file` wrote.

    Parameters
    ----------
    path : str or Path
    format_name : str
        What the file must hold.
    version : int
        The newest schema that the caller understands.

    Returns
    -------
    dict
        Mappings as dict, sequences as list, arrays as arrays of their own dtype.

    Raises
    ------
    StorageError
        If the file is missing, a folder, truncated or damaged, not HDF5, of another format, or of a newer version.
    """
    import h5py

    path = Path(path)
    _check_source(path, format_name)
    try:
        with h5py.File(path, "r") as file:
            _check_identity(path, dict(file.attrs), format_name, version)
            return {_unescaped(name): _read(file[name]) for name in file}
    except StorageError:
        raise
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
        raise StorageError(
            f"{path} is truncated or damaged and cannot be read ({error}). Restore or rewrite it."
        ) from error


def read_format(path: str | Path) -> str:
    """What a file says it holds, such as "pft_exec demonstrations"; empty where it says nothing.

    Raises
    ------
    StorageError
        If the file is missing, a folder, truncated or damaged, or not HDF5.
    """
    import h5py

    path = Path(path)
    _check_source(path, "a file of pft_exec")
    try:
        with h5py.File(path, "r") as file:
            return str(file.attrs.get("format", ""))
    except (OSError, RuntimeError) as error:
        raise StorageError(f"{path} is truncated or damaged and cannot be read ({error}).") from error


def _check_target(path: Path) -> None:
    if path.is_dir():
        raise StorageError(f"cannot write {path}: it is a folder. Name a file in it, such as {path / 'file.h5'}.")
    if not path.parent.is_dir():
        raise StorageError(f"cannot write {path}: the folder {path.parent} does not exist. Make it first.")


def _check_source(path: Path, format_name: str) -> None:
    if path.is_dir():
        raise StorageError(f"{path} is a folder, not a file of {format_name}.")
    if not path.exists():
        raise StorageError(f"there is no file {path}.")
    signature = b"\x89HDF\r\n\x1a\n"
    try:
        with path.open("rb") as file:
            head = file.read(len(signature))
    except OSError as error:
        raise StorageError(f"{path} cannot be opened ({error.strerror}).") from error
    if not head or (len(head) < len(signature) and signature.startswith(head)):
        raise StorageError(f"{path} is truncated: it has {len(head)} bytes. Restore or rewrite it.")
    if head != signature:
        raise StorageError(
            f"{path} is not an HDF5 file; expected {format_name}. Recordings of others: convert them first."
        )


def _check_identity(path: Path, attributes: Mapping[str, Any], format_name: str, version: int) -> None:
    found = attributes.get("format")
    if found != format_name:
        what = "no format that this package writes" if found is None else repr(str(found))
        raise StorageError(f"{path} is a foreign file: expected format {format_name!r}, found {what}.")
    number = attributes.get("version")
    if not isinstance(number, (int, np.integer)) or number < 1:
        raise StorageError(f"{path} has no valid schema version: expected 1 to {version}, found {number!r}.")
    if number > version:
        raise StorageError(
            f"{path} was written by a newer pft_exec: its schema has version {number}, this one reads up to {version}. "
            f"Update pft_exec."
        )


def _to_disk(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _escaped(name: str) -> str:
    if not isinstance(name, str) or "\x00" in name:
        raise StorageError(f"a name must be text without NUL; got {name!r}.")
    text = name.replace("%", "%25").replace("/", "%2F")
    return {"": "%00", ".": "%2E"}.get(text, text)


def _unescaped(name: str) -> str:
    text = {"%00": "", "%2E": "."}.get(name, name)
    return text.replace("%2F", "/").replace("%25", "%")


def _write(parent: Any, name: str, value: Any) -> None:
    """Add one value, whatever its kind, to the group `parent`."""
    key = _escaped(name)
    if isinstance(value, Mapping):
        group = parent.create_group(key, track_order=True)
        for inner, item in value.items():
            _write(group, inner, item)
    elif isinstance(value, (list, tuple)):
        group = parent.create_group(key)
        group.attrs["sequence"] = len(value)
        for index, item in enumerate(value):
            _write(group, str(index), item)
    else:
        _write_leaf(parent, key, name, value)


def _write_leaf(parent: Any, key: str, name: str, value: Any) -> None:
    import h5py

    if value is None:
        parent.create_dataset(key, data=h5py.Empty("f8"))
    elif isinstance(value, str):
        if "\x00" in value:
            raise StorageError(f"text under {name!r} holds a NUL character.")
        parent.create_dataset(key, data=value, dtype=h5py.string_dtype())
    elif isinstance(value, (np.ndarray, bool, int, float, np.number, np.bool_)):
        array = np.asarray(value)
        if array.dtype.kind not in _PLAIN:
            raise StorageError(f"{name!r} has dtype {array.dtype}, which has no place in the file; expected numbers.")
        parent.create_dataset(key, data=array, **_filters(array))
        if not isinstance(value, np.ndarray):
            parent[key].attrs["scalar"] = True
    else:
        raise StorageError(f"{name!r} is a {type(value).__name__}; expected arrays, text, numbers, None or mappings.")


def _filters(array: Any) -> dict[str, Any]:
    if array.ndim == 0 or array.size == 0:
        return {}
    if array.size < _COMPRESS_FROM:
        return {"chunks": array.shape, "fletcher32": True}
    return {"chunks": True, "fletcher32": True, "shuffle": True, "compression": "gzip", "compression_opts": 4}


def _read(node: Any) -> Any:
    """The value of a group or dataset."""
    import h5py

    if isinstance(node, h5py.Group):
        if "sequence" in node.attrs:
            return [_read(node[str(index)]) for index in range(int(node.attrs["sequence"]))]
        return {_unescaped(name): _read(node[name]) for name in node}
    value = node[()]
    if isinstance(value, h5py.Empty):
        return None
    if isinstance(value, bytes):
        return value.decode("utf-8")
    if "scalar" in node.attrs:
        return value.item()
    return np.asarray(value)
