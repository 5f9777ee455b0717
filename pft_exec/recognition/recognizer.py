"""The online recognizer: which motion is under way, how far it has come, and when it will be done."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.exceptions import RecognitionError, UnknownMethodError
from pft_exec.geometry import Array, relative_rotation_vector
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.recognition.belief import Belief, LabelValues

METHODS = ("dong2012", "phase")


def _labeled(flow_tubes: Mapping[str, FlowTube] | Iterable[FlowTube]) -> dict[str, FlowTube]:
    tubes = list(flow_tubes.values()) if isinstance(flow_tubes, Mapping) else list(flow_tubes)
    if not tubes:
        raise RecognitionError("at least one flow tube is needed; got none.")
    labeled = {tube.label: tube for tube in tubes}
    if len(labeled) < len(tubes):
        raise RecognitionError("each flow tube must have a label of its own.")
    if len({tube.quaternion is None for tube in tubes}) > 1:
        raise RecognitionError("either all flow tubes have an orientation or none has; got both kinds.")
    return labeled


class OnlineRecognizer:
    """Recognize a motion sample by sample among flow tubes of the current scene."""

    def __init__(
        self,
        flow_tubes: Mapping[str, FlowTube] | Iterable[FlowTube],
        method: str = "phase",
        prior: Mapping[str, float] | None = None,
    ) -> None:
        if method not in METHODS:
            raise UnknownMethodError("recognition method", method, METHODS)
        self.method = method
        self._tubes = _labeled(flow_tubes)
        self.labels = tuple(self._tubes)
        self._index = {label: place for place, label in enumerate(self.labels)}
        weight = np.array([1.0 if prior is None else float(prior.get(label, 0.0)) for label in self.labels])
        self._log_prior = np.log(np.maximum(weight / weight.sum(), 1e-300))
        self._filters = [np.full(len(tube), -np.inf) for tube in self._tubes.values()]
        for filtered in self._filters:
            filtered[0] = 0.0
        self._evidence = np.zeros(len(self.labels))
        self._first: float | None = None
        self._last = -np.inf
        self._belief = self._compute_belief(0.0)

    def update(
        self,
        time: float,
        position: ArrayLike,
        quaternion: ArrayLike | None = None,
        continuous: Mapping[str, float] | None = None,
        discrete: Mapping[str, int] | None = None,
    ) -> Belief:
        """Take one sample (s; (3,) m; (4,) x y z w; both world frame) and return the belief after it."""
        del continuous, discrete
        position = np.asarray(position, dtype=float)
        if position.shape != (3,):
            raise RecognitionError(f"position must have shape (3,); got {position.shape}.")
        pose = None if quaternion is None else np.asarray(quaternion, dtype=float)
        if not (np.isfinite(time) and np.isfinite(position).all() and (pose is None or np.isfinite(pose).all())):
            return replace(self._belief, flagged="not finite")
        if time <= self._last:
            return replace(self._belief, flagged="repeated" if time == self._last else "late")
        self._first = time if self._first is None else self._first
        elapsed = 0.0 if self._last == -np.inf else time - self._last
        self._last = time
        for place, tube in enumerate(self._tubes.values()):
            self._advance(place, tube, elapsed, position, pose)
        self._belief = self._compute_belief(float(time - self._first))
        return self._belief

    def replace(self, flow_tubes: Mapping[str, FlowTube] | Iterable[FlowTube]) -> None:
        """Go on with other tubes of the same labels (an object moved); the phase is kept."""
        self._tubes = {label: _labeled(flow_tubes)[label] for label in self.labels}

    def _advance(self, place: int, tube: FlowTube, elapsed: float, position: Array, pose: Array | None) -> None:
        rate = elapsed / max(tube.duration, 1e-9) * (len(tube) - 1)
        reach = int(np.ceil(2.0 * rate)) + 1
        before = np.exp(self._filters[place])
        if elapsed > 0.0:
            weights = np.exp(-0.5 * ((np.arange(reach + 1) - rate) / max(0.5 * rate, 0.5)) ** 2)
            before = np.convolve(before, weights / weights.sum())[: len(tube)]
        difference = position - tube.position
        if pose is not None and tube.quaternion is not None:
            difference = np.hstack([difference, relative_rotation_vector(tube.quaternion, pose)])
        size = difference.shape[1]
        distance = np.einsum("ni,nij,nj->n", difference, tube.precision[:, :size, :size], difference)
        weight = 10.0 * max(elapsed, 1e-3) / max(tube.duration, 1e-9)
        score = weight * (tube.log_normalizer - 3.5 * np.log1p(distance / 4.0))
        with np.errstate(divide="ignore"):
            joint = np.log(before) + score
        top = joint.max()
        total = top + np.log(np.exp(joint - top).sum()) if np.isfinite(top) else -1e3
        self._evidence[place] += total
        if np.isfinite(top):
            self._filters[place] = joint - total

    def _compute_belief(self, time: float) -> Belief:
        score = self._evidence + self._log_prior
        weight = np.exp(score - score.max())
        phase = np.array([
            float(np.exp(filtered) @ tube.phase)
            for filtered, tube in zip(self._filters, self._tubes.values(), strict=True)
        ])  # fmt: skip
        remaining = (1.0 - phase) * np.array([tube.duration for tube in self._tubes.values()])
        return Belief(
            label=self.labels[int(np.argmax(score))],
            probability=LabelValues(self._index, weight / weight.sum()),
            unknown=0.0,
            log_likelihood=LabelValues(self._index, self._evidence.copy()),
            phase=LabelValues(self._index, np.clip(phase, 0.0, 1.0)),
            time_to_completion=LabelValues(self._index, remaining),
            time=time,
        )
