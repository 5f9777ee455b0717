"""Faults: many short rollouts with random faults; what the arm did, and whether it ever did harm."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pft_exec.evaluation.benchmarks.stopwatch import Tables
from pft_exec.evaluation.protocol import Progress

if TYPE_CHECKING:
    from pft_exec.evaluation.rollouts import Rollout

ROLLOUTS = 2000


def measure_faults(seed: int, progress: Progress, count: int = ROLLOUTS, jobs: int = 1) -> Tables:
    """Rollouts with random faults, PR2 and WAM: no limit exceeded, no NaN, no exception, a reason for every stop.

    Parameters
    ----------
    seed : int
        Of the first rollout; the next has the next number, and `count=1` repeats any of them.
    progress : callable
    count : int
        Number of rollouts.
    jobs : int
        Processes.
    """
    from joblib import Parallel, delayed

    from pft_exec.evaluation.rollouts import roll_out

    finished = Parallel(n_jobs=jobs, return_as="generator")(delayed(roll_out)(seed + k) for k in range(count))
    rollouts = []
    for number, rollout in enumerate(finished, start=1):
        rollouts.append(rollout)
        progress(f"rollout {number} of {count}", number / count)
    return tables_of(rollouts)


def tables_of(rollouts: Sequence[Rollout]) -> Tables:
    """Tables of what became of rollouts: by fault, by rule, by reason of stopping, and each that broke a rule."""
    kinds = sorted({kind for rollout in rollouts for kind in rollout.faults})
    broken = [rollout for rollout in rollouts if rollout.broken_rules]
    return {
        "rollouts by fault": [_row(kind, [r for r in rollouts if kind in r.faults]) for kind in kinds]
        + [_row("all", list(rollouts))],
        "what must never happen (floor: 0)": [_rules(rollouts)],
        "why they stopped": _reasons(rollouts),
        "rollouts that broke a rule": [
            {"seed": r.seed, "faults": ", ".join(r.faults), "rules": ", ".join(r.broken_rules), "reason": r.reason}
            for r in broken
        ],
    }


def _row(kind: str, rollouts: list[Rollout]) -> dict[str, Any]:
    endings = Counter(rollout.ending for rollout in rollouts)
    done = [rollout for rollout in rollouts if rollout.ending == "finished"]
    went = Counter(rollout.went for rollout in done)
    errors = [1e3 * rollout.end_error for rollout in done]
    return {
        "fault": kind,
        "rollouts": len(rollouts),
        "went on": went["on"],
        "slowed down": went["slower"],
        "gave way": went["aside"],
        "stopped": endings["stopped"],
        "did not begin": endings["refused"],
        "worst torque share": max((rollout.torque for rollout in rollouts), default=0.0),
        "worst velocity share, pushes too": max((rollout.velocity for rollout in rollouts), default=0.0),
        "by the controller": max((rollout.driven for rollout in rollouts), default=0.0),
        "nearest limit rad": -max((rollout.beyond for rollout in rollouts), default=0.0),
        "end error mm (median)": float(np.median(errors)) if errors else float("nan"),
    }


def _rules(rollouts: Sequence[Rollout]) -> dict[str, Any]:
    count = Counter(rule for rollout in rollouts for rule in rollout.broken_rules)
    names = {
        "torque": "torque beyond limit",
        "velocity": "velocity beyond limit",
        "position": "position beyond limit",
        "finite": "not a number",
        "exception": "exception",
        "reason": "stop without a reason",
    }
    return {"rollouts": len(rollouts)} | {title: count[name] for name, title in names.items()}


def _reasons(rollouts: Sequence[Rollout]) -> list[dict[str, Any]]:
    """How often each reason was given; numbers in it left out."""
    plain = Counter(_without_numbers(r.reason) for r in rollouts if r.ending != "finished")
    return [{"reason": reason, "rollouts": number} for reason, number in plain.most_common()]


def _without_numbers(reason: str) -> str:
    import re

    return re.sub(r"-?\d+(\.\d+)?", "#", reason)
