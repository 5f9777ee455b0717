"""Commands for recordings, without a simulator: `learn` and `recognize`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pft_exec.cli.application import command
from pft_exec.cli.options import DemonstrationFile, Json, LibraryFile, Plot, Written
from pft_exec.cli.terminal import print_tables, progress


@command("learn demonstrations.h5 library.h5 --count 5 --held-out rest.h5")
def learn(
    demonstrations: DemonstrationFile,
    library: Written,
    method: Annotated[str, typer.Option(help="robust or dong2012.")] = "robust",
    count: Annotated[int | None, typer.Option(help="Learn from so many of each motion; default: all.", min=2)] = None,
    held_out: Annotated[Path | None, typer.Option(help="Write the demonstrations that --count left over.")] = None,
    seed: Annotated[int | None, typer.Option(help="Draw the --count at random; default: the first ones.")] = None,
    as_json: Json = False,
) -> None:
    """Learn a motion library, and print which motion variables are relevant and the numbers that decided it."""
    from pft_exec import learn_library, load_demonstrations, save_demonstrations
    from pft_exec.report import decision_rows, hold_out

    taught = load_demonstrations(demonstrations)
    chosen, rest = (taught, []) if count is None else hold_out(taught, count, seed)
    with progress("learning"):
        learned = learn_library(chosen, method)
    learned.save(library)
    if held_out is not None:
        save_demonstrations(held_out, rest)
    decisions = {label: learned[label].variables.to_dict() for label in learned.labels}
    result = {"file": library, "learned_from": len(chosen), "held_out": len(rest), "motions": decisions}
    print_tables(as_json, result, {f"{library}: learned from {len(chosen)} demonstrations": decision_rows(learned)})


@command("recognize library.h5 rest.h5 --plot belief.png")
def recognize(
    library: LibraryFile,
    recordings: DemonstrationFile,
    method: Annotated[str, typer.Option(help="phase or dong2012.")] = "phase",
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Recognize recordings sample by sample, as if they were under way: label, probability, when it was decided."""
    from pft_exec import MotionLibrary, load_demonstrations
    from pft_exec.report import plot_beliefs, recognition_rows, recognize_stream

    known, streams = MotionLibrary.load(library), load_demonstrations(recordings)
    results = []
    with progress("recognizing") as advance:
        for place, stream in enumerate(streams):
            results.append(recognize_stream(known, stream, method))
            advance("recognizing", (place + 1) / len(streams))
    if plot is not None:
        plot_beliefs(results, plot)
    right, rows = sum(result.is_right for result in results), recognition_rows(results)
    print_tables(as_json, {"recognized": right, "recordings": rows}, {f"{right} of {len(rows)} recognized": rows})
