"""The motion library: every motion that was taught, tubes of all of them for a scene, and its file."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.demonstration.hdf5 import read_file, write_file
from pft_exec.demonstration.storage import contents_from_demonstration, demonstration_from_contents
from pft_exec.exceptions import LearningError, MissingObjectError, PFTError, StorageError, UnknownMotionError
from pft_exec.geometry import Pose
from pft_exec.learning.decisions import motion_extent
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.learning.motion import Motion, check_taught, learn_motion

FORMAT = "pft_exec motion library"
VERSION = 1
REGULARIZATION = 0.01  # of the median extent of the motions: one value for a library, or it would favor labels


@dataclass(frozen=True, eq=False)
class MotionLibrary:
    """Learned motions by label; made by `learn_library` or `MotionLibrary.load`."""

    motions: Mapping[str, Motion]

    def __post_init__(self) -> None:
        object.__setattr__(self, "motions", MappingProxyType(dict(self.motions)))

    def __reduce__(self) -> tuple[Any, ...]:
        return MotionLibrary, (dict(self.motions),)

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the motions, in the order in which they were learned."""
        return tuple(self.motions)

    def __getitem__(self, label: str) -> Motion:
        try:
            return self.motions[label]
        except KeyError:
            raise UnknownMotionError("motion of the library", label, self.motions) from None

    def __contains__(self, label: object) -> bool:
        return label in self.motions

    def __iter__(self) -> Iterator[str]:
        return iter(self.motions)

    def __len__(self) -> int:
        return len(self.motions)

    def flow_tubes(
        self, scene: Scene, start: Pose | None = None, substitute: Mapping[str, str] | None = None
    ) -> dict[str, FlowTube]:
        """Tubes of all motions in a scene, as `flow_tube` makes each; one whose object is missing is left out.

        Warns
        -----
        RuntimeWarning
            Of each motion that is left out.

        Raises
        ------
        UnknownNameError
            If no motion of the library knows an object that is to be substituted.
        """
        self.check_substitute(substitute or {})
        tubes: dict[str, FlowTube] = {}
        for label in self.motions:
            try:
                tubes[label] = self.flow_tube(label, scene, start, substitute)
            except MissingObjectError as error:
                warnings.warn(f"motion {label!r} is left out: {error}", RuntimeWarning, stacklevel=2)
        return tubes

    def flow_tube(
        self, label: str, scene: Scene, start: Pose | None = None, substitute: Mapping[str, str] | None = None
    ) -> FlowTube:
        """As ``library[label].flow_tube``, but a substitution may name an object that only other motions know.

        Raises
        ------
        MissingObjectError
            If the scene lacks an object that a motion variable refers to, or a substitute.
        UnknownMotionError
            If there is no such motion.
        UnknownNameError
            If no motion of the library knows an object that is to be substituted.
        """
        self.check_substitute(substitute or {})
        motion = self[label]
        own = {taught: now for taught, now in (substitute or {}).items() if taught in motion.objects}
        return motion.flow_tube(scene, start, own)

    def check_substitute(self, substitute: Mapping[str, str]) -> None:
        """Raise UnknownNameError where no motion knows an object that is to be substituted."""
        if substitute:
            known = sorted({name for motion in self.motions.values() for name in motion.objects})
            check_taught(substitute, "object of the library's motions", known)

    def mirrored(self, plane: Pose | None = None) -> MotionLibrary:
        """Every motion as the other arm would make it."""
        return MotionLibrary({label: motion.mirrored(plane) for label, motion in self.motions.items()})

    def describe(self) -> str:
        """The decisions of all motions, one line each."""
        return "\n".join(motion.describe() for motion in self.motions.values())

    def save(self, path: str | Path) -> Path:
        """Write the library as HDF5: demonstrations, method and overrules, from which loading learns the same anew."""
        motions = [
            {
                "label": motion.label,
                "method": motion.method,
                "relevant": {end: list(names) for end, names in motion.relevant.items()},
                "options": dict(motion.options),
                "demonstrations": [contents_from_demonstration(d) for d in motion.demonstrations],
            }
            for motion in self.motions.values()
        ]
        return write_file(path, {"motions": motions}, FORMAT, VERSION)

    @classmethod
    def load(cls, path: str | Path) -> MotionLibrary:
        """Read a library that `save` wrote; learning is deterministic, so it equals what was saved.

        Raises
        ------
        StorageError
            If the file is missing, truncated, foreign or newer, or what it holds makes no library.
        """
        contents = read_file(path, FORMAT, VERSION)
        try:
            return cls({stored["label"]: _learned_anew(stored) for stored in contents["motions"]})
        except (KeyError, TypeError, AttributeError, PFTError) as error:
            raise StorageError(f"{path} is damaged: its contents make no motion library ({error}).") from error


def _learned_anew(stored: Mapping[str, Any]) -> Motion:
    demonstrations = [demonstration_from_contents(item) for item in stored["demonstrations"]]
    return learn_motion(demonstrations, stored["method"], stored["relevant"], **stored["options"])


def learn_library(demonstrations: Iterable[Demonstration], method: str = "robust", **options: Any) -> MotionLibrary:
    """Learn every motion of some demonstrations, grouped by label in order of appearance; `options` as `learn_motion`.

    Raises
    ------
    LearningError
        If there is no demonstration, or a label has too few.
    """
    groups: dict[str, list[Demonstration]] = {}
    for demonstration in demonstrations:
        groups.setdefault(demonstration.label, []).append(demonstration)
    if not groups:
        raise LearningError("a library is learned from demonstrations; got none.")
    if method == "dong2012" and options.get("regularization") is None:
        extents = [motion_extent(group) for group in groups.values()]
        options = options | {"regularization": REGULARIZATION * max(float(np.median(extents)), 1e-9)}
    return MotionLibrary({label: learn_motion(group, method, **options) for label, group in groups.items()})
