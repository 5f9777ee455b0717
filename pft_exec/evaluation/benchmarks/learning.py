"""How long it takes to learn one motion, and to make the tubes of a new scene."""

from __future__ import annotations

from typing import Any

from pft_exec.demonstration import Scene
from pft_exec.evaluation.benchmarks.people import synthetic_demonstrations
from pft_exec.evaluation.benchmarks.stopwatch import Tables, milliseconds
from pft_exec.evaluation.protocol import Progress
from pft_exec.learning import learn_library, learn_motion


def time_learning(seed: int, progress: Progress) -> Tables:
    """Learning by demonstrations and samples, and the tubes of a scene by method."""
    sizes = ((5, 100), (5, 1000), (5, 10_000), (5, 100_000), (20, 100), (80, 100))
    rows = []
    for place, (count, samples) in enumerate(sizes):
        progress(f"learning from {count} x {samples} samples", place / 8.0)
        rows.append(_learning_row(count, samples, seed))
    return {
        "learning one motion, pose (paper: 900 to 1300 ms)": rows,
        "tubes for a new scene, 20 motions x 5 demonstrations": [
            _library_row(method, seed, progress) for method in ("robust", "dong2012")
        ],
    }


def _learning_row(count: int, samples: int, seed: int) -> dict[str, Any]:
    demonstrations = synthetic_demonstrations(1, seed, count, samples)
    start, scene = demonstrations[0].start, Scene()
    motion = learn_motion(demonstrations)
    return {
        "demonstrations": count,
        "samples": samples,
        "learn ms": milliseconds(lambda: learn_motion(demonstrations)),
        "with first tube ms": milliseconds(lambda: learn_motion(demonstrations).flow_tube(scene, start)),
        "further tube ms": milliseconds(lambda: motion.flow_tube(scene, start)),
    }


def _library_row(method: str, seed: int, progress: Progress) -> dict[str, Any]:
    progress(f"tubes of 20 motions, {method}", 0.8)
    demonstrations = synthetic_demonstrations(20, seed, samples=100)
    library = learn_library(demonstrations, method=method)
    library.flow_tubes(Scene(), demonstrations[0].start)
    total = milliseconds(lambda: library.flow_tubes(Scene(), demonstrations[-1].start))
    return {"method": method, "ms a motion": total / 20.0}
