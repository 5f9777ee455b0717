"""The online recognizer: which motion is under way, how far it has come, and when it will be done."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.exceptions import RecognitionError, UnknownMethodError, UnknownMotionError
from pft_exec.geometry import Array
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.recognition.belief import Belief, LabelValues
from pft_exec.recognition.dong2012 import IncrementalAlignment
from pft_exec.recognition.phase_filter import PhaseFilter
from pft_exec.recognition.scores import Sample, Scores
from pft_exec.recognition.settings import PhaseSettings

METHODS = ("dong2012", "phase")
_FAR = 1e30  # m: a number from here on is a fault of the sensor, as one that is not finite is


class RecognitionMethod(Protocol):
    """What every method of recognition can do."""

    def update(self, sample: Sample) -> Scores:
        """Take one sample."""

    def scores(self) -> Scores:
        """What the samples so far say."""

    def restart(self) -> None:
        """Forget all samples."""

    def replace(self, tubes: list[FlowTube]) -> None:
        """Go on with other tubes of the same labels in the same order."""


class OnlineRecognizer:
    """Recognize a motion, sample by sample, among the flow tubes of the current scene.

    Parameters
    ----------
    flow_tubes : {label: FlowTube} or iterable of FlowTube
        Made for the current scene and start; all with an orientation, or none.
    method : "phase" or "dong2012"
        The forward filter over phase, or Algorithm 4 of [Dong2012]_.
    prior : {label: weight} or None
        How common each motion is; a label that is not named never comes. None: all alike.
    settings : PhaseSettings or None
        Constants of ``method="phase"``, for research; None: those that were found to serve.

    Raises
    ------
    UnknownMethodError
        If there is no such method.
    UnknownMotionError
        If the prior names a label that no tube has.
    RecognitionError
        If there is no tube, two share a label, some have an orientation and others none, the prior is not one,
        or settings are given to another method than theirs.
    """

    def __init__(
        self,
        flow_tubes: Mapping[str, FlowTube] | Iterable[FlowTube],
        method: str = "phase",
        prior: Mapping[str, float] | None = None,
        *,
        settings: PhaseSettings | None = None,
    ) -> None:
        if method not in METHODS:
            raise UnknownMethodError("recognition method", method, METHODS)
        if settings is not None and method != "phase":
            raise RecognitionError(f"settings are those of method 'phase'; the method is {method!r}.")
        tubes = _labeled(flow_tubes)
        self.method = method
        self.labels = tuple(tubes)
        self._index = {label: place for place, label in enumerate(self.labels)}
        self._log_prior = _log_prior(self.labels, prior)
        self._has_orientation = next(iter(tubes.values())).quaternion is not None
        self._method = _start_method(method, list(tubes.values()), settings)
        self.restart()

    def restart(self) -> None:
        """Forget all samples: the next motion, among the tubes of now, with nothing to compile or to learn anew."""
        self._method.restart()
        self._first: float | None = None
        self._last = -np.inf
        self._belief = self._compute_belief(self._method.scores(), 0.0)

    def update(
        self,
        time: float,
        position: ArrayLike,
        quaternion: ArrayLike | None = None,
        continuous: Mapping[str, float] | None = None,
        discrete: Mapping[str, int] | None = None,
    ) -> Belief:
        """Take one sample and return the belief after it.

        Parameters
        ----------
        time : float, s
            Any clock that goes forward.
        position : (3,), m, world frame
        quaternion : (4,), (x, y, z, w), or None
            None leaves orientation out of this sample's evidence.
        continuous, discrete : {name: value} or None
            Those that all tubes have count.

        Returns
        -------
        Belief
            Unchanged but for `Belief.flagged` where the sample is late, repeated or not finite: it is left out.

        Raises
        ------
        RecognitionError
            If a shape is wrong, or what came is no number.
        """
        now = float(_array("time", time, ()))
        point = _array("position", position, (3,))
        turn = None if quaternion is None else _array("quaternion", quaternion, (4,))
        flag = self._flag(now, point, turn, continuous)
        if flag:
            return replace(self._belief, flagged=flag)
        self._first = now if self._first is None else self._first
        self._last = now
        if turn is not None:
            turn /= math.sqrt(turn @ turn)
        elapsed = self._last - self._first
        scores = self._method.update(Sample(elapsed, point, turn, continuous, discrete))
        self._belief = self._compute_belief(scores, elapsed)
        return self._belief

    def replace(self, flow_tubes: Mapping[str, FlowTube] | Iterable[FlowTube]) -> None:
        """Go on with other tubes of the same labels (an object moved); phase and evidence are kept.

        Raises
        ------
        RecognitionError
            If the labels are others, or some tubes have an orientation and others none.
        """
        tubes = _labeled(flow_tubes)
        if set(tubes) != set(self.labels):
            raise RecognitionError(f"the new tubes must have the labels {sorted(self.labels)}; got {sorted(tubes)}.")
        if (tubes[self.labels[0]].quaternion is not None) != self._has_orientation:
            raise RecognitionError("the new tubes must have an orientation where the old ones have, and only there.")
        self._method.replace([tubes[label] for label in self.labels])

    def _flag(self, time: float, position: Array, turn: Array | None, signals: Mapping[str, float] | None) -> str:
        length = 1.0 if turn is None else math.hypot(*turn.tolist())
        if not (math.isfinite(time) and math.hypot(*position.tolist()) < _FAR and 0.0 < length < _FAR):
            return "not finite"
        if signals and not all(math.isfinite(float(value)) for value in signals.values()):
            return "not finite"
        if time <= self._last:
            return "repeated" if time == self._last else "late"
        return ""

    def _compute_belief(self, scores: Scores, time: float) -> Belief:
        score = scores.log_likelihood + self._log_prior
        best = int(score.argmax())
        weight = np.exp(score - score[best])
        probability = weight / np.add.reduce(weight)
        return Belief(
            label=self.labels[best],
            probability=LabelValues(self._index, probability),
            unknown=min(float(probability @ scores.strangeness), 1.0),
            log_likelihood=LabelValues(self._index, scores.log_likelihood),
            phase=LabelValues(self._index, scores.phase),
            time_to_completion=LabelValues(self._index, scores.time_to_completion),
            time=time,
        )


_METHODS: dict[str, Callable[[list[FlowTube]], RecognitionMethod]] = {
    "dong2012": IncrementalAlignment,
    "phase": PhaseFilter,
}


def _start_method(method: str, tubes: list[FlowTube], settings: PhaseSettings | None) -> RecognitionMethod:
    return _METHODS[method](tubes) if settings is None else PhaseFilter(tubes, settings)


def _labeled(flow_tubes: Mapping[str, FlowTube] | Iterable[FlowTube]) -> dict[str, FlowTube]:
    if not isinstance(flow_tubes, Iterable):
        raise RecognitionError(f"flow tubes come in a mapping or a sequence; got a single {type(flow_tubes).__name__}.")
    tubes = list(flow_tubes.values()) if isinstance(flow_tubes, Mapping) else list(flow_tubes)
    if not tubes:
        raise RecognitionError("at least one flow tube is needed; got none.")
    for tube in tubes:
        if not isinstance(tube, FlowTube):
            raise RecognitionError(f"the recognizer needs flow tubes; got a {type(tube).__name__}.")
    labeled = {tube.label: tube for tube in tubes}
    if len(labeled) < len(tubes):
        raise RecognitionError("each flow tube must have a label of its own.")
    if len({tube.quaternion is None for tube in tubes}) > 1:
        without = sorted(tube.label for tube in tubes if tube.quaternion is None)
        raise RecognitionError(f"either all flow tubes have an orientation or none; {', '.join(without)} have none.")
    return labeled


def _log_prior(labels: tuple[str, ...], prior: Mapping[str, float] | None) -> Array:
    if prior is None:
        return np.zeros(len(labels))
    for name in prior:
        if name not in labels:
            raise UnknownMotionError("motion", name, labels)
    weight = np.array([float(prior.get(label, 0.0)) for label in labels])
    if not np.isfinite(weight).all() or (weight < 0.0).any() or weight.sum() <= 0.0:
        raise RecognitionError(f"a prior must have non-negative weights that do not sum to zero; got {dict(prior)}.")
    with np.errstate(divide="ignore"):
        log_prior: Array = np.log(weight / weight.sum())
    return log_prior


def _array(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise RecognitionError(f"{name} must be numbers of shape {shape}; got {values!r}.") from error
    if array.shape != shape:
        raise RecognitionError(f"{name} must have shape {shape}; got {array.shape}.")
    return array
