"""The methods that are compared: ours and the paper's over flow tubes, and the baselines, behind one interface."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.evaluation.baselines import learn_hmm, learn_nearest_neighbor, learn_promp
from pft_exec.evaluation.trace import Learn, Trace
from pft_exec.exceptions import UnknownMethodError
from pft_exec.learning import MotionLibrary, learn_library
from pft_exec.recognition import OnlineRecognizer


@dataclass(frozen=True, eq=False)
class TubeClassifier:
    """Flow tubes made for the scene and the start of each recording, and the online recognizer over them."""

    library: MotionLibrary
    method: str

    def recognize(self, demonstration: Demonstration) -> Trace:
        """Tubes for the scene at the first sample; then one sample at a time."""
        tubes = self.library.flow_tubes(demonstration.scene, demonstration.start)
        recognizer = OnlineRecognizer(tubes, method=self.method)
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
        labels = tuple(tubes)
        return Trace(
            labels,
            np.array([[belief.log_likelihood[label] for label in labels] for belief in beliefs]),
            np.array([[belief.probability[label] for label in labels] for belief in beliefs]),
            np.array([belief.unknown for belief in beliefs]),
            seconds,
        )


def learn_tubes(demonstrations: Sequence[Demonstration], learning: str, recognition: str) -> TubeClassifier:
    """Learn a library; its tubes are made anew for each recording."""
    return TubeClassifier(learn_library(demonstrations, method=learning), recognition)


METHODS: dict[str, Learn] = {
    "robust, phase": partial(learn_tubes, learning="robust", recognition="phase"),
    "dong2012": partial(learn_tubes, learning="dong2012", recognition="dong2012"),
    "HMM, left to right": partial(learn_hmm, topology="left_to_right"),
    "HMM, ergodic": partial(learn_hmm, topology="ergodic"),
    "HMM, states by BIC": partial(learn_hmm, states=None),
    "ProMP": learn_promp,
    "DTW neighbor": learn_nearest_neighbor,
    "DTW neighbor, direction": partial(learn_nearest_neighbor, direction=True),
}


def method_named(name: str) -> Learn:
    """The learning function of a method.

    Raises
    ------
    UnknownMethodError
        If there is none of that name.
    """
    if name not in METHODS:
        raise UnknownMethodError("method of recognition", name, METHODS)
    return METHODS[name]
