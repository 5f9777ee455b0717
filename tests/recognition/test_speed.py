"""What a sample costs, for ``pytest --benchmark-only``; nothing is asserted of a clock."""

import itertools

import numpy as np
import pytest

from pft_exec.recognition import METHODS, OnlineRecognizer
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
