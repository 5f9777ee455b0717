"""Commands that measure: `demo`, `evaluate`, `reproduce` and `benchmark`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from pft_exec.cli.application import command
from pft_exec.cli.options import Json, Seed, Strict
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


@command("evaluate --seeds 20 --out runs/evaluation")
def evaluate(
    seeds: Annotated[int, typer.Option(help="Number of runs of the demo, from --seed up.", min=1)] = 20,
    seed: Seed = 0,
    jobs: Annotated[int, typer.Option(help="Processes.", min=1)] = 1,
    out: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("runs/evaluation"),
    strict: Strict = False,
    as_json: Json = False,
) -> None:
    """Run the demo over many seeds and hold every figure against its floor."""
    from pft_exec.evaluation.study import run_study

    with progress("evaluating") as advance:
        report = run_study(range(seed, seed + seeds), out=out, jobs=jobs, progress=advance)
    _report_figures(report, {}, out, strict, as_json)


def _report_figures(
    report: Mapping[str, Any], before: Mapping[str, Any], out: Path, strict: bool, as_json: bool
) -> None:
    """Tables of what was found, and the table of figures that closes a report."""
    rows = [{"figure": name, **figure} for name, figure in report["figures"].items()]
    print_tables(as_json, report, {**before, f"figures; report in {out}": rows})
    if strict and not all(row["ok"] for row in rows):
        raise typer.Exit(1)


@command("reproduce table1 --seeds 5 --out runs/table1")
def reproduce(
    what: Annotated[str, typer.Argument(help="Table or figure of the paper: table1, table2, real, all.")],
    seeds: Annotated[int, typer.Option(help="Number of seeds.", min=1)] = 5,
    out: Annotated[Path | None, typer.Option(help="Folder for the full result and its pictures.")] = None,
    as_json: Json = False,
) -> None:
    """Reproduce a table of the paper, ours and its baselines beside the published figures."""
    from pft_exec.evaluation import reproduce as reproduce_tables

    with progress(f"reproducing {what}") as advance:
        result = reproduce_tables(what, seeds=seeds, out=out, progress=advance)
    print_tables(as_json, result, result["tables"])


@command("benchmark recognition")
def benchmark(
    what: Annotated[str, typer.Argument(help="recognition, learning or control.")],
    seed: Seed = 0,
    as_json: Json = False,
) -> None:
    """Time a part, with the alternatives in the same run."""
    from pft_exec.evaluation import benchmark as run_benchmark

    with progress(f"timing {what}") as advance:
        result = run_benchmark(what, seed=seed, progress=advance)
    print_tables(as_json, result, result["tables"])
