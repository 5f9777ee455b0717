"""What a world refuses: clocks that do not fit, scenes that lack something, numbers that are none."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.demonstration import Scene
from pft_exec.description import TaskDescription
from pft_exec.exceptions import MissingObjectError, SimulationError
from pft_exec.geometry import Array
from pft_exec.model import Arm


def steps_per_period(control_period: float, physics_step: float) -> int:
    """Physics steps in a control period; refuses clocks that do not fit."""
    if not (physics_step > 0.0 and control_period > 0.0):
        raise SimulationError(f"control period {control_period} s and physics step {physics_step} s must be positive.")
    steps = round(control_period / physics_step)
    if steps < 1 or abs(steps * physics_step - control_period) > 1e-9:
        raise SimulationError(
            f"the control period must be a whole number of physics steps; got {control_period} s and {physics_step} s."
        )
    return steps


def checked_scene(task: TaskDescription, scene: Scene) -> Scene:
    """Hold a scene against a task: every placed object, and no other."""
    for name in task.placed:
        if name not in scene:
            raise MissingObjectError("object of the scene", name, scene, f"Task {task.name!r} needs it.")
    for name in scene:
        if name not in task.placed:
            raise MissingObjectError("placed object of the task", name, task.placed, "The scene has it.")
    return scene


def checked(values: ArrayLike, size: int, what: str, unit: str) -> Array:
    """Refuse values that are not (size,) or not finite."""
    array = np.asarray(values, dtype=float)
    if array.shape != (size,):
        raise SimulationError(f"the {what} must have shape ({size},), {unit}; got {array.shape}.")
    if not np.isfinite(array).all():
        raise SimulationError(f"the {what} must be finite, {unit}; got {array}.")
    return array


def check_within_limits(arm: Arm, q: Array) -> None:
    """Refuse a configuration (n,), rad, beyond the limits of an arm."""
    outside = np.flatnonzero((q < arm.limits.lower) | (q > arm.limits.upper))
    if outside.size:
        joint = int(outside[0])
        raise SimulationError(
            f"joint {arm.joint_names[joint]!r} cannot stand at {q[joint]:.4f} rad; its limits are "
            f"{arm.limits.lower[joint]:.4f} to {arm.limits.upper[joint]:.4f} rad."
        )
