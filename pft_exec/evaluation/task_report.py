"""The report of a task's study: figures beside their floors, a row for each motion, failures, and contact sheets."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pft_exec.evaluation.figures import Figure, figures_to_dict, share, wilson_interval, worst
from pft_exec.evaluation.task_rollouts import DRAWN, MIRRORED, RolloutResult
from pft_exec.report import page
from pft_exec.report.contact_sheet import Tile, write_contact_sheet

OVERALL, LEAST = 95.0, 85.0  # %, of the rollouts of an arm, and of its worst motion
APART = 3.0  # points between the arms
LEARNING = 30.0  # ms
POURED = 95.0  # %, in the mean over successful pours
SLIP = 2.0  # mm
SLIP_DETAIL, POURED_DETAIL = "slip", "poured"  # names of a run's details, where its task has them


def write_report(
    out: Path,
    about: Mapping[str, Any],
    results: Sequence[RolloutResult],
    relevance: Mapping[str, Sequence[bool]],
    learning: Mapping[str, float],
) -> dict[str, Any]:
    """Write ``report.json``, ``report.html`` and a contact sheet for each arm into a folder; return the former.

    Parameters
    ----------
    out : Path
    about : {name: value}
        Settings.
    results : sequence of RolloutResult
    relevance : {label: (S,) bool}
        Whether the motion variables were right, by seed; empty where that was not asked.
    learning : {label: float}, ms
    """
    report: dict[str, Any] = {
        "settings": dict(about),
        "figures": figures_to_dict(figures(results, relevance, learning)),
        "motions": motion_rows(results),
        "variables": relevance_rows(relevance),
        "learning_ms": dict(learning),
        "failures": failure_rows(results),
        "rollouts": [item.to_dict() for item in results],
    }
    sheets = {arm: _sheet(out, results, arm) for arm in dict.fromkeys(item.arm for item in results)}
    parts = [
        page.table([{"figure": name, **figure} for name, figure in report["figures"].items()], "figures"),
        page.table(report["motions"], "motions, with 95 % Wilson intervals"),
        page.table(report["variables"], "motion variables over seeds"),
        page.table(report["failures"], "failures"),
        *(_sheet_section(arm, path) for arm, path in sheets.items()),
    ]
    page.write_page(out / "report.html", f"{about['task']} on {about['robot']}", parts)
    (out / "report.json").write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    return report


def _sheet_section(arm: str, sheet: Path) -> str:
    name = arm if arm.endswith("arm") else f"{arm} arm"
    caption = "Each picture is the end of a rollout, with the scene's number; green: success, orange: failure."
    return page.section(
        page.heading(f"How the rollouts of the {name} ended"),
        page.paragraph(caption),
        page.image(sheet, f"ends of the rollouts of the {name}"),
    )


def figures(
    results: Sequence[RolloutResult], relevance: Mapping[str, Sequence[bool]], learning: Mapping[str, float]
) -> dict[str, Figure]:
    """Every figure that a task is held to."""
    found: dict[str, Figure] = {}
    groups = _grouped(results)
    for arm, kind in groups:
        found |= {f"{arm}, {kind}: {name}": figure for name, figure in _success(groups[arm, kind]).items()}
    overall = {key: share([item.success for item in group]) for key, group in groups.items()}
    (first, reference), *others = overall.items() if overall else [(("", ""), float("nan"))]
    for (arm, kind), value in others:
        name = f"{arm}, {kind}: points behind {first[0]}"
        found[name] = Figure(reference - value, APART, "points")
    found |= _physics(results)
    if relevance:
        seeds = np.all([list(values) for values in relevance.values()], axis=0)
        name = f"seeds with the variables of all {len(relevance)} motions right"
        found[name] = Figure(share(seeds.tolist()), 95.0, "%", "at least")
    if learning:
        found["learning one motion, 5 x 100 samples, median"] = Figure(
            float(np.median(list(learning.values()))), LEARNING, "ms"
        )
    return found


def _success(group: Sequence[RolloutResult]) -> dict[str, Figure]:
    by_label = _by_label(group)
    shares = {label: share([item.success for item in items]) for label, items in by_label.items()}
    least = min(shares, key=lambda label: shares[label])
    return {
        "success": Figure(share([item.success for item in group]), OVERALL, "%", "at least"),
        f"worst motion ({least})": Figure(shares[least], LEAST, "%", "at least"),
    }


def _physics(results: Sequence[RolloutResult]) -> dict[str, Figure]:
    found = {
        "torque beyond its limit": Figure(worst(_values(results, "torque_beyond")), 1e-9, "N m"),
        "position beyond its limit": Figure(worst(_values(results, "position_beyond")), 0.0, "rad"),
        "velocity beyond its limit": Figure(worst(_values(results, "velocity_beyond")), 0.0, "rad/s"),
    }
    poured = _values([item for item in results if item.success], POURED_DETAIL)
    if poured:
        found["spheres in the cup, mean over successful pours"] = Figure(
            100.0 * float(np.mean(poured)), POURED, "%", "at least"
        )
    slips = _values(results, SLIP_DETAIL)
    if slips:
        found["slip in the gripper, worst"] = Figure(1e3 * worst(slips), SLIP, "mm")
    return found


def motion_rows(results: Sequence[RolloutResult]) -> list[dict[str, Any]]:
    """A row for each arm, kind of scene and motion."""
    rows = []
    for (arm, kind), group in _grouped(results).items():
        for label, items in [*_by_label(group).items(), ("all", list(group))]:
            hits = sum(item.success for item in items)
            low, high = wilson_interval(hits, len(items))
            rows.append(
                {
                    "arm": arm,
                    "scenes": kind,
                    "motion": label,
                    "success": f"{hits} of {len(items)}",
                    "%": 100.0 * hits / len(items),
                    "interval": f"{low:.0f} to {high:.0f}",
                    "refused": sum(item.refused for item in items),
                    "end error mm, median": _of(np.median, items, "end_position_error", 1e3),
                    "end error mm, worst": _of(np.max, items, "end_position_error", 1e3),
                    "from the tube mm, rms": _of(np.median, items, "tube_rms", 1e3),
                    "worst": _of(np.max, items, "tube_largest", 1e3),
                    "sigmas": _of(np.median, items, "tube_sigmas"),
                    "torque, % of limit": _of(np.max, items, "torque_share", 100.0),
                    "x real time": _of(np.median, items, "real_time_factor"),
                }
            )
    return rows


def relevance_rows(relevance: Mapping[str, Sequence[bool]]) -> list[dict[str, Any]]:
    """A row for each motion: in how many seeds its variables were exactly right."""
    rows = []
    for label, values in relevance.items():
        low, high = wilson_interval(sum(values), len(values))
        rows.append(
            {"motion": label, "right": f"{sum(values)} of {len(values)}", "interval": f"{low:.0f} to {high:.0f}"}
        )
    return rows


def failure_rows(results: Iterable[RolloutResult]) -> list[dict[str, Any]]:
    """A row for each rollout that did not succeed, and why."""
    return [
        {"arm": item.arm, "scenes": item.kind, "motion": item.label, "scene": item.number, "why": item.reason}
        for item in results
        if not item.success
    ]


def _sheet(out: Path, results: Sequence[RolloutResult], arm: str) -> Path:
    rows: dict[str, list[Tile]] = {}
    for item in results:
        if item.arm == arm:
            picture = out / "rollouts" / f"{item.arm}_{item.kind}_{item.label}_{item.number:03d}.png"
            rows.setdefault(f"{item.label}, {item.kind} scenes", []).append(
                Tile(picture, item.success, f"{item.number}")
            )
    return write_contact_sheet(rows, out / f"ends_{arm}.png")


def _grouped(results: Iterable[RolloutResult]) -> dict[tuple[str, str], list[RolloutResult]]:
    """By arm and kind of scene, drawn ones first."""
    groups: dict[tuple[str, str], list[RolloutResult]] = {}
    for item in sorted(results, key=lambda item: (DRAWN, MIRRORED).index(item.kind)):
        groups.setdefault((item.arm, item.kind), []).append(item)
    return groups


def _by_label(group: Iterable[RolloutResult]) -> dict[str, list[RolloutResult]]:
    labels: dict[str, list[RolloutResult]] = {}
    for item in group:
        labels.setdefault(item.label, []).append(item)
    return labels


def _values(items: Iterable[RolloutResult], name: str) -> list[float]:
    return [item.figures[name] for item in items if name in item.figures and np.isfinite(item.figures[name])]


def _of(
    statistic: Callable[[Sequence[float]], Any], items: Iterable[RolloutResult], name: str, scale: float = 1.0
) -> float | None:
    """A statistic of a figure over some rollouts, in other units; None where it was never measured."""
    values = _values(items, name)
    return scale * float(statistic(values)) if values else None
