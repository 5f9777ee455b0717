"""Demonstrations on disk: one HDF5 file, read back bit for bit.

Schema, version 1 (format "pft_exec demonstrations"); under ``/demonstrations/<number from 0>``:

=============  ==========================  ================================================
name           type                        meaning
=============  ==========================  ================================================
label          text                        the motion
time           (N,) float, s               strictly increasing
position       (N, 3) float, m             tool, world frame
quaternion     (N, 4) float, or empty      (x, y, z, w), world frame
configuration  (N, n) float, or empty      joint state, rad or m
keyframes      (M,) float, s               instants at which a compound motion is split
continuous     group of (N,) float         scalar signals by name
discrete       group of (N,) int           discrete signals by name
objects        group of (N, 7) or (7,)     position, m, and quaternion (x, y, z, w), world frame
=============  ==========================  ================================================

How groups, text and "empty" look in HDF5, and how a file is protected: `pft_exec.demonstration.hdf5`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pft_exec.demonstration import hdf5
from pft_exec.demonstration.demonstration import Demonstration
from pft_exec.exceptions import InvalidDemonstrationError, StorageError

FORMAT = "pft_exec demonstrations"
VERSION = 1


def save_demonstrations(path: str | Path, demonstrations: Iterable[Demonstration]) -> Path:
    """Write demonstrations to an HDF5 file, whole or not at all; an existing file is replaced.

    Raises
    ------
    StorageError
        If the folder is missing, the path is a folder, or nothing can be written there.
    """
    contents = {"demonstrations": [contents_from_demonstration(item) for item in demonstrations]}
    return hdf5.write_file(path, contents, FORMAT, VERSION)


def load_demonstrations(path: str | Path) -> list[Demonstration]:
    """Read demonstrations from an HDF5 file, in the order in which they were saved.

    Raises
    ------
    StorageError
        If the file is missing, truncated, foreign or newer, or what it holds makes no demonstration.
    """
    contents = hdf5.read_file(path, FORMAT, VERSION)
    try:
        return [demonstration_from_contents(item) for item in contents["demonstrations"]]
    except (KeyError, TypeError, AttributeError, InvalidDemonstrationError) as error:
        raise StorageError(f"{path} is damaged: its contents make no demonstration ({error}).") from error


def contents_from_demonstration(demonstration: Demonstration) -> dict[str, Any]:
    """A demonstration as the nested mapping that `hdf5.write_file` takes."""
    return {
        "label": demonstration.label,
        "time": demonstration.time,
        "position": demonstration.position,
        "quaternion": demonstration.quaternion,
        "configuration": demonstration.configuration,
        "keyframes": np.array(demonstration.keyframes, dtype=float),
        "continuous": dict(demonstration.continuous),
        "discrete": dict(demonstration.discrete),
        "objects": dict(demonstration.objects),
    }


def demonstration_from_contents(contents: Mapping[str, Any]) -> Demonstration:
    """The demonstration of such a mapping.

    Raises
    ------
    KeyError
        If a field is missing.
    InvalidDemonstrationError
        If the arrays make no demonstration.
    """
    return Demonstration(
        label=contents["label"],
        time=contents["time"],
        position=contents["position"],
        quaternion=contents["quaternion"],
        continuous=contents["continuous"],
        discrete=contents["discrete"],
        objects=contents["objects"],
        configuration=contents["configuration"],
        keyframes=tuple(contents["keyframes"].tolist()),
    )
