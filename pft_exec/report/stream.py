"""Recordings as streams: each is fed to a recognizer sample by sample, as if it were under way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.execution.log import BeliefHistory
from pft_exec.geometry import Array
from pft_exec.learning import MotionLibrary
from pft_exec.recognition import Belief, OnlineRecognizer


@dataclass(frozen=True, eq=False)
class StreamRecognition:
    """What a recognizer thought of one recording.

    Parameters
    ----------
    truth : str
        Label of the recording.
    history : BeliefHistory
        A row per sample; time from the first sample, s.
    """

    truth: str
    history: BeliefHistory

    @cached_property
    def leading(self) -> tuple[str, ...]:
        """(B,): the most probable label after each sample."""
        return tuple(self.history.labels[place] for place in np.argmax(self.history.probability, axis=1))

    @property
    def label(self) -> str:
        """The most probable label after the last sample."""
        return self.leading[-1]

    @property
    def is_right(self) -> bool:
        """Whether that is the label of the recording."""
        return self.label == self.truth

    @property
    def probability(self) -> float:
        """Of `label`, at the end."""
        return float(self.history.probability[-1].max())

    @property
    def unknown(self) -> float:
        """Probability at the end that the motion is none of the library."""
        return float(self.history.unknown[-1])

    @property
    def probability_of_truth(self) -> Array:
        """(B,): of the recording's own label; zeros where the library does not know it."""
        if self.truth not in self.history.labels:
            return np.zeros(len(self.history.time))
        return self.history.probability[:, self.history.labels.index(self.truth)]

    @property
    def decision_time(self) -> float:
        """Time from which the final label has led without a break, s."""
        others = [place for place, label in enumerate(self.leading) if label != self.label]
        return float(self.history.time[others[-1] + 1 if others else 0])

    @property
    def decision_share(self) -> float:
        """`decision_time` as a share of the recording, 0 to 1."""
        return self.decision_time / max(float(self.history.time[-1]), 1e-12)

    @property
    def share_right(self) -> float:
        """Share of the samples after which the right label led."""
        return float(np.mean([label == self.truth for label in self.leading]))


def hold_out(
    demonstrations: Sequence[Demonstration], count: int, seed: int | None = None
) -> tuple[list[Demonstration], list[Demonstration]]:
    """Set `count` demonstrations of each label apart from the rest: the first ones, or drawn with a seed."""
    order = (
        np.arange(len(demonstrations)) if seed is None else np.random.default_rng(seed).permutation(len(demonstrations))
    )
    chosen: set[int] = set()
    for label in {demonstration.label for demonstration in demonstrations}:
        chosen.update([int(place) for place in order if demonstrations[place].label == label][:count])
    kept = [demonstration for place, demonstration in enumerate(demonstrations) if place in chosen]
    return kept, [demonstration for place, demonstration in enumerate(demonstrations) if place not in chosen]


def recognize_stream(library: MotionLibrary, recording: Demonstration, method: str = "phase") -> StreamRecognition:
    """Feed one recording, in the scene and from the start it was made in, to a new recognizer.

    Raises
    ------
    RecognitionError
        If the library has no motion that this scene allows.
    UnknownMethodError
        If the method does not exist.
    """
    recognizer = OnlineRecognizer(library.flow_tubes(recording.scene, recording.start), method)
    beliefs = [recognizer.update(*sample) for sample in _samples(recording)]
    return StreamRecognition(recording.label, _history(recording.time - recording.time[0], beliefs))


def _samples(recording: Demonstration) -> list[tuple[Any, ...]]:
    quaternion = recording.quaternion
    return [
        (
            float(time),
            recording.position[n],
            None if quaternion is None else quaternion[n],
            {name: float(values[n]) for name, values in recording.continuous.items()},
            {name: int(values[n]) for name, values in recording.discrete.items()},
        )
        for n, time in enumerate(recording.time)
    ]


def _history(time: Array, beliefs: Sequence[Belief]) -> BeliefHistory:
    labels = tuple(sorted(beliefs[0].probability))
    return BeliefHistory(
        labels,
        time,
        np.array([[belief.probability[label] for label in labels] for belief in beliefs]),
        np.array([belief.unknown for belief in beliefs]),
    )
