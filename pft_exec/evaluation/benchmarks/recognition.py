"""How long a sample takes to recognize, beside the alternatives, and how that and the memory grow."""

from __future__ import annotations

import time
import tracemalloc
from typing import Any

import numpy as np

from pft_exec.evaluation.baselines.nearest_neighbor import warped_distance
from pft_exec.evaluation.benchmarks.people import synthetic_demonstrations
from pft_exec.evaluation.benchmarks.stopwatch import Tables, milliseconds
from pft_exec.evaluation.extras import check_baselines
from pft_exec.evaluation.protocol import Progress
from pft_exec.geometry import Array
from pft_exec.learning import FlowTube
from pft_exec.learning.flow_tube import AlignedDemonstrations
from pft_exec.recognition import OnlineRecognizer

_PERIOD = 0.01  # s


def time_recognition(seed: int, progress: Progress) -> Tables:
    """One sample by motions, steps and elapsed time, and what it costs where everything is computed anew."""
    check_baselines()
    rows = []
    for place, (motions, steps, seconds) in enumerate(((20, 200, 2), (20, 200, 40), (20, 1000, 2), (100, 200, 2))):
        progress(f"recognizing among {motions} motions", place / 6.0)
        rows.append(_stream_row("phase", motions, steps, seconds, seed))
    progress("a mixture over demonstrations", 0.7)
    rows.append(_stream_row("phase", 20, 200, 2, seed, spread=0.2) | {"method": "phase, 5 starts each"})
    progress("dong2012", 0.75)
    rows.append(_stream_row("dong2012", 20, 200, 2, seed))
    progress("1 000 motions", 0.8)
    rows.append(_stream_row("phase", 1000, 200, 1, seed))
    return {
        "one sample, pose (paper: 4 to 35 ms for 3 to 7 motions)": rows,
        "alternatives, 20 motions, the last of 200 samples": _alternatives(seed),
    }


def _tubes(motions: int, steps: int, seed: int, spread: float = 0.0) -> list[FlowTube]:
    """Tubes of so many steps, each of five demonstrations; `spread` (m) is the deviation of their starts."""
    demonstrations = synthetic_demonstrations(min(motions, 20), seed, samples=steps)
    rng = np.random.default_rng([seed, 7])
    tubes = []
    for motion in range(motions):
        group = demonstrations[5 * (motion % 20) : 5 * (motion % 20) + 5]
        turn = group[0].quaternion
        turns = np.tile(np.asarray(turn), (5, 1, 1))
        position = np.stack([item.position for item in group]) + spread * rng.standard_normal((5, 1, 3))
        aligned = AlignedDemonstrations(position, turns, np.stack([item.time for item in group]))
        covariance = np.tile(np.diag([1e-4] * 3 + [1e-3] * 3), (steps, 1, 1))
        mean = position.mean(axis=0)
        tubes.append(FlowTube(f"motion {motion}", group[0].time, mean, turn, covariance, count=5, aligned=aligned))
    return tubes


def _stream_row(method: str, motions: int, steps: int, seconds: int, seed: int, spread: float = 0.0) -> dict[str, Any]:
    """Times and memory of a stream at 100 Hz that makes a motion and then rests.

    Beside the time on the clock stands that of the processor: where others run, only the latter is the recognizer's.
    """
    samples, tubes = _stream(seconds, seed), _tubes(motions, steps, seed, spread)
    recognizer = OnlineRecognizer(tubes, method=method)
    times, processor = np.empty(len(samples)), np.empty(len(samples))
    for t, (clock, position, quaternion) in enumerate(samples):
        begin, busy = time.perf_counter(), time.thread_time()
        recognizer.update(clock, position, quaternion)
        times[t], processor[t] = time.perf_counter() - begin, time.thread_time() - busy
    return {
        "method": method,
        "motions": motions,
        "steps": steps,
        "elapsed s": seconds,
        "median us": 1e6 * float(np.median(times)),
        "p99 us": 1e6 * float(np.percentile(times, 99)),
        "processor p99 us": 1e6 * float(np.percentile(processor, 99)),
        "first ms": 1e3 * float(times[0]),
        "kB growth": _growth(OnlineRecognizer(tubes, method=method), samples),
    }


def _stream(seconds: int, seed: int) -> list[tuple[float, Array, Array]]:
    """Time (s), position (3,) and orientation (4,), (x, y, z, w), of each sample."""
    recording = synthetic_demonstrations(1, seed, 1)[0]
    clock = _PERIOD * np.arange(100 * seconds)
    position = np.stack([np.interp(clock, recording.time, recording.position[:, i]) for i in range(3)], axis=1)
    place = np.minimum(np.searchsorted(recording.time, clock), len(recording) - 1)
    turn = np.asarray(recording.quaternion)[place]
    return [(float(t), p, q) for t, p, q in zip(clock, position, turn, strict=True)]


def _growth(recognizer: OnlineRecognizer, samples: list[tuple[float, Array, Array]]) -> float:
    """Memory, kB, that the recognizer holds at the end and did not hold after a quarter of the stream."""
    tracemalloc.start()
    for sample in samples[: len(samples) // 4]:
        recognizer.update(*sample)
    before = tracemalloc.get_traced_memory()[0]
    for sample in samples[len(samples) // 4 :]:
        recognizer.update(*sample)
    after = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    return (after - before) / 1e3


def _alternatives(seed: int) -> list[dict[str, Any]]:
    """What one sample costs where everything is computed anew."""
    from pft_exec.evaluation.baselines.hmm import learn_hmm

    demonstrations = synthetic_demonstrations(20, seed, pose=False)
    recording = demonstrations[0]
    references: list[Array] = [item.position for item in demonstrations[::5]]
    classifier = learn_hmm(demonstrations)
    return [
        {
            "alternative": "DTW to each mean, all of it recomputed",
            "ms a sample": milliseconds(lambda: [warped_distance(r, recording.position) for r in references]),
        },
        {
            "alternative": "hidden Markov models, all of it scored again",
            "ms a sample": milliseconds(lambda: classifier.recognize(recording)),
        },
    ]
