"""A sheet of a motion is drawn for any number of methods, with and without a person's recording."""

from __future__ import annotations

from pathlib import Path

import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.learning import MotionLibrary
from pft_exec.report.motion_sheet import plot_motion


@pytest.mark.parametrize("methods", [("robust",), ("robust", "dong2012")])
def test_a_sheet_shows_every_method(
    demonstrations: list[Demonstration], library: MotionLibrary, tmp_path: Path, methods: tuple[str, ...]
) -> None:
    taught = [item for item in demonstrations if item.label == "reach"]
    tube = library["reach"].flow_tube(taught[0].scene, taught[0].start)
    path = tmp_path / "reach.png"
    plot_motion(taught, dict.fromkeys(methods, tube), path, taught[0] if len(methods) > 1 else None)
    assert path.stat().st_size > 20_000
