"""A task: objects and where they may stand, motions as waypoints with the relations they obey, and success, as data.

A ``task.toml`` becomes frozen dataclasses; `placement` draws scenes from them, `path` turns waypoints into poses and
`success` judges an end. Written for a right-hand arm; `TaskDescription.mirrored` is the same task for the left one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

from pft_exec.assets import task_file
from pft_exec.description.motion import ABSOLUTE, NONE, START, WORLD, MotionDescription, StartDescription
from pft_exec.description.object import Clearance, LiquidDescription, ObjectDescription
from pft_exec.description.quantities import FixedPose, Region
from pft_exec.description.strict import read_strictly, suggestion
from pft_exec.exceptions import DescriptionError, UnknownMotionError
from pft_exec.geometry import Pose


@dataclass(frozen=True)
class _TaskFile:
    """What stands in a task.toml."""

    title: str
    robot_base: FixedPose
    workspace: Region
    clearance: Clearance
    start: StartDescription
    objects: dict[str, ObjectDescription]
    motions: dict[str, MotionDescription]
    liquid: LiquidDescription = field(default_factory=LiquidDescription)


@dataclass(frozen=True)
class TaskDescription:
    """A task: objects, motions, where the tool begins and may be, and where the robot stands; names no robot.

    Parameters
    ----------
    name, title : str
    folder : Path
        Where its files are.
    robot_base : Pose
        Of the robot's base, world frame.
    workspace : Region
        Where the tool may be, world frame; of the unmirrored task.
    clearance : Clearance
    start : StartDescription
        For motions without one of their own; of the unmirrored task.
    objects : mapping of name to ObjectDescription
    motions : mapping of label to MotionDescription
    liquid : LiquidDescription
        What motions pour.
    mirror : Pose or None
        The frame in whose xz plane everything drawn or resolved is mirrored; None is the task as written.
    """

    name: str
    title: str
    folder: Path
    robot_base: Pose
    workspace: Region
    clearance: Clearance
    start: StartDescription
    objects: Mapping[str, ObjectDescription]
    motions: Mapping[str, MotionDescription]
    liquid: LiquidDescription = field(default_factory=LiquidDescription)
    mirror: Pose | None = None

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the motions, in the order of the file."""
        return tuple(self.motions)

    def motion(self, label: str) -> MotionDescription:
        """The motion of that label.

        Raises
        ------
        UnknownMotionError
            If the task has none.
        """
        if label not in self.motions:
            raise UnknownMotionError("motion", label, self.motions, f"They are the motions of task {self.name!r}.")
        return self.motions[label]

    def start_of(self, label: str) -> StartDescription:
        """Where the tool stands before that motion, in the unmirrored task."""
        return self.motion(label).start or self.start

    def chain(self, label: str) -> tuple[str, ...]:
        """The motions that are made one after another to come to that one: those that it follows, then itself."""
        before = self.motion(label).follows
        return (label,) if before is None else (*self.chain(before), label)

    @property
    def placed(self) -> tuple[str, ...]:
        """Names of the objects that make a scene: all but the fixed ones."""
        return tuple(name for name, item in self.objects.items() if item.placement is not None)

    @property
    def symmetric(self) -> frozenset[str]:
        """Names of the objects that look the same when turned about their z axis."""
        return frozenset(name for name, item in self.objects.items() if item.symmetry == "z")

    def relations(self, label: str) -> dict[str, str]:
        """What each end of a motion keeps its relation to, such as ``{"end.position": "bottle", ...}``."""
        ends = self.motion(label).relations
        return {
            f"{when}.{what}": getattr(getattr(ends, when), what)
            for when in ("start", "end")
            for what in ("position", "orientation")
        }

    def mirrored(self, plane: Pose | None = None) -> TaskDescription:
        """The task for the other arm: all that is drawn from it is mirrored in the xz plane of `plane`.

        The plane is that of the robot's base where None; mirrored twice it is the task as written.
        """
        return replace(self, mirror=None if self.mirror is not None else plane or self.robot_base)


def load_task(name_or_path: str | Path) -> TaskDescription:
    """Load a task by its name, its folder or its ``task.toml``.

    Raises
    ------
    UnknownTaskError
        If there is no such task.
    DescriptionError
        If the file has an unknown or missing key or a wrong value, or refers to an object that it does not define.
    """
    path = task_file(name_or_path)
    content = read_strictly(path, _TaskFile)
    _check_references(path, content)
    return TaskDescription(
        name=path.parent.name,
        title=content.title,
        folder=path.parent,
        robot_base=content.robot_base.pose,
        workspace=content.workspace,
        clearance=content.clearance,
        start=content.start,
        objects=MappingProxyType(content.objects),
        motions=MappingProxyType(content.motions),
        liquid=content.liquid,
    )


def _check_references(path: Path, content: _TaskFile) -> None:
    """Every name that one part of a task uses for another exists."""
    fixed = tuple(name for name, item in content.objects.items() if item.fixed is not None)
    placed = tuple(name for name in content.objects if name not in fixed)
    for name, item in content.objects.items():
        if name in (WORLD, START, ABSOLUTE, NONE):
            raise DescriptionError(f"{path}: objects.{name}: that word has a meaning of its own; choose another name.")
        if item.placement is not None:
            _check_name(path, f"objects.{name}.placement.on", item.placement.on, fixed)
    _check_name(path, "start.frame", content.start.frame, (WORLD, *placed))
    for label in content.motions:
        for key, name, choices in _named(content, label, fixed, placed):
            _check_name(path, f"motions.{label}.{key}", name, choices)
        _check_chain(path, content, label)


def _named(
    content: _TaskFile, label: str, fixed: tuple[str, ...], placed: tuple[str, ...]
) -> Iterator[tuple[str, str, tuple[str, ...]]]:
    """Where a motion names something, the name, and what it may be."""
    motion = content.motions[label]
    for index, waypoint in enumerate(motion.waypoints):
        for part, frame in zip(("position", "orientation"), waypoint.frames, strict=True):
            yield f"waypoints[{index}].{part}.frame", frame, (WORLD, START, *placed)
    for when, ends in (("start", motion.relations.start), ("end", motion.relations.end)):
        for part in ("position", "orientation"):
            yield f"relations.{when}.{part}", getattr(ends, part), (ABSOLUTE, NONE, START, *placed)
    for name, placement in motion.placements.items():
        yield f"placements.{name}", name, placed
        yield f"placements.{name}.on", placement.on, fixed
    if motion.start is not None:
        yield "start.frame", motion.start.frame, (WORLD, *placed)
    if motion.holds is not None:
        yield "holds.object", motion.holds.object, placed
    if motion.follows is not None:
        yield "follows", motion.follows, tuple(content.motions)
    for key, names in (("touches", motion.touches), ("success", motion.success.names), ("liquid", (motion.liquid,))):
        for named in names:
            if named is not None:
                yield key, named, (WORLD, START, *placed) if key == "success" else placed


def _check_chain(path: Path, content: _TaskFile, label: str) -> None:
    """A motion that goes on from another does not, in the end, go on from itself."""
    seen: list[str] = []
    following: str | None = label
    while following is not None:
        if following in seen:
            raise DescriptionError(f"{path}: motions.{label}.follows: {' follows '.join([*seen, following])}.")
        seen.append(following)
        following = content.motions[following].follows


def _check_name(path: Path, key: str, name: str, choices: tuple[str, ...]) -> None:
    if name not in choices:
        raise DescriptionError(f"{path}: {key}: nothing is named {name!r}.{suggestion(name, choices)}")
