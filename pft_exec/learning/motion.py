"""A motion: what was learned from a handful of demonstrations of one label, ready for any scene.

In the flow: demonstrations -> `learn_motion` -> `Motion` -> ``flow_tube(scene)`` -> recognition, handoff, control.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.exceptions import LearningError, UnknownMethodError, UnknownNameError
from pft_exec.geometry import Pose
from pft_exec.learning.carrying import carried_objects
from pft_exec.learning.coaching import Coaching, coach
from pft_exec.learning.compound import join_tubes, joined_variables, pieces_of
from pft_exec.learning.decisions import Overrules, find_variables, without_incomplete
from pft_exec.learning.dong2012 import Dong2012Motion, Dong2012Options, generalize_dong2012, learn_dong2012
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.learning.frames import object_names
from pft_exec.learning.published_variables import find_published_variables, published_decisions
from pft_exec.learning.report import describe
from pft_exec.learning.robust import RobustMotion, generalize, learn_robust
from pft_exec.learning.variables import ABSOLUTE, ENDS, NONE, START, WAY, MotionVariables

METHODS = ("dong2012", "robust")
OVERRULED = (*ENDS, *(f"{end}.orientation" for end in ENDS), WAY)


@dataclass(frozen=True, eq=False)
class Motion:
    """A learned motion; made by `learn_motion`."""

    label: str
    demonstrations: tuple[Demonstration, ...]
    method: str
    relevant: Mapping[str, Sequence[str]]
    variables: MotionVariables
    learned: RobustMotion | Dong2012Motion | None
    options: Mapping[str, Any] = field(default_factory=dict)
    segments: tuple[Motion, ...] = ()

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the objects that some demonstration has, sorted; others have no part in the motion."""
        return tuple(sorted({name for demonstration in self.demonstrations for name in demonstration.objects}))

    def flow_tube(
        self, scene: Scene, start: Pose | None = None, substitute: Mapping[str, str] | None = None
    ) -> FlowTube:
        """The flow tube of this motion in a scene.

        Parameters
        ----------
        scene : Scene
            Objects as they stand now, world frame.
        start : Pose or None
            Tool pose now; None stands for the relevant start, else for the mean demonstrated one.
        substitute : {name: name}
            Objects of the scene that take the place of demonstrated ones.

        Raises
        ------
        MissingObjectError
            If the scene lacks an object that a motion variable refers to, or a substitute.
        UnknownNameError
            If no demonstration has an object that is to be substituted.
        """
        check_taught(substitute or {}, f"object of motion {self.label!r}", self.objects)
        return self._flow_tube(substituted(scene, substitute or {}), start)

    def _flow_tube(self, scene: Scene, start: Pose | None) -> FlowTube:
        tubes: list[FlowTube] = []
        for segment in self.segments:
            tubes.append(segment._flow_tube(scene, tubes[-1].end if tubes else start))
        if tubes:
            return join_tubes(self.label, tubes)
        if isinstance(self.learned, Dong2012Motion):
            return generalize_dong2012(self.label, self.learned, scene, start)
        if self.learned is None:
            raise LearningError(f"motion {self.label!r} has neither segments nor anything learned.")
        return generalize(self.label, self.learned, self.variables, scene, start)

    def mirrored(self, plane: Pose | None = None) -> Motion:
        """The motion as the other arm would make it: learned from mirrored demonstrations."""
        mirrored = [d.mirrored(plane) for d in self.demonstrations]
        return learn_motion(mirrored, self.method, self.relevant, **self.options)

    def describe(self) -> str:
        """The decisions as a table for a reader, segment by segment where keyframes split the motion."""
        if self.segments:
            return "\n".join(segment.describe() for segment in self.segments)
        return describe(self.label, self.variables, self.demonstrations)

    def coach(self) -> Coaching:
        """Which demonstration stands out, what the placements do not cover, and what one more should vary."""
        learned = self.learned
        if not isinstance(learned, RobustMotion):
            learned = learn_robust(self.demonstrations, find_variables(self.demonstrations, self.relevant))
        return coach(self.demonstrations, self.variables, learned.residual)


