"""Benchmarks: how fast the parts are, with the alternatives in the same run, and how they grow.

In the flow: beside the comparisons of `evaluation`, for the eyes of a user. Each part has a file of its own here; its
function takes a seed and a progress callable and answers with tables. `BENCHMARKS` lists them by name.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pft_exec.evaluation.benchmarks.compliance import measure_compliance
from pft_exec.evaluation.benchmarks.control import time_control
from pft_exec.evaluation.benchmarks.faults import ROLLOUTS, measure_faults
from pft_exec.evaluation.benchmarks.handoff import measure_handoff
from pft_exec.evaluation.benchmarks.learning import time_learning
from pft_exec.evaluation.benchmarks.obstacle import measure_obstacle
from pft_exec.evaluation.benchmarks.people import synthetic_demonstrations
from pft_exec.evaluation.benchmarks.recognition import time_recognition
from pft_exec.evaluation.benchmarks.stopwatch import Benchmark
from pft_exec.evaluation.protocol import Progress, silent
from pft_exec.exceptions import UnknownNameError

__all__ = ["BENCHMARKS", "benchmark", "synthetic_demonstrations"]

BENCHMARKS: dict[str, Benchmark] = {
    "compliance": measure_compliance,
    "control": time_control,
    "faults": measure_faults,
    "handoff": measure_handoff,
    "learning": time_learning,
    "obstacle": measure_obstacle,
    "recognition": time_recognition,
}


def benchmark(
    name: str,
    seed: int = 0,
    progress: Progress = silent,
    *,
    count: int | None = None,
    jobs: int = 1,
    record: str | Path | None = None,
) -> dict[str, Any]:
    """Time one part.

    Parameters
    ----------
    name : str
        One of `BENCHMARKS`.
    seed : int
        Of all that is drawn at random.
    progress : callable
        Takes the stage and the share that is done, in [0, 1].
    count : int or None
        Of rollouts; only "faults" has any.
    jobs : int
        Processes of the rollouts.
    record : path or None
        File of the rollouts, written as they end; a run that was interrupted goes on from it.

    Returns
    -------
    dict
        "tables": {title: rows}.

    Raises
    ------
    UnknownNameError
        If there is no such benchmark.
    """
    if name not in BENCHMARKS:
        raise UnknownNameError("benchmark", name, BENCHMARKS)
    if name == "faults":
        return {"tables": measure_faults(seed, progress, count or ROLLOUTS, jobs, record)}
    return {"tables": BENCHMARKS[name](seed, progress)}
