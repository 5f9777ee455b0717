"""Commands that measure: `demo`, `evaluate`, `reproduce` and `benchmark`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from pft_exec.cli.application import command
from pft_exec.cli.options import Jobs, Json, Robot, Seed, Strict, Tool
from pft_exec.cli.terminal import print_tables, progress


@command("demo --out runs/demo --seed 0")
def demo(
    out: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("runs/demo"),
    seed: Seed = 0,
    video: Annotated[bool, typer.Option(help="Write demo.mp4.")] = True,
    strict: Strict = False,
    as_json: Json = False,
) -> None:
    """Teach four motions on the PR2, learn, recognize, take over and finish, with both arms; write a report."""
    from pft_exec.evaluation.demo import report_tables, run_demo

    with progress("opening the world") as advance:
        report = run_demo(out, seed=seed, progress=advance, video=video)
    _report_figures(report, report_tables(report), out, strict, as_json)


@command("evaluate --task bottle --scenes 20 --arms left,right --jobs 2")
def evaluate(
    task: Annotated[
        str | None, typer.Option(help="Task to teach and execute in unseen scenes; default: demos.")
    ] = None,
    robot: Robot = "pr2",
    tool: Tool = None,
    scenes: Annotated[int, typer.Option(help="With --task: unseen scenes of each motion and arm.", min=1)] = 20,
    arms: Annotated[str | None, typer.Option(help="With --task: such as left,right. Default: all.")] = None,
    film: Annotated[str, typer.Option(help="With --task: none, failed, all, or a rollout's name.")] = "failed",
    mirror_images: Annotated[bool, typer.Option(help="With --task: mirrored scenes too.")] = False,
    relevance_seeds: Annotated[int, typer.Option(help="With --task: teach so often to judge relevance.", min=0)] = 0,
    assisted: Annotated[int, typer.Option(help="With --task: instead, so many runs that a hand begins.", min=0)] = 0,
    seeds: Annotated[int, typer.Option(help="Without --task: runs of the demo, from --seed up.", min=1)] = 20,
    seed: Seed = 0,
    jobs: Jobs = 1,
    out: Annotated[Path | None, typer.Option(help="Folder of the report; default: runs/evaluation...")] = None,
    strict: Strict = False,
    as_json: Json = False,
) -> None:
    """Teach, learn and execute at scale: the demo over many seeds, or with --task every motion of a task.

    A study of a task goes on where an earlier one with the same settings was interrupted.
    """
    out = out or Path("runs", "_".join(filter(None, ("evaluation", Path(task).name if task else None))))
    tables: Mapping[str, Any] = {}
    with progress("evaluating") as advance:
        if task is None:
            from pft_exec.evaluation.study import run_study

            report = run_study(range(seed, seed + seeds), out=out, jobs=jobs, progress=advance)
        elif assisted:
            from pft_exec.evaluation.assistance_study import run_assistance_study
            from pft_exec.evaluation.lessons import Subject

            subject = Subject(robot, task, tool, seed)
            report = run_assistance_study([subject], out, runs=assisted, jobs=jobs, progress=advance)
            tables = report["tables"]
        else:
            from pft_exec.evaluation.lessons import Subject
            from pft_exec.evaluation.task_study import run_task_study

            report = run_task_study(
                out,
                Subject(robot, task, tool, seed),
                scenes=scenes,
                arms=arms.split(",") if arms else None,
                mirror_images=mirror_images,
                relevance_seeds=relevance_seeds,
                film=film,
                jobs=jobs,
                progress=advance,
            )
            failed = report["failures"]
            tables = {"motions": report["motions"], "failures" if failed else "no failures": failed}
    _report_figures(report, tables, out, strict, as_json)


def _report_figures(
    report: Mapping[str, Any], before: Mapping[str, Any], out: Path, strict: bool, as_json: bool
) -> None:
    """Tables of what was found, and the table of figures that closes a report."""
    rows = [{"figure": name, **figure} for name, figure in report.get("figures", {}).items()]
    print_tables(as_json, report, {**before, f"figures; report in {out}": rows})
    if strict and not all(row["ok"] for row in rows):
        raise typer.Exit(1)


@command("reproduce table1 --seeds 5 --out runs/table1")
def reproduce(
    what: Annotated[
        str, typer.Argument(help="Table or figure of the paper: table1, table2, table3, figure5, real, all.")
    ],
    seeds: Annotated[int, typer.Option(help="Number of seeds.", min=1)] = 5,
    out: Annotated[Path | None, typer.Option(help="Folder for the full result and its pictures.")] = None,
    jobs: Jobs = 1,
    as_json: Json = False,
) -> None:
    """Reproduce a table of the paper, ours and its baselines beside the published figures."""
    from pft_exec.evaluation import reproduce as reproduce_tables

    with progress(f"reproducing {what}") as advance:
        result = reproduce_tables(what, seeds=seeds, out=out, progress=advance, jobs=jobs)
    print_tables(as_json, result, result["tables"])


@command("benchmark recognition")
def benchmark(
    what: Annotated[
        str, typer.Argument(help="recognition, learning, control, compliance, obstacle, handoff or faults.")
    ],
    seed: Seed = 0,
    count: Annotated[int | None, typer.Option(help="Of rollouts, where it has any.", min=1)] = None,
    jobs: Jobs = 1,
    record: Annotated[Path | None, typer.Option(help="File of the rollouts, from which a run goes on.")] = None,
    as_json: Json = False,
) -> None:
    """Time a part, with the alternatives in the same run."""
    from pft_exec.evaluation import benchmark as run_benchmark

    with progress(f"timing {what}") as advance:
        result = run_benchmark(what, seed=seed, progress=advance, count=count, jobs=jobs, record=record)
    print_tables(as_json, result, result["tables"])
