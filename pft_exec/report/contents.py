"""What a file of ours holds: a table for the terminal, and a picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pft_exec.demonstration import Demonstration, load_demonstrations
from pft_exec.demonstration.hdf5 import read_format
from pft_exec.demonstration.storage import FORMAT as DEMONSTRATIONS
from pft_exec.exceptions import StorageError
from pft_exec.execution.log import FORMAT as LOG
from pft_exec.execution.log import ExecutionLog
from pft_exec.learning import MotionLibrary
from pft_exec.learning.library import FORMAT as LIBRARY
from pft_exec.report.paths import plot_demonstrations
from pft_exec.report.seam import plot_log
from pft_exec.report.tables import decision_rows, demonstration_rows, log_rows
from pft_exec.report.tubes import plot_tubes


@dataclass(frozen=True)
class FileContents:
    """A file of ours, read.

    Parameters
    ----------
    kind : str
        The format that the file names.
    title : str
        One line for a reader.
    rows : list of dict
        A table, a column per key.
    data : list of Demonstration, MotionLibrary or ExecutionLog
    """

    kind: str
    title: str
    rows: list[dict[str, Any]]
    data: list[Demonstration] | MotionLibrary | ExecutionLog


def read_contents(path: str | Path) -> FileContents:
    """Read a file of demonstrations, a motion library, or the log of a run.

    Raises
    ------
    StorageError
        If the file is none of these, missing, truncated or newer than this version.
    """
    kind = read_format(path)
    if kind == DEMONSTRATIONS:
        demonstrations = load_demonstrations(path)
        title = f"{len(demonstrations)} demonstrations"
        return FileContents(kind, title, demonstration_rows(demonstrations), demonstrations)
    if kind == LIBRARY:
        library = MotionLibrary.load(path)
        return FileContents(kind, f"library of {len(library)} motions", decision_rows(library), library)
    if kind == LOG:
        log = ExecutionLog.load(path)
        return FileContents(kind, f"run of {log.label or 'no motion'}: {log.reason}", log_rows(log), log)
    choices = ", ".join((DEMONSTRATIONS, LIBRARY, LOG))
    raise StorageError(f"{path} holds {kind or 'nothing that this package writes'!r}; expected one of: {choices}.")


def plot_contents(contents: FileContents, path: str | Path) -> None:
    """Draw what a file holds: demonstrations; a library's tubes in a scene it was taught in; a run and its handoff.

    Raises
    ------
    StorageError
        If the picture cannot be written.
    """
    data = contents.data
    if isinstance(data, ExecutionLog):
        plot_log(data, path)
    elif isinstance(data, MotionLibrary):
        scenes = {label: data[label].demonstrations[0].scene for label in data.labels}
        tubes = {label: data[label].flow_tube(scene) for label, scene in scenes.items()}
        plot_tubes(tubes, [item for label in scenes for item in data[label].demonstrations], path, scenes)
    else:
        plot_demonstrations(data, path)
