r"""The published recognizer: Algorithm 4 of [Dong2012]_.

Kept as the reference. For each tube the step n* that is nearest to the sample at a plausible time ends a partial tube;
dynamic time warping aligns the samples so far with it, and the mean log likelihood along the warping path, with a prior
that grows with the share of the tube seen, is the score:

.. math:: LL_l = \log\frac{\#_l}{\#} \frac{n^*}{N_l} + \frac{1}{|w|} \sum_j \left(G(w_{j1})
   - \tfrac12 \delta_j^T I(w_{j1}) \delta_j\right)

Readings of what the paper leaves open: position and, where there is one, orientation are compared, time never; the
local cost of the alignment is the distance of line 1, of raw components with the quaternion's sign aligned; delta is
in the tangent; the time density is floored and taken in logarithms; the paper has no hypothesis for unknown motions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pft_exec.exceptions import RecognitionError
from pft_exec.geometry import Array
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.recognition.dong2012_kernel import align_sample
from pft_exec.recognition.scores import Sample, Scores


@dataclass(frozen=True)
class Dong2012Settings:
    """What Algorithm 4 leaves open.

    Parameters
    ----------
    time_floor : float
        Least standard deviation of the time of a step, as a share of the tube's duration (it is 0 at the first step of
        every recording, so that the printed density cannot be evaluated).
    distance_floor : float, m
        Least distance of line 4, so that an exact hit at an impossible time does not win.
    """

    time_floor: float = 0.02
    distance_floor: float = 1e-9


class IncrementalAlignment:
    """Score samples by Algorithm 4; time and memory of a sample do not grow with elapsed time.

    Raises
    ------
    RecognitionError
        If the tubes have an orientation and a sample has none.
    """

    def __init__(self, tubes: Sequence[FlowTube], settings: Dong2012Settings | None = None) -> None:
        self._settings = settings or Dong2012Settings()
        self._adopt(tubes)
        turn = None if tubes[0].quaternion is None else tubes[0].quaternion[0].copy()
        self.update(Sample(0.0, tubes[0].position[0].copy(), turn, None, None))  # compiles before the first sample
        self.restart()

    def _adopt(self, tubes: Sequence[FlowTube]) -> None:
        length = np.array([len(tube) for tube in tubes], dtype=np.int64)
        self._length = length
        self._offset = np.concatenate([[0], np.cumsum(length)[:-1]]).astype(np.int64)
        self._turned = tubes[0].quaternion is not None
        self._mean = np.vstack([tube.position for tube in tubes])
        self._turn = np.vstack([np.zeros((len(t), 4)) if t.quaternion is None else t.quaternion for t in tubes])
        self._precision = np.ascontiguousarray(np.concatenate([tube.precision for tube in tubes]))
        self._normalizer = np.concatenate([tube.log_normalizer for tube in tubes])
        time, deviation = (np.concatenate([f(t) for t in tubes]) for f in (lambda t: t.time, self._floored_deviation))
        self._timing = np.stack([time, deviation, np.log(deviation)])
        self._left = np.concatenate([tube.time[-1] - tube.time for tube in tubes])
        count = np.array([max(tube.count, 1) for tube in tubes], dtype=float)
        self._log_share = np.log(count / count.sum())
        self.restart()

    def restart(self) -> None:
        """Forget all samples."""
        steps = len(self._mean)
        self._cost, self._total, self._steps = np.zeros(steps), np.zeros(steps), np.zeros(steps)
        self._local = np.zeros((4, steps))
        self._match, self._likelihood = np.zeros(len(self._length), np.int64), np.zeros(len(self._length))
        self._first = True

    def _floored_deviation(self, tube: FlowTube) -> Array:
        floor = max(self._settings.time_floor * tube.duration, 1e-9)
        deviation = np.zeros(len(tube)) if tube.time_deviation is None else tube.time_deviation
        floored: Array = np.maximum(deviation, floor)
        return floored

    def update(self, sample: Sample) -> Scores:
        """Take one sample."""
        if self._turned and sample.quaternion is None:
            raise RecognitionError("the flow tubes have an orientation: each sample needs a quaternion; got None.")
        quaternion = np.zeros(4) if sample.quaternion is None else sample.quaternion
        align_sample(
            self._offset, self._length, self._mean, self._turn, self._precision, self._normalizer, self._timing,
            sample.time, self._first, sample.position, quaternion, self._settings.distance_floor,
            self._cost, self._total, self._steps, self._local, self._match, self._likelihood,
        )  # fmt: skip
        self._first = False
        return self.scores()

    def scores(self) -> Scores:
        """What the samples so far say; before the first, the prior alone."""
        prior = self._log_share + np.log((self._match + 1.0) / self._length)  # pi of line 7
        return Scores(
            log_likelihood=prior + self._likelihood,
            phase=self._match / (self._length - 1.0),
            time_to_completion=self._left[self._offset + self._match],
            strangeness=np.zeros(len(self._length)),
        )

    def replace(self, tubes: Sequence[FlowTube]) -> None:
        """Go on with other tubes; the alignment so far is kept, step by step of equal phase."""
        offset, length, first = self._offset, self._length, self._first
        kept = (self._cost, self._total, self._steps)
        match, likelihood = self._match, self._likelihood
        self._adopt(tubes)
        for j, (start, count) in enumerate(zip(self._offset, self._length, strict=True)):
            source = offset[j] + np.rint(np.linspace(0.0, length[j] - 1.0, count)).astype(np.int64)
            for new, old in zip((self._cost, self._total, self._steps), kept, strict=True):
                new[start : start + count] = old[source]
            self._match[j] = round(match[j] / (length[j] - 1) * (count - 1))
        self._likelihood, self._first = likelihood, first