def check_taught(substitute: Mapping[str, str], kind: str, objects: Sequence[str]) -> None:
    """Refuse to substitute what is not among the taught `objects`; `kind` says whose they are."""
    for name in substitute:
        if name not in objects:
            raise UnknownNameError(kind, name, objects, "Only an object that was there when it was taught has a place.")


def substituted(scene: Scene, substitute: Mapping[str, str]) -> Scene:
    """The scene in which each demonstrated object stands where its substitute stands."""
    return Scene(dict(scene.objects) | {taught: scene[now] for taught, now in substitute.items()})


def learn_motion(
    demonstrations: Sequence[Demonstration],
    method: str = "robust",
    relevant: Mapping[str, Sequence[str]] | None = None,
    **options: Any,
) -> Motion:
    """Learn one motion from its demonstrations.

    Parameters
    ----------
    demonstrations : 2 to some 100 of one label
    method : str
        "robust" or "dong2012".
    relevant : {"start", "end", "start.orientation", "end.orientation" or "way": frames}
        Overrules the decision for the position (orientation) at that end: names of objects, "absolute" or "start", or
        one such name; an empty sequence says that nothing is relevant. Several frames are fused by their precisions.
        "way": the objects that are passed between the ends (method "robust").
    options
        Of "dong2012": the fields of `Dong2012Options`, such as ``epsilon=0.1``. "robust" has none.

    Raises
    ------
    LearningError
        If there are fewer than two demonstrations, what is given is none, their labels or channels differ, an object
        has the name of a frame ("absolute", "start" or none), or `relevant` is no mapping of ends to frames.
    UnknownMethodError
        If the method does not exist.
    UnknownNameError
        If `relevant` names an end or a frame that does not exist, or the method has no such option.

    Warns
    -----
    RuntimeWarning
        If an object holds an end but is missing from some demonstrations: the others teach alone (method "robust").
    """
    if method not in METHODS:
        raise UnknownMethodError("learning method", method, METHODS)
    demonstrations = _checked(demonstrations)
    overrules = _checked_overrules(demonstrations, relevant or {})
    settings = _checked_options(method, options)
    if method == "robust":
        demonstrations = _complete(demonstrations, overrules)
    if any(d.keyframes for d in demonstrations):
        return _learn_segments(demonstrations, method, overrules, options)
    return _learn_one(demonstrations, method, overrules, settings)


def _complete(demonstrations: tuple[Demonstration, ...], overrules: Overrules) -> tuple[Demonstration, ...]:
    """Those that have the objects which the motion is about; where some lack one, that is said."""
    kept, names = without_incomplete(demonstrations, overrules)
    if names:
        lacking = ", ".join(str(i + 1) for i, d in enumerate(demonstrations) if not set(names) <= set(d.objects))
        warnings.warn(
            f"{demonstrations[0].label!r} is about {', '.join(names)}, which demonstration {lacking} of "
            f"{len(demonstrations)} lacks: it is learned from the others. Record the object in all of them.",
            RuntimeWarning,
            stacklevel=3,
        )
    return tuple(kept)


def _learn_one(
    demonstrations: tuple[Demonstration, ...], method: str, overrules: Overrules, settings: Dong2012Options
) -> Motion:
    label = demonstrations[0].label
    if method == "robust":
        variables = find_variables(demonstrations, overrules)
        robust = learn_robust(demonstrations, variables, overrules.get(WAY))
        variables = replace(variables, passed=robust.passages)
        return Motion(label, demonstrations, method, overrules, variables, robust)
    found = find_published_variables(demonstrations, settings.epsilon, settings.spread, settings.object_pose)
    variables = published_decisions(found, demonstrations[0].quaternion is not None, overrules)
    learned = learn_dong2012(demonstrations, found, overrules, settings)
    return Motion(label, demonstrations, method, overrules, variables, learned, asdict(settings))


