"""Stiffness along a motion, beside the spread of the demonstrations that it comes from."""

from __future__ import annotations

from pathlib import Path

from numpy.typing import ArrayLike

from pft_exec.exceptions import InvalidFlowTubeError
from pft_exec.geometry import read_only
from pft_exec.report.style import AXES, COLORS, picture


def plot_stiffness(
    time: ArrayLike, stiffness: ArrayLike, path: str | Path, deviation: ArrayLike | None = None, label: str = ""
) -> None:
    """Draw the translational stiffness of the tool along a motion.

    Parameters
    ----------
    time : (N,), s
    stiffness : (N, 3), N/m
        Along x, y, z.
    path : str or Path
    deviation : (N, 3), m, or None
        Standard deviation of the tube along the same axes, drawn below.
    label : str
        The motion.

    Raises
    ------
    InvalidFlowTubeError
        If the shapes do not fit.
    StorageError
        If the picture cannot be written.
    """
    instants, rows = read_only(time), read_only(stiffness)
    spread = None if deviation is None else read_only(deviation)
    for name, values in (("stiffness", rows), ("deviation", spread)):
        if values is not None and values.shape != (instants.size, 3):
            raise InvalidFlowTubeError(f"{name} must have shape ({instants.size}, 3); got {values.shape}.")
    panels = [(rows, "stiffness (N/m)")] + ([] if spread is None else [(1000.0 * spread, "spread of the tube (mm)")])
    with picture(path, 7.5, 0.8 + 2.4 * len(panels)) as figure:
        axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for panel, (values, name) in zip(axes, panels, strict=True):
            for axis, letter in enumerate(AXES):
                panel.plot(instants, values[:, axis], color=COLORS[axis], label=letter)
            panel.set_ylabel(name)
            panel.set_ylim(bottom=0.0)
        axes[-1].set_xlabel("time (s)")
        axes[0].legend(loc="center left", bbox_to_anchor=(1.01, 0.5), title="axis, world")
        figure.suptitle("Stiffness at the tool" + (f": {label}" if label else ""))
