"""Carried objects: what moved with the tool is where the tool is, and says nothing about where a motion ends.

In the flow: reported as a fact of its own among the motion variables.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array, conjugate, rotate
from pft_exec.learning.frames import object_names

MOVED = 0.1  # of the extent of the tool's path: an object displaced less than this was not carried
RIGID = 0.15  # of the object's displacement: how far it may shift in the hand on the way
MOVING = 0.05  # of the object's greatest step: below it the object rests


def _is_carried(demonstration: Demonstration, poses: Array) -> bool:
    """Whether an object (N, 7) moves, and only with the tool."""
    extent = float(np.linalg.norm(np.ptp(demonstration.position, axis=0)))
    displacement = float(np.linalg.norm(np.ptp(poses[:, :3], axis=0)))
    if displacement <= MOVED * extent:
        return False
    offset = poses[:, :3] - demonstration.position
    if demonstration.quaternion is not None:
        offset = rotate(conjugate(demonstration.quaternion), offset)
    steps = np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1)
    moving = np.flatnonzero(steps > MOVING * steps.max())
    shift = np.linalg.norm(np.ptp(offset[moving[0] : moving[-1] + 2], axis=0))
    return bool(shift <= RIGID * displacement)


def carried_objects(demonstrations: Sequence[Demonstration]) -> tuple[str, ...]:
    """Objects that the tool carried in most demonstrations, sorted."""
    found = []
    for name in object_names(demonstrations):
        moved = [d for d in demonstrations if d.objects[name].ndim == 2 and _is_carried(d, d.objects[name])]
        if 2 * len(moved) > len(demonstrations):
            found.append(name)
    return tuple(found)
