"""The seams of assisted runs in the world: a hand leads, the robot takes over, the hand lets go more or less slowly."""

from __future__ import annotations

from typing import Any

import numpy as np

from pft_exec.execution import ExecutionLog
from pft_exec.execution.log import Stage

ROBOT, TASK = "pr2", "tabletop"
RUNS = 8
"""Of each fade: two people with each motion."""
FADES = (0.0, 0.15, 0.3)
"""s; for which the hand's force fades out."""
PERIOD = 0.001
"""s; control period and physics step."""
SEAM = 0.1
"""s after the take-over that count as its seam: as long as friction feed-forward and damping are blended."""


def assisted_seam_rows(seed: int) -> list[dict[str, Any]]:
    """For each fade, how much the torque of any joint changed from one period to the next at the take-overs, N m."""
    from pft_exec.description import load_task

    labels = load_task(TASK).labels
    rows = []
    for fade in FADES:
        steps = [_torque_step(labels[k % len(labels)], 1000 * seed + 500 + k, fade) for k in range(RUNS)]
        taken = np.array([step for step in steps if step is not None])
        rows.append(
            {
                "fade s": fade,
                "taken over": f"{len(taken)} of {RUNS}",
                "torque step N m, median": float(np.median(taken)) if len(taken) else "-",
                "torque step, largest": float(taken.max()) if len(taken) else "-",
            }
        )
    return rows


def _torque_step(label: str, seed: int, fade: float) -> float | None:
    from pft_exec.evaluation.assisted_rollouts import run_assisted
    from pft_exec.simulation import Mismatch

    return _largest_at_seam(run_assisted(ROBOT, TASK, label, seed, Mismatch(), (), None, PERIOD, let_go=fade))


def _largest_at_seam(log: ExecutionLog) -> float | None:
    """None where nothing was taken over."""
    begins = np.flatnonzero((log.stage[1:] == Stage.TRANSITION) & (log.stage[:-1] == Stage.GUIDED))
    if not len(begins):
        return None
    steps = np.abs(np.diff(log.torque, axis=0)).max(axis=1)
    return float(max(steps[k : k + round(SEAM / PERIOD)].max() for k in begins))
