"""Handled objects: what a switch on the way was about, such as the ball that a gripper closes on.

In the flow: `robust` gives them frames of their own among the experts, beside the objects that hold the two ends. At
each landmark the same competition of frames as at the ends decides, so that an object counts only where it explains
the place better than the world or the start does: one that merely stood still is not asked for in a new scene.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pft_exec.geometry import Array
from pft_exec.learning.decisions import NEAR
from pft_exec.learning.frames import position_candidates
from pft_exec.learning.relevance import choose_frame, weigh_frames


def handled_objects(
    landmarks: Array, tool: Array, poses: Mapping[str, Array], extent: float, has_turn: bool
) -> tuple[str, ...]:
    """Objects that the places of the landmarks are tied to, in the order of the landmarks.

    Parameters
    ----------
    landmarks : (K, L)
        Shares of the durations at which discrete signals changed.
    tool : (K, N, 7)
        Poses at steps on which the landmarks fall at their mean share, world frame, m and (x, y, z, w).
    poses : {name: (K, 7)}
        Of the objects that the tool did not hold from the start, world frame.
    extent : float, m
        Size of the motion.
    has_turn : bool
        Whether orientations were recorded.
    """
    if not poses:
        return ()
    steps = np.round(landmarks.mean(axis=0) * (tool.shape[1] - 1)).astype(int)
    start = position_candidates(tool[:, 0], None, poses, has_turn)
    found: dict[str, None] = {}
    for step in steps:
        here = position_candidates(tool[:, step], tool[:, 0], poses, has_turn)
        frame, _ = choose_frame(weigh_frames([start, here], extent)[1], NEAR * extent)
        if frame in poses:
            found[frame] = None
    return tuple(found)
