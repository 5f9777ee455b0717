"""Carried objects: what moved with the tool is where the tool is, and says nothing about where a motion ends.

In the flow: reported as a fact of its own among the motion variables. What the tool holds from the first sample on says
nothing about where a motion begins either: in a new scene it is wherever the tool is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array, conjugate
from pft_exec.learning.frames import object_names
from pft_exec.learning.turning import carry

MOVED = 0.1  # of the extent of the tool's path: an object displaced less than this was not carried
RIGID = 0.15  # of the object's displacement: how far it may shift in the hand on the way
MOVING = 0.05  # of the object's greatest step: below it the object rests


def _offsets(demonstration: Demonstration, poses: Array) -> Array:
    """Place (N, 3) of an object (N, 7) seen from the tool."""
    offset = poses[:, :3] - demonstration.position
    return offset if demonstration.quaternion is None else carry(conjugate(demonstration.quaternion), offset)


def _is_carried(demonstration: Demonstration, poses: Array, from_start: bool = False) -> bool:
    """Whether an object (N, 7) moves, and only with the tool; `from_start`: and the tool never without it before."""
    extent = float(np.linalg.norm(np.ptp(demonstration.position, axis=0)))
    displacement = float(np.linalg.norm(np.ptp(poses[:, :3], axis=0)))
    if displacement <= MOVED * extent:
        return False
    steps = np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1)
    moving = np.flatnonzero(steps > MOVING * steps.max())
    first = 0 if from_start else moving[0]
    shift = np.linalg.norm(np.ptp(_offsets(demonstration, poses)[first : moving[-1] + 2], axis=0))
    return bool(shift <= RIGID * displacement)


def carried_objects(demonstrations: Sequence[Demonstration], from_start: bool = False) -> tuple[str, ...]:
    """Objects that the tool carried in most demonstrations, sorted; `from_start`: and held when the motion began."""
    found = []
    for name in object_names(demonstrations):
        tracked = [d for d in demonstrations if d.objects[name].ndim == 2]
        moved = [d for d in tracked if _is_carried(d, d.objects[name], from_start)]
        if 2 * len(moved) > len(demonstrations):
            found.append(name)
    return tuple(found)
