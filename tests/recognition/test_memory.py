"""What a recognizer holds after a thousand seconds is what it held after twenty."""

import gc
import tracemalloc

import numpy as np
import pytest

from pft_exec.recognition import METHODS, OnlineRecognizer, dong2012_kernel, phase_kernel
from tests.recognition.tubes import line, star, stream

KERNELS = {"dong2012": dong2012_kernel.align_sample, "phase": phase_kernel.filter_sample}


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_memory_is_flat_over_a_hundred_thousand_samples(method):
    """All that Python and numpy hold, without the collector's help after the start: within 2 kB."""
    turn = [0.0, 0.0, 1.0]
    recognizer = OnlineRecognizer([line(str(k), d, steps=10, turn=turn) for k, d in enumerate(np.eye(3)[:2])], method)
    position, quaternion = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
    held = []
    tracemalloc.start()
    for n in range(100_000):
        position[0] = 0.2 + 0.2 * np.sin(0.01 * n)
        recognizer.update(0.01 * n, position, quaternion)
        if n == 2000:
            gc.collect()
            held.append(tracemalloc.get_traced_memory()[0])
    held.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert held[1] - held[0] < 2000


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("turn", [None, [0.0, 0.0, 1.0]])
def test_nothing_is_compiled_after_construction(method, turn):
    """The first sample of a person meets a kernel that is there: whatever arrays and rates come, no new signature."""
    tubes = star(turn=turn)
    recognizer = OnlineRecognizer(tubes, method)
    compiled = len(KERNELS[method].signatures)
    stream(recognizer, tubes[0], until=0.3)
    frozen = tubes[0].position[50]
    assert not frozen.flags.writeable
    recognizer.update(5.0, frozen, None if turn is None else tubes[0].quaternion[50])
    recognizer.update(6, [0, 0, 0], None if turn is None else [0, 0, 0, 2])
    assert len(KERNELS[method].signatures) == compiled