def _learn_segments(
    demonstrations: tuple[Demonstration, ...], method: str, overrules: Overrules, options: Mapping[str, Any]
) -> Motion:
    """A motion of several pieces; what is overruled holds for the first start, the last end, and every way."""
    pieces = pieces_of(demonstrations)
    segments = []
    for index, piece in enumerate(pieces):
        own = {end: names for end, names in overrules.items() if _concerns(end, index, len(pieces))}
        segments.append(learn_motion(piece, method, own, **options))
    variables = joined_variables([s.variables for s in segments], carried_objects(demonstrations))
    label = demonstrations[0].label
    return Motion(label, demonstrations, method, overrules, variables, None, dict(options), tuple(segments))


def _concerns(end: str, index: int, count: int) -> bool:
    return end == WAY or index == (0 if end.startswith(START) else count - 1)


def _checked_options(method: str, options: Mapping[str, Any]) -> Dong2012Options:
    choices = tuple(Dong2012Options.__dataclass_fields__) if method == "dong2012" else ()
    for name in options:
        if name not in choices:
            raise UnknownNameError(f"option of method {method!r}", name, choices)
    return Dong2012Options(**options)


def _checked(given: Sequence[Demonstration]) -> tuple[Demonstration, ...]:
    if isinstance(given, Demonstration):
        raise LearningError(f"a motion is learned from a list of demonstrations; got a single one of {given.label!r}.")
    demonstrations = tuple(given)
    for index, item in enumerate(demonstrations):
        if not isinstance(item, Demonstration):
            raise LearningError(
                f"item {index} of the demonstrations is a {type(item).__name__}, not a Demonstration: make one of "
                f"its arrays, Demonstration(label, time, position, ...), or load a file with load_demonstrations."
            )
    if len(demonstrations) < 2:
        label = f" of {demonstrations[0].label!r}" if demonstrations else ""
        raise LearningError(
            f"a motion is learned from at least 2 demonstrations{label} (5 are usual); got {len(demonstrations)}."
        )
    labels = sorted({d.label for d in demonstrations})
    if len(labels) > 1:
        raise LearningError(f"the demonstrations of one motion carry one label; got {', '.join(labels)}.")
    taken = sorted(name for name in object_names(demonstrations) if name in (ABSOLUTE, START, NONE))
    if taken:
        raise LearningError(
            f"an object of {labels[0]!r} is named {taken[0]!r}, as a frame of every motion is, or none: rename it."
        )
    if len({d.quaternion is None for d in demonstrations}) > 1:
        raise LearningError(f"either all demonstrations of {labels[0]!r} have an orientation or none has.")
    return demonstrations


def _checked_overrules(
    demonstrations: Sequence[Demonstration], relevant: Mapping[str, Sequence[str]]
) -> dict[str, tuple[str, ...]]:
    objects = object_names(demonstrations)
    if not isinstance(relevant, Mapping):
        raise LearningError(f'relevant says at which end: relevant={{"end": ["cup"]}}; got {relevant!r}.')
    for end, names in relevant.items():
        if not isinstance(names, Iterable):
            raise LearningError(f'relevant names the frames at an end: {{{end!r}: ["cup"]}}; got {names!r}.')
    named = {end: (names,) if isinstance(names, str) else tuple(names) for end, names in relevant.items()}
    for end, names in named.items():
        if end not in OVERRULED:
            raise UnknownNameError("end of a motion", end, OVERRULED)
        frames = {WAY: (), START: (ABSOLUTE,)}.get(end.partition(".")[0], (ABSOLUTE, START))
        choices = (*frames, *objects)
        for name in names:
            if name not in choices:
                raise UnknownNameError("frame", name, choices)
    return named
