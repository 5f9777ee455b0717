"""The study: rehearsals over many seeds, and every figure over all of them.

A seed that is done leaves a file; an interrupted study goes on where it stopped.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed

from pft_exec import __version__
from pft_exec.evaluation.figures import figures_to_dict, wilson_interval
from pft_exec.evaluation.measurements import Measurements, figures, joined_measurements, measure
from pft_exec.evaluation.rehearsal import Progress, rehearse
from pft_exec.exceptions import StorageError

SHARES = ("recognized", "success", "asked", "wrong")
"""Measurements that are counted; their Wilson intervals are reported."""


def run_study(
    seeds: Iterable[int],
    out: str | Path,
    *,
    count: int = 5,
    jobs: int = 1,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Rehearse with every seed and write ``report.json`` with the figures over all of them.

    Parameters
    ----------
    seeds : iterable of int
    out : str or Path
        Folder of the report and of a file for each seed; seeds that have one are not repeated.
    count : int
        Demonstrations of each motion.
    jobs : int
        Processes.
    progress : callable or None
        Takes what is done and the share of it.

    Returns
    -------
    dict
        What ``report.json`` holds: ``seeds``, ``figures``, and ``intervals``: the 95 % Wilson interval of each share.

    Raises
    ------
    StorageError
        If a seed's file is damaged or was written by another version.
    """
    out = Path(out)
    out.mkdir(parents=True, exist_ok=True)
    seeds = list(seeds)
    missing = [seed for seed in seeds if not _file(out, seed).exists()]
    done = len(seeds) - len(missing)
    finished = Parallel(n_jobs=jobs, return_as="generator")(
        delayed(_measure_seed)(seed, count, _file(out, seed)) for seed in missing
    )
    for number, seed in enumerate(finished, start=done + 1):
        if progress is not None:
            progress(f"seed {seed} done", number / len(seeds))
    measured = joined_measurements(_load(_file(out, seed)) for seed in seeds)
    report = {
        "seeds": seeds,
        "figures": figures_to_dict(figures(measured)),
        "intervals": _intervals(measured),
    }
    (out / "report.json").write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    return report


def _file(out: Path, seed: int) -> Path:
    return out / f"seed_{seed:04d}.json"


def _measure_seed(seed: int, count: int, path: Path) -> int:
    content = {"version": __version__, "seed": seed, "measurements": measure(rehearse(seed, count=count))}
    beside = path.with_suffix(".partial")
    beside.write_text(json.dumps(content) + "\n", encoding="utf-8")
    beside.replace(path)
    return seed


def _load(path: Path) -> Measurements:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        version, measured = content["version"], content["measurements"]
    except (ValueError, KeyError, TypeError) as error:
        raise StorageError(f"{path} is damaged: it holds no measurements ({error}). Remove it to repeat it.") from error
    if version != __version__:
        raise StorageError(f"{path} was measured by version {version}; this is {__version__}. Use another folder.")
    return {name: [float(value) for value in values] for name, values in measured.items()}


def _intervals(measured: Measurements) -> dict[str, Any]:
    """``{name: {hits, count, low, high}}``, percent."""
    found = {}
    for name, values in measured.items():
        if name == "variables_right" or name.split("_", 1)[-1] in SHARES:
            hits = sum(value > 0.5 for value in values)
            low, high = wilson_interval(hits, len(values))
            found[name] = {"hits": hits, "count": len(values), "low": low, "high": high}
    return found
