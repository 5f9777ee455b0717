"""The methods that are compared: ours and the paper's over flow tubes, and the baselines, behind one interface."""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache, partial
from typing import Any

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.evaluation.trace import Classifier, Learn, Trace, grouped
from pft_exec.exceptions import UnknownMethodError
from pft_exec.learning import Motion, MotionLibrary, learn_library, learn_motion
from pft_exec.recognition import OnlineRecognizer


@contextmanager
def expected_conflicts() -> Iterator[None]:
    """Silence the learner's warnings of conflicting variables: in scenes drawn at random they are no news."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        yield


@dataclass(frozen=True, eq=False)
class TubeClassifier:
    """Flow tubes made for the scene and the start of each recording, and the online recognizer over them.

    Recordings one after another that share scene and start share tubes and recognizer; those are kept in `_made`.
    """

    library: MotionLibrary
    method: str
    _made: dict[tuple[Any, ...], OnlineRecognizer] = field(default_factory=dict)

    def recognize(self, demonstration: Demonstration) -> Trace:
        """Tubes for the scene at the first sample; then one sample at a time."""
        recognizer = self._recognizer(demonstration)
        quaternions = demonstration.quaternion
        begin = time.perf_counter()
        beliefs = [
            recognizer.update(
                float(demonstration.time[t]),
                demonstration.position[t],
                None if quaternions is None else quaternions[t],
            )
            for t in range(len(demonstration))
        ]
        seconds = (time.perf_counter() - begin) / len(demonstration)
        return Trace(
            recognizer.labels,
            np.array([list(belief.log_likelihood.values()) for belief in beliefs]),
            np.array([list(belief.probability.values()) for belief in beliefs]),
            np.array([belief.unknown for belief in beliefs]),
            seconds,
        )

    def _recognizer(self, demonstration: Demonstration) -> OnlineRecognizer:
        scene, start = demonstration.scene, demonstration.start
        poses = [("", start), *scene.objects.items()]
        key = tuple((name, pose.position.tobytes(), pose.quaternion.tobytes()) for name, pose in poses)
        if key not in self._made:
            self._made.clear()
            with expected_conflicts():
                tubes = self.library.flow_tubes(scene, start)
            self._made[key] = OnlineRecognizer(tubes, method=self.method)
        self._made[key].restart()
        return self._made[key]


def learn_tubes(demonstrations: Sequence[Demonstration], learning: str, recognition: str) -> TubeClassifier:
    """Learn a library; its tubes are made anew for each scene and start."""
    with expected_conflicts():
        if learning == "dong2012":
            library = learn_library(demonstrations, method=learning, **published_options(demonstrations))
        else:
            groups = grouped(demonstrations).items()
            library = MotionLibrary({label: _learn_motion(tuple(group), learning) for label, group in groups})
    return TubeClassifier(library, recognition)


@lru_cache(maxsize=64)
def _learn_motion(demonstrations: tuple[Demonstration, ...], learning: str) -> Motion:
    """Learn one motion; a library without another of its motions need not learn this one anew."""
    return learn_motion(demonstrations, learning)


def published_options(demonstrations: Sequence[Demonstration]) -> dict[str, Any]:
    """What [Dong2012]_ leaves open, set as well as it can be, the same for every comparison.

    On two seeds of the planar world: with ``epsilon=0.1``, places that people hit within a tenth of the field are found
    irrelevant (66 % in varying scenes, 0.3 gives 83 to 97 %); with a regularization of 1 % of the motions' extent the
    covariance of five demonstrations is too sure (81 % in one scene, 5 % gives 96 %); an object that is carried must
    count where it was at the start.
    """
    extent = float(np.median([np.linalg.norm(np.ptp(item.position, axis=0)) for item in demonstrations]))
    return {"epsilon": 0.3, "object_pose": "start", "regularization": max(0.05 * extent, 1e-12)}


def _learn_hmm(demonstrations: Sequence[Demonstration], states: int | None, topology: str) -> Classifier:
    from pft_exec.evaluation.baselines.hmm import learn_hmm

    return learn_hmm(demonstrations, states=states, topology=topology)


def _learn_promp(demonstrations: Sequence[Demonstration]) -> Classifier:
    from pft_exec.evaluation.baselines.promp import learn_promp

    return learn_promp(demonstrations)


def _learn_neighbor(demonstrations: Sequence[Demonstration], direction: bool) -> Classifier:
    from pft_exec.evaluation.baselines.nearest_neighbor import learn_nearest_neighbor

    return learn_nearest_neighbor(demonstrations, direction=direction)


# A baseline's libraries are an extra of the package: they are imported when the method is asked for.
METHODS: dict[str, Learn] = {
    "robust, phase": partial(learn_tubes, learning="robust", recognition="phase"),
    "dong2012": partial(learn_tubes, learning="dong2012", recognition="dong2012"),
    "HMM, left to right": partial(_learn_hmm, states=3, topology="left_to_right"),
    "HMM, ergodic": partial(_learn_hmm, states=3, topology="ergodic"),
    "ProMP": _learn_promp,
    "DTW neighbor": partial(_learn_neighbor, direction=False),
    "DTW neighbor, direction": partial(_learn_neighbor, direction=True),
}
OPTIONAL_METHODS: dict[str, Learn] = {
    "HMM, states by BIC": partial(_learn_hmm, states=None, topology="left_to_right"),
    "robust, dong2012": partial(learn_tubes, learning="robust", recognition="dong2012"),
    "dong2012, phase": partial(learn_tubes, learning="dong2012", recognition="phase"),
}


def method_named(name: str) -> Learn:
    """The learning function of a method.

    Raises
    ------
    UnknownMethodError
        If there is none of that name.
    """
    choices = METHODS | OPTIONAL_METHODS
    if name not in choices:
        raise UnknownMethodError("method of recognition", name, choices)
    return choices[name]
