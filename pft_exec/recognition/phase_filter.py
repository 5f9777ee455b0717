"""The forward filter over the phase of every tube: ``method="phase"``.

In the flow: holds what changes with each sample. State: for each tube a distribution over (pace, phase); for the stream
the motion's clock and the last direction. Time and memory of a sample do not grow with elapsed time.

How far a hand is beside a tube changes slowly: such a residual r is much like an Ornstein-Uhlenbeck process of a
correlation time c, and the quadratic form of its log density over a time T is

    (r(0)^2 + r(T)^2) / 2 + 1 / (2 c) (integral of r^2 dt) + c / 2 (integral of r'^2 dt).

The integral of r^2 is the filter's evidence, 1 / (2 c) being `PhaseSettings.evidence` a motion; that of r'^2 is for the
direction to say. What the sum over samples leaves out is the boundary: the present sample counts about half an
observation of its own. It does not add up; each sample makes it anew. Left out, a hand that has just gone another way
is believed on the old one for as long as the sum remembers. At the other boundary every tube is where the hand is, so
that the present counts the less, the less was seen since. The present speed belongs to the same observation (see
`speed`): place and speed must suit one phase together, so that a hand which has stopped at a motion's end is not asked
how usual a rest is at the phases where a tube of another tempo would be by now.

A person's tempo, how fast they are beside the tubes, is their own: it is estimated on the way, from the time that the
likely motions would have taken to where they are. The direction of motion is taken over a window, and evidence is
counted, in the tubes' own time, so that a slow hand neither seems to head nowhere nor counts for more than a quick one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pft_exec.geometry import Array
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.recognition.motion_clock import MotionClock
from pft_exec.recognition.phase_kernel import REACH, ROWS, filter_sample
from pft_exec.recognition.phase_model import PhaseModel, build_phase_model
from pft_exec.recognition.scores import Sample, Scores
from pft_exec.recognition.settings import DEFAULT_SETTINGS, PhaseSettings

_REMEMBERED = 16  # combinations of channels whose normalizers are kept


class PhaseFilter:
    """Filter samples through the tubes of a library."""

    def __init__(self, tubes: Sequence[FlowTube], settings: PhaseSettings = DEFAULT_SETTINGS) -> None:
        self._settings = settings
        self.model = build_phase_model(tubes, settings)
        self.restart()
        self._warm_up()
        self.restart()

    def restart(self) -> None:
        """Forget all samples."""
        model = self.model
        self._adopt(model)
        self._clock = MotionClock(model.constants, 7 + len(model.scales.signals))
        self._tempo = 1.0
        self._evidence = np.zeros(len(model.tube))
        self._distance = np.zeros(len(model.labels))
        self._far = np.zeros(len(model.labels))
        self._weight = self._watched = 0.0
        self._state[:, model.offset] = model.prior[:, None]

    def _adopt(self, model: PhaseModel) -> None:
        """Make room for a model's states; nothing is in them yet."""
        steps, rates, components = len(model.left), len(model.prior), len(model.tube)
        self.model = model
        self._state = np.zeros((rates, steps))
        self._spare = np.zeros((ROWS, int(model.length.max()) + 2 * REACH))
        self._zeros = np.zeros(steps)
        self._lean(np.zeros((components, 3)))
        self._pending = np.zeros(components)
        self._low, self._high = np.zeros(components, np.int64), np.zeros(components, np.int64)
        self._out = np.zeros((5, components))
        self._comparisons: dict[tuple[bool, bytes], tuple[Array, int]] = {}
        self._quaternion = np.zeros(4)
        self._sample = np.zeros(10)
        self._per_unit = model.scales.per_unit()
        self._point = np.zeros(len(self._per_unit))

    def _warm_up(self) -> None:
        """Compile and load everything, so that the first sample of a person takes no longer than the others."""
        position = np.ascontiguousarray(self.model.mean[:3, 0])
        turn = np.array([0.0, 0.0, 0.0, 1.0]) if self.model.has_orientation else None
        for time in (0.0, 0.5 * float(self.model.tick.min()), 4.0 * float(self.model.tick.max())):
            self.update(Sample(time, position, turn, None, None))

    def update(self, sample: Sample) -> Scores:
        """Take one sample."""
        model = self.model
        signals, heard = model.signals.read(sample.continuous)
        turned = sample.quaternion is not None and model.has_orientation
        elapsed = self._clock.advance(sample.time, sample.position, self._scaled(sample, signals), self._tempo)
        weight, watched = model.first_weight, model.first_weight
        if self._weight > 0.0:
            watched = min(model.evidence_rate * elapsed, 1.0)
            weight = min(self._tempo * watched, 1.0)
        if self._weight == 0.0:
            self._begin_at(sample.position)
        self._weight += weight
        said = model.signals.log_discrete(sample.discrete, self._zeros)
        log_scale, size = self._comparison(turned, heard)
        row = self._sample
        row[:3], row[3:6] = sample.position, model.direction_weight * self._clock.heading
        row[6:] = self._quaternion if turned else 0.0
        filter_sample(
            model.offset, model.length, self._mean, model.white, model.gain, model.turned, model.left,
            model.signals.mean, model.signals.scale, model.steps, model.change, model.idle, model.tick,
            row, signals, heard, log_scale, said, model.speeds.at(self._clock.direction), size, model.freedom, elapsed,
            weight, self._settings.negligible, self._settings.placing, self._worth_of_present(),
            self._state, self._spare, self._pending, self._low, self._high, self._out,
        )  # fmt: skip
        self._evidence += self._out[0]
        self._far = self._out[3, : len(model.labels)] / size
        self._watched += watched
        self._distance += watched * self._far
        scores = self.scores()
        self._tempo = self._tempo_of(scores)
        return scores

    def _begin_at(self, position: Array) -> None:
        """Judge the first place of a stream, and lean towards it."""
        model = self.model
        said, offset = model.starts.judge(position - model.mean[:3, model.offset].T)
        self._evidence += said
        self._lean(offset)

    def _lean(self, offset: Array) -> None:
        """Move the means by what is left, at each step, of an offset (J, 3), m, at the start."""
        model = self.model
        self._offset, self._mean = offset, model.mean.copy()
        self._mean[:3] += model.follow * np.repeat(offset.T, model.length, axis=1)

    def _scaled(self, sample: Sample, signals: Array) -> Array:
        """The point whose movement the motion's clock looks at: all components, each in its own extent."""
        point, turn = self._point, sample.quaternion
        if turn is not None:
            self._quaternion = -turn if turn @ self._quaternion < 0.0 else turn
        point[:3], point[3:7], point[7:] = sample.position, self._quaternion, signals
        point *= self._per_unit
        return point

    def _comparison(self, turned: bool, heard: NDArray[np.bool_]) -> tuple[Array, int]:
        """Log normalizer (S,) of the channels that came, and the number of their components."""
        key = (turned, heard.tobytes())
        if key not in self._comparisons:
            if len(self._comparisons) == _REMEMBERED:
                self._comparisons.clear()
            self._comparisons[key] = self.model.log_scale(turned, heard), self.model.size(turned, heard)
        return self._comparisons[key]

    def scores(self) -> Scores:
        """What the samples so far say."""
        model, count = self.model, len(self.model.labels)
        evidence = self._evidence + self._out[4]
        likelihood = evidence[:count]
        if len(evidence) > count:
            likelihood = 0.5 * likelihood + 0.5 * self._mixture(evidence)
        phase = self._out[1, :count].copy()
        return Scores(
            likelihood,
            phase,
            self._out[2, :count] / self._pace(phase),
            model.strangeness.probability(self._distance, self._watched, self._far),
        )

    def _worth_of_present(self) -> float:
        """Independent observations that the present sample counts for, beside its share of the motion's."""
        most, seen = self._settings.present, self._weight
        return most * seen / (most + seen) if seen > 0.0 else 0.0

    def _mixture(self, evidence: Array) -> Array:
        """(M,): log of the mean likelihood over the demonstrations of each tube."""
        count = len(self.model.labels)
        owner, values = self.model.tube[count:], evidence[count:]
        top = np.full(count, -np.inf)
        np.maximum.at(top, owner, values)
        total = np.bincount(owner, np.exp(values - top[owner]), count)
        mixture: Array = top + np.log(total / np.bincount(owner, minlength=count))
        return mixture

    def _pace(self, phase: Array) -> Array:
        """(M,): how fast the person is beside each tube, held to 1 at first."""
        model, count = self.model, len(phase)
        place = (phase * model.last[:count] + model.middle[:count]).astype(np.int64)
        held = self._settings.tempo_held * model.ends[:count]
        pace: Array = (model.clock[place] + held) / (self._clock.clock + held)
        return pace

    def _tempo_of(self, scores: Scores) -> float:
        """How fast the person is beside the likely tubes, in the geometric mean; no faster or slower than anybody."""
        share = np.exp(scores.log_likelihood - scores.log_likelihood.max())
        tempo = float(np.exp(share @ np.log(self._pace(scores.phase)) / share.sum()))
        return min(max(tempo, self._settings.rates[0]), self._settings.rates[-1])

    def replace(self, tubes: Sequence[FlowTube]) -> None:
        """Go on with other tubes; each filter keeps its distribution over pace and phase, and its evidence."""
        before, state, low, high = self.model, self._state, self._low, self._high
        evidence, pending, offset, said = self._evidence, self._pending, self._offset, self._out[4]
        self._adopt(build_phase_model(tubes, self._settings))
        self._evidence, sources = np.zeros(len(self.model.tube)), []
        for j, (m, first, length) in enumerate(zip(self.model.tube, self.model.offset, self.model.length, strict=True)):
            source = j if len(before.tube) == len(self.model.tube) else int(m)
            old = state[:, before.offset[source] : before.offset[source] + before.length[source]]
            new = self._state[:, first : first + length]
            places = np.rint(np.linspace(0.0, length - 1, old.shape[1])).astype(int)
            for r in range(len(new)):
                new[r] = np.bincount(places, old[r], int(length))
            self._low[j], self._high[j] = places[low[source]], places[high[source]]
            self._pending[j], self._evidence[j] = pending[source], evidence[source]
            self._out[4, j] = said[source]
            sources.append(source)
            mass = new.sum(axis=0)
            self._out[1, j] = np.arange(length) @ mass / max(int(length) - 1, 1)
            self._out[2, j] = self.model.left[first : first + length] @ mass
        self._lean(offset[sources])
