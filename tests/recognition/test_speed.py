"""What the present speed says; what a sample costs, for ``pytest --benchmark-only``: nothing is asserted of a clock."""

import itertools

import numpy as np
import pytest

from pft_exec.learning.flow_tube import AlignedDemonstrations, FlowTube
from pft_exec.recognition import METHODS, OnlineRecognizer
from pft_exec.recognition.evidence import gather_evidence, measure_scales
from pft_exec.recognition.settings import DEFAULT_SETTINGS
from pft_exec.recognition.speed import learn_speed
from tests.recognition.tubes import line


@pytest.mark.parametrize("method", METHODS)
def test_one_sample_among_twenty_motions_of_two_hundred_steps(method, benchmark):
    """A motion at 100 Hz, pose; every sample is used."""
    ways = np.random.default_rng(0).normal(size=(20, 3))
    tubes = [line(str(k), way, steps=200, turn=[0.0, 0.0, 1.0], seed=k) for k, way in enumerate(ways)]
    recognizer, count = OnlineRecognizer(tubes, method), itertools.count()

    def take_sample():
        n = next(count)
        state = tubes[0].at(min(n / 200, 1.0))
        return recognizer.update(0.01 * n, state.position, state.quaternion)

    belief = benchmark.pedantic(take_sample, rounds=200, warmup_rounds=1)
    assert belief.flagged == ""


def test_a_hand_at_rest_is_usual_where_a_motion_ends_and_nowhere_else_on_the_way():
    """Also where the demonstrations are cut while they still move; each step's density has an area near 1."""
    tubes = [line(str(k), way, seed=k) for k, way in enumerate(np.eye(3)[:2])]
    cut = [_cut(tube, 70) for tube in tubes]
    scales = measure_scales(cut, ())
    evidence = [gather_evidence(tube, scales, DEFAULT_SETTINGS) for tube in cut]
    only_last = [np.append(np.zeros(len(tube) - 1), 1.0) for tube in cut]
    model = learn_speed(evidence, only_last, np.array([0, 1]), DEFAULT_SETTINGS)
    resting = model.at(np.zeros(3)).reshape(2, -1)
    assert (resting[:, -1] > 5.0 * resting[:, 35:-1].max(axis=1)).all()
    assert np.abs(model.density.sum(axis=0) * model.gap - 1.0)[-1] < 0.1


def test_rest_is_as_usual_at_a_step_as_the_motion_may_end_there():
    """Half as likely to end, half as usual to rest."""
    tube = _cut(line("0", [1.0, 0.0, 0.0]), 70)
    evidence = [gather_evidence(tube, measure_scales([tube], ()), DEFAULT_SETTINGS)]
    densities = [
        learn_speed(evidence, [np.full(70, ending)], np.array([0]), DEFAULT_SETTINGS) for ending in (0.0, 0.5, 1.0)
    ]
    resting = [model.at(np.zeros(3))[40:] for model in densities]
    assert (resting[2] > 5.0 * resting[0]).all()
    np.testing.assert_allclose(resting[1], 0.5 * (resting[0] + resting[2]), rtol=1e-9)


def _cut(tube, steps):
    """The tube's first steps."""
    aligned = tube.aligned
    return FlowTube(
        tube.label,
        tube.time[:steps],
        tube.position[:steps],
        None,
        tube.covariance[:steps],
        tube.time_deviation[:steps],
        count=tube.count,
        aligned=AlignedDemonstrations(aligned.position[:, :steps], None, aligned.time[:, :steps]),
    )
