"""Faults: many short rollouts with random faults; what the arm did, and whether it ever did harm."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pft_exec.evaluation.benchmarks.stopwatch import Tables
from pft_exec.evaluation.protocol import Progress

if TYPE_CHECKING:
    from pft_exec.evaluation.rollouts import Rollout

ROLLOUTS = 2000
_END = "}"
"""Of a line that was written to its end."""


def measure_faults(
    seed: int, progress: Progress, count: int = ROLLOUTS, jobs: int = 1, record: str | Path | None = None
) -> Tables:
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
    record : path or None
        File of one line of JSON for each rollout, written as it ends; those that are in it already are not run again.
    """
    from joblib import Parallel, delayed

    from pft_exec.evaluation.rollouts import roll_out

    wanted = range(seed, seed + count)
    rollouts = [rollout for rollout in read_record(record) if rollout.seed in wanted]
    known = {rollout.seed for rollout in rollouts}
    finished = Parallel(n_jobs=jobs, return_as="generator")(delayed(roll_out)(k) for k in wanted if k not in known)
    for number, rollout in enumerate(finished, start=len(known) + 1):
        rollouts.append(rollout)
        _write(rollout, record)
        progress(f"rollout {number} of {count}", number / count)
    return tables_of(rollouts)


def read_record(record: str | Path | None) -> list[Rollout]:
    """The rollouts of a record; none where there is no such file yet. A line cut off by an interruption is left out."""
    from pft_exec.evaluation.rollouts import Rollout

    if record is None or not Path(record).exists():
        return []
    lines = Path(record).read_text(encoding="utf-8").splitlines()
    return [Rollout.from_dict(json.loads(line)) for line in lines if line.endswith(_END)]


def _write(rollout: Rollout, record: str | Path | None) -> None:
    if record is not None:
        with Path(record).open("a", encoding="utf-8") as file:
            file.write(f"\n{json.dumps(rollout.to_dict())}")  # the break comes first: a line cut off spoils no other


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
        "nearest end stop rad, pushes too": -max((rollout.beyond for rollout in rollouts), default=0.0),
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
