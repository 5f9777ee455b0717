"""The demo: one rehearsal, and a report of it in a folder."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from pft_exec.control import compute_compliance, operational_stiffness
from pft_exec.demonstration import save_demonstrations
from pft_exec.evaluation.figures import figures_to_dict
from pft_exec.evaluation.measurements import figures, found_relations, measure
from pft_exec.evaluation.rehearsal import ROBOT, TASK, Progress, Rehearsal, Run, Watch, rehearse, unwatched
from pft_exec.execution.control_loop import Observer
from pft_exec.execution.log import ExecutionLog, Stage
from pft_exec.geometry import Array, Pose
from pft_exec.learning import FlowTube
from pft_exec.model import load_robot
from pft_exec.report import plot_belief, plot_seam, plot_stiffness, plot_tubes
from pft_exec.report.film import Film, Scenes


def run_demo(
    out: str | Path,
    seed: int = 0,
    *,
    count: int = 5,
    video: bool = True,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Teach, learn, recognize, take over and finish, with both arms, and write the report.

    Parameters
    ----------
    out : str or Path
        Folder; made where it is missing. It gets ``report.json``, ``demonstrations.h5``, ``library.h5``, a log of each
        run, pictures and ``demo.mp4``.
    seed : int
    count : int
        Demonstrations of each motion.
    video : bool
    progress : callable or None
        Takes what is going on and the share that is done.

    Returns
    -------
    dict
        What ``report.json`` holds: ``figures`` by name, ``motions`` with what was found about each, ``runs``.
    """
    began = perf_counter()
    out = Path(out)
    out.mkdir(parents=True, exist_ok=True)
    with _filming(out / "demo.mp4", video) as watch:
        rehearsal = rehearse(seed, count=count, watch=watch, progress=progress)
        save_demonstrations(out / "demonstrations.h5", rehearsal.demonstrations)
        rehearsal.library.save(out / "library.h5")
        for run in rehearsal.runs:
            run.log.save(out / f"{_name(run)}.h5")
        if progress is not None:
            progress("drawing", 0.97)
        draw(rehearsal, out)
    report = describe(rehearsal) | {"seconds": perf_counter() - began}
    (out / "report.json").write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    return report


def describe(rehearsal: Rehearsal) -> dict[str, Any]:
    """The report of a rehearsal: figures, what was found about each motion, and each run in a line."""
    library = rehearsal.library
    return {
        "seed": rehearsal.seed,
        "figures": figures_to_dict(figures(measure(rehearsal))),
        "motions": {
            label: {"relations": found_relations(library, label), "description": library[label].describe()}
            for label in library.labels
        },
        "runs": [_describe_run(run) for run in rehearsal.runs],
        "refusal": rehearsal.refusal,
    }


def report_tables(report: Mapping[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """What a report says beside its figures, as rows by title: what matters in each motion, and how each run went."""
    decisions = [
        {"motion": label, "what matters": line.replace("`", "")}
        for label, motion in report["motions"].items()
        for line in motion["description"].splitlines()
    ]
    runs = [
        {
            "arm": run["arm"],
            "scene": run["kind"],
            "the hand began": run["motion"],
            "the robot finished": run["taken over"],
            "taken over at (%)": 100.0 * run["details"]["take_over_share"],
            "success": run["success"],
            "why": run["reason"],
        }
        for run in report["runs"]
    ]
    return {"motion variables": decisions, "runs": runs}


def _describe_run(run: Run) -> dict[str, Any]:
    return {
        "kind": run.kind,
        "arm": run.arm,
        "motion": run.truth,
        "taken over": run.log.label,
        "success": run.log.success,
        "reason": run.log.reason,
        "details": dict(run.log.details),
        "events": [list(event) for event in run.log.events],
    }


def draw(rehearsal: Rehearsal, out: Path) -> None:
    """Draw tubes, beliefs, seams and stiffness of the taught arm's runs into a folder."""
    runs = [run for run in rehearsal.runs if run.kind == "unseen"]
    tubes = {run.truth: run_tube(rehearsal, run) for run in runs}
    plot_tubes(tubes, rehearsal.demonstrations, out / "tubes.png", {run.truth: run.scene for run in runs})
    for run in runs:
        taken = run.log.event("take_over")
        plot_belief(run.log.belief, out / f"belief_{run.truth}.png", taken.time if taken else None, run.truth)
        plot_seam(run.log, out / f"seam_{run.truth}.png")
        if run.log.label == run.truth:
            time, stiffness, deviation = run_stiffness(tubes[run.truth], run.log)
            plot_stiffness(time, stiffness, out / f"stiffness_{run.truth}.png", deviation, run.truth)


def run_tube(rehearsal: Rehearsal, run: Run) -> FlowTube:
    """The tube of a run's motion in its scene, from where the tool stood (world frame)."""
    start = run.log.position[0], run.log.quaternion[0]
    return rehearsal.library[run.truth].flow_tube(run.scene, Pose(*start))


def run_stiffness(tube: FlowTube, log: ExecutionLog) -> tuple[Array, Array, Array]:
    """Times (T,), s, while the robot had the arm; stiffness of the tool (T, 3), N/m, and spread of the tube (T, 3), m.

    Both along x, y, z of the world.
    """
    rows = np.flatnonzero(log.stage >= Stage.TRANSITION)[::10]
    arm = load_robot(log.robot).arm(log.arm)
    compliance = compute_compliance(tube)
    stiffness, deviation = [], []
    for row in rows:
        dynamics = arm.dynamics(log.configuration[row], log.velocity[row])
        inertia = np.linalg.inv(dynamics.jacobian @ np.linalg.solve(dynamics.mass_matrix, dynamics.jacobian.T))
        phase = float(log.phase[row])
        gain, _ = compliance.at(phase)
        deviation.append(np.sqrt(np.diag(tube.at(phase).covariance)[:3]))
        stiffness.append(np.diag(operational_stiffness(inertia, gain[:, :6]))[:3])
    return log.time[rows], np.array(stiffness), np.array(deviation)


def _name(run: Run) -> str:
    return f"{run.arm}_{run.kind}_{run.truth}"


@contextmanager
def _filming(path: Path, video: bool) -> Iterator[Watch]:
    """A `Watch` that films every run that is to be seen: each first lesson, and the runs."""
    if not video:
        yield unwatched
        return
    with Film(path, ROBOT, TASK) as film:

        @contextmanager
        def watch(caption: str) -> Iterator[Observer]:
            scenes = Scenes(caption)
            yield scenes.observe
            film.add(scenes)

        yield watch
