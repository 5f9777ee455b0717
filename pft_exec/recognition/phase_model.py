"""The model behind ``method="phase"``: the tubes' densities and timing, packed for the kernel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from pft_exec.geometry import Array
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.recognition.emission import Emission, Mask, emission, kept_axes, pooled_prior
from pft_exec.recognition.ending import may_end
from pft_exec.recognition.evidence import TubeEvidence, clock_constants, gather_evidence, measure_scales
from pft_exec.recognition.motion_clock import ClockScales
from pft_exec.recognition.settings import PhaseSettings
from pft_exec.recognition.signals import SignalModel, learn_signals, shared_signals
from pft_exec.recognition.speed import SpeedModel, learn_speed
from pft_exec.recognition.start import StartModel, follow_starts, learn_starts
from pft_exec.recognition.timing import rate_changes, rate_prior, step_probabilities
from pft_exec.recognition.unknown import Strangeness, learn_strangeness

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class PhaseModel:
    """M tubes as J components (the tubes, then their single demonstrations where starts are spread), packed.

    Parameters
    ----------
    tube : (J,)
        Which tube each component belongs to.
    offset, length : (J,)
        Where its steps lie in the packed arrays of S steps, and how many there are.
    mean : (6, S)
        Position (m, world frame) and weighted direction.
    turned : (4, S)
        Mean orientation (x, y, z, w); zeros where there is none.
    white : (18, S)
    gain : (9, S)
        Regression of the direction's residual on the position's.
    log_determinant : (3, S)
    follow : (S,)
        How far the mean leans towards an offset of the first sample.
    starts : StartModel
    speeds : SpeedModel
    left : (S,), s
        From the step to the end.
    clock : (S,), s
        On the motion's clock.
    steps : (J, R, 6)
    prior : (R,)
    change : (J, R, 3)
        Probability that a pace is one's own in the next tick, who has the slower, the same, the faster pace now.
    idle, tick, freedom : (J,)
        Probability of a new pace, and of staying at the start, in one tick (s); degrees of freedom.
    signals : SignalModel
    kept : (3, 3) bool
    strangeness : Strangeness
    """

    labels: tuple[str, ...]
    scales: ClockScales
    constants: Array
    direction_weight: float
    evidence_rate: float
    first_weight: float
    tube: Integers
    offset: Integers
    length: Integers
    mean: Array
    turned: Array
    white: Array
    gain: Array
    log_determinant: Array
    follow: Array
    starts: StartModel
    speeds: SpeedModel
    left: Array
    clock: Array
    steps: Array
    prior: Array
    change: Array
    idle: Array
    tick: Array
    freedom: Array
    signals: SignalModel
    kept: Mask
    strangeness: Strangeness

    @cached_property
    def has_orientation(self) -> bool:
        """Whether the tubes have an orientation."""
        return bool(self.kept[2].any())

    @cached_property
    def last(self) -> Array:
        """(J,): number of the last step of each component."""
        last: Array = self.length.astype(float) - 1.0
        return last

    @cached_property
    def middle(self) -> Array:
        """(J,): where the first step lies, and a half: with it, cutting off rounds."""
        middle: Array = self.offset.astype(float) + 0.5
        return middle

    @cached_property
    def ends(self) -> Array:
        """(J,): time of the last step on the motion's clock, s."""
        return self.tick * self.last

    def size(self, turned: bool, heard: Mask) -> int:
        """Number of components compared."""
        return int(self.kept[:2].sum() + (3 if turned else 0) + heard.sum())

    def log_scale(self, turned: bool, heard: Mask) -> Array:
        """(S,): log normalizer of the Student t of those channels."""
        size = self.size(turned, heard)
        constant = gammaln(0.5 * (self.freedom + size)) - gammaln(0.5 * self.freedom)
        constant -= 0.5 * size * np.log(np.pi * self.freedom)
        blocks = self.log_determinant[: 3 if turned else 2].sum(axis=0)
        signals = np.log(self.signals.scale[heard]).sum(axis=0)
        scale: Array = np.repeat(constant, self.length) - 0.5 * blocks + signals
        return scale


