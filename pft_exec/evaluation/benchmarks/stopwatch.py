"""How long work takes, and what of memory it keeps."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from pft_exec.evaluation.protocol import Progress

Tables = dict[str, Sequence[Mapping[str, Any]]]
Benchmark = Callable[[int, Progress], Tables]


def milliseconds(work: Callable[[], Any], repeats: int = 3) -> float:
    """Median of some runs, ms, after one that warms up."""
    work()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return 1e3 * float(np.median(times))
