"""A motion: what was learned from a handful of demonstrations of one label, ready for any scene.

In the flow: demonstrations -> `learn_motion` -> `Motion` -> ``flow_tube(scene)`` -> recognition, handoff, control.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.exceptions import LearningError, UnknownMethodError, UnknownNameError
from pft_exec.geometry import Pose
from pft_exec.learning.decisions import find_variables
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.learning.frames import object_names
from pft_exec.learning.report import describe
from pft_exec.learning.robust import RobustMotion, generalize, learn_robust
from pft_exec.learning.variables import ABSOLUTE, ENDS, START, MotionVariables

METHODS = ("dong2012", "robust")
OVERRULED = (*ENDS, *(f"{end}.orientation" for end in ENDS))


@dataclass(frozen=True, eq=False)
class Motion:
    """A learned motion; made by `learn_motion`."""

    label: str
    demonstrations: tuple[Demonstration, ...]
    method: str
    relevant: Mapping[str, tuple[str, ...]]
    variables: MotionVariables
    learned: RobustMotion

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
            If the scene lacks an object that a motion variable refers to.
        """
        scene = substituted(scene, substitute or {})
        return generalize(self.label, self.learned, self.variables, scene, start)

    def mirrored(self, plane: Pose | None = None) -> Motion:
        """The motion as the other arm would make it: learned from mirrored demonstrations."""
        return learn_motion([d.mirrored(plane) for d in self.demonstrations], self.method, self.relevant)

    def describe(self) -> str:
        """The decisions as a table for a reader."""
        return describe(self.label, self.variables)


def substituted(scene: Scene, substitute: Mapping[str, str]) -> Scene:
    """The scene in which each demonstrated object stands where its substitute stands."""
    return Scene(dict(scene.objects) | {taught: scene[now] for taught, now in substitute.items()})


def learn_motion(
    demonstrations: Sequence[Demonstration],
    method: str = "robust",
    relevant: Mapping[str, Sequence[str]] | None = None,
) -> Motion:
    """Learn one motion from its demonstrations.

    Parameters
    ----------
    demonstrations : 2 to some 100 of one label
    method : str
        "robust" or "dong2012".
    relevant : {"start", "end", "start.orientation" or "end.orientation": frames}
        Overrules the decision for the position (orientation) at that end: names of objects, "absolute" or "start";
        an empty sequence says that nothing is relevant. Several frames are fused by their precisions.

    Raises
    ------
    LearningError
        If there are fewer than two demonstrations, or their labels or channels differ.
    UnknownMethodError
        If the method does not exist.
    UnknownNameError
        If `relevant` names an end or a frame that does not exist.
    """
    demonstrations = tuple(demonstrations)
    if method not in METHODS:
        raise UnknownMethodError("learning method", method, METHODS)
    _check(demonstrations)
    overrules = _checked_overrules(demonstrations, relevant or {})
    variables = find_variables(demonstrations, overrules)
    learned = learn_robust(demonstrations, variables)
    return Motion(demonstrations[0].label, demonstrations, method, overrules, variables, learned)


def _check(demonstrations: Sequence[Demonstration]) -> None:
    if len(demonstrations) < 2:
        label = f" of {demonstrations[0].label!r}" if demonstrations else ""
        raise LearningError(
            f"a motion is learned from at least 2 demonstrations{label} (5 are usual); got {len(demonstrations)}."
        )
    labels = sorted({d.label for d in demonstrations})
    if len(labels) > 1:
        raise LearningError(f"the demonstrations of one motion carry one label; got {', '.join(labels)}.")
    if len({d.quaternion is None for d in demonstrations}) > 1:
        raise LearningError(f"either all demonstrations of {labels[0]!r} have an orientation or none has.")


def _checked_overrules(
    demonstrations: Sequence[Demonstration], relevant: Mapping[str, Sequence[str]]
) -> dict[str, tuple[str, ...]]:
    objects = object_names(demonstrations)
    for end, names in relevant.items():
        if end not in OVERRULED:
            raise UnknownNameError("end of a motion", end, OVERRULED)
        choices = (ABSOLUTE, *(() if end.startswith(START) else (START,)), *objects)
        for name in names:
            if name not in choices:
                raise UnknownNameError("frame", name, choices)
    return {end: tuple(names) for end, names in relevant.items()}