def build_phase_model(tubes: Sequence[FlowTube], settings: PhaseSettings) -> PhaseModel:
    """Learn densities, timing and what is usual from the tubes of a library."""
    continuous, discrete = shared_signals(tubes)
    scales = measure_scales(tubes, continuous)
    evidence = follow_starts([gather_evidence(tube, scales, settings) for tube in tubes], settings)
    turned = tubes[0].quaternion is not None
    kept = kept_axes(evidence, [tube.position for tube in tubes], scales.extent, turned)
    prior = pooled_prior(evidence, kept, scales.extent, settings)
    emissions = [emission(e, prior, m, settings) for m, e in enumerate(evidence)]
    ticks = np.array([max(float(e.clock[-1]), 1e-6) / (len(e.clock) - 1) for e in evidence])
    shifts = _components(tubes, evidence, scales.extent, settings)
    return _pack(
        tubes,
        evidence,
        emissions,
        shifts,
        ticks,
        step_probabilities(evidence, ticks, settings),
        scales=scales,
        settings=settings,
        kept=kept,
        signals=learn_signals(tubes, continuous, discrete, [m for m, _ in shifts], settings),
        strangeness=learn_strangeness(evidence, prior, settings),
    )


def _components(
    tubes: Sequence[FlowTube], evidence: Sequence[TubeEvidence], extent: float, settings: PhaseSettings
) -> list[tuple[int, int]]:
    """Pairs (tube, demonstration); -1 is the mean. Demonstrations join where the library's starts are spread."""
    pairs = [(m, -1) for m in range(len(tubes))]
    spread = [float(np.sqrt((e.position[:, 0] ** 2).sum(axis=-1).mean())) for e in evidence if len(e.position)]
    if len(spread) == len(tubes) and np.median(spread) > settings.spread_start * extent:
        pairs += [(m, k) for m, e in enumerate(evidence) for k in range(len(e.position))]
    return pairs


def _pack(
    tubes: Sequence[FlowTube],
    evidence: Sequence[TubeEvidence],
    emissions: Sequence[Emission],
    pairs: Sequence[tuple[int, int]],
    ticks: Array,
    steps: Array,
    *,
    scales: ClockScales,
    settings: PhaseSettings,
    kept: Mask,
    signals: SignalModel,
    strangeness: Strangeness,
) -> PhaseModel:
    which = np.array([m for m, _ in pairs])
    length = np.array([len(tubes[m]) for m in which])
    narrow = [1.0 if k < 0 else np.sqrt(2.0) for _, k in pairs]
    return PhaseModel(
        labels=tuple(tube.label for tube in tubes),
        scales=scales,
        constants=clock_constants(scales, settings),
        direction_weight=settings.direction_weight * scales.extent,
        evidence_rate=settings.evidence / max(float(np.median([e.clock[-1] for e in evidence])), 1e-6),
        first_weight=settings.first_evidence,
        tube=which,
        offset=np.concatenate([[0], np.cumsum(length)[:-1]]).astype(np.int64),
        length=length.astype(np.int64),
        mean=np.ascontiguousarray(np.vstack([_mean(tubes[m], evidence[m], k) for m, k in pairs]).T),
        turned=_stack([_quaternion(tubes[m]).T for m in which]),
        white=_stack([emissions[m].white * factor for m, factor in zip(which, narrow, strict=True)]),
        gain=_stack([emissions[m].gain for m in which]),
        log_determinant=_stack(
            [
                emissions[m].log_determinant - 2.0 * np.log(factor) * kept.sum(axis=1)[:, None]
                for m, factor in zip(which, narrow, strict=True)
            ]
        ),
        follow=np.concatenate([evidence[m].follow if k < 0 else np.zeros(len(tubes[m])) for m, k in pairs]),
        starts=learn_starts(evidence, which, kept[0], scales.extent, settings),
        speeds=learn_speed(evidence, _endings(tubes, emissions), which, settings),
        left=np.concatenate([tubes[m].time[-1] - tubes[m].time for m in which]),
        clock=np.concatenate([evidence[m].clock for m in which]),
        steps=np.ascontiguousarray(steps[which]),
        prior=rate_prior(settings),
        change=rate_changes(settings, 1.0 - np.exp(-1.0 / (settings.rate_memory * np.maximum(length - 1, 1)))),
        idle=settings.idle ** (200.0 / np.maximum(length, 2)),
        tick=ticks[which],
        freedom=np.array([emissions[m].freedom for m in which]),
        signals=signals,
        kept=kept,
        strangeness=strangeness,
    )


def _endings(tubes: Sequence[FlowTube], emissions: Sequence[Emission]) -> list[Array]:
    return [may_end(tube, item) for tube, item in zip(tubes, emissions, strict=True)]


def _stack(parts: Sequence[Array]) -> Array:
    return np.ascontiguousarray(np.hstack(parts))


def _mean(tube: FlowTube, evidence: TubeEvidence, demonstration: int) -> Array:
    rows = np.hstack([tube.position, evidence.mean_direction])
    if demonstration >= 0:
        rows = rows + np.hstack([evidence.position[demonstration], evidence.direction[demonstration]])
    return rows


def _quaternion(tube: FlowTube) -> Array:
    return np.zeros((len(tube), 4)) if tube.quaternion is None else tube.quaternion
