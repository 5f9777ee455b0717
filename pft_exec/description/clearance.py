"""Free space: between the objects of a scene, between them and the hand along a path, and up to the workspace's end."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pft_exec.description.task import TaskDescription
from pft_exec.geometry import Array, Pose, mirror_positions, rotate

_POINTS_ON_HAND = 8


def object_clearance(task: TaskDescription, objects: Mapping[str, Pose]) -> float:
    """Least horizontal distance, m, between the upright cylinders around any two placed objects; inf for fewer."""
    names = [name for name in task.placed if name in objects]
    gaps = [
        float(np.linalg.norm(objects[first].position[:2] - objects[second].position[:2]))
        - task.objects[first].shape.outline
        - task.objects[second].shape.outline
        for index, first in enumerate(names)
        for second in names[:index]
    ]
    return min(gaps, default=float("inf"))


def hand_clearance(task: TaskDescription, objects: Mapping[str, Pose], positions: Array, quaternions: Array) -> float:
    """Least distance, m, between the hand on its path and the objects; below 0 they overlap.

    Parameters
    ----------
    task : TaskDescription
    objects : mapping of name to Pose, world frame
    positions : (N, 3), m, world frame
        Of the tool.
    quaternions : (N, 4), (x, y, z, w), world frame

    Returns
    -------
    float
        inf for no object. The hand is a capsule on an axis of the tool, an object the upright cylinder around it.
    """
    hand = task.clearance.hand
    along = np.linspace(-hand.behind, hand.ahead, _POINTS_ON_HAND)
    axis = rotate(quaternions, np.array([1.0, 0.0, 0.0] if hand.axis == "x" else [0.0, 0.0, 1.0]))
    points = (positions[:, None, :] + along[:, None] * axis[:, None, :]).reshape(-1, 3)
    gaps = [
        float(np.min(_distance_to_cylinder(points - objects[name].position, item.shape.outline, item.shape.height)))
        for name, item in task.objects.items()
        if name in objects
    ]
    return min(gaps, default=float("inf")) - hand.radius


def workspace_excess(task: TaskDescription, positions: Array) -> float:
    """How far positions (N, 3), m, world frame, leave the task's workspace at most, along one axis, m; 0 inside."""
    if task.mirror is not None:
        positions = mirror_positions(positions, task.mirror)
    bounds = np.array([task.workspace.x, task.workspace.y, task.workspace.z])
    excess = np.maximum(bounds[:, 0] - positions, positions - bounds[:, 1])
    return max(float(excess.max()), 0.0)


def _distance_to_cylinder(points: Array, radius: float, height: float) -> Array:
    """Distance of points (N, 3) to an upright cylinder about the origin, m; below 0 inside."""
    beside = np.hypot(points[:, 0], points[:, 1]) - radius
    above = np.abs(points[:, 2]) - 0.5 * height
    outside = np.hypot(np.maximum(beside, 0.0), np.maximum(above, 0.0))
    distance: Array = outside + np.minimum(np.maximum(beside, above), 0.0)
    return distance
