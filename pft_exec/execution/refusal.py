"""Refusals: before anything moves, why a motion cannot be made in a scene, and the nearest placement that will do."""

from __future__ import annotations

import numpy as np

from pft_exec.demonstration.synthetic import STEADY
from pft_exec.description import Setting, path_is_free
from pft_exec.description.nearest import nearest_setting, told_placement
from pft_exec.exceptions import UnreachableError
from pft_exec.execution.hand.hand_path import plan_hand_paths
from pft_exec.simulation import World


def refusal(world: World, label: str, arm: str, setting: Setting, reason: str) -> UnreachableError:
    """The error that says why a motion cannot be made in a setting, and which one near it would do.

    Parameters
    ----------
    world : World
        Only its robot and task matter; nothing moves.
    label, arm : str
    setting : Setting
        That cannot be worked in, world frame.
    reason : str
        Why.
    """
    task = world.task_for(arm)
    nearest = nearest_setting(task, label, setting, lambda tried: can_be_made(world, label, arm, tried))
    return UnreachableError(f"{reason} {told_placement(task, label, setting, nearest)}".rstrip())


def can_be_made(world: World, label: str, arm: str, setting: Setting) -> bool:
    """Whether the hand's way is free and the arm can be led along it, by a person who moves steadily."""
    if not path_is_free(world.task_for(arm), label, setting):
        return False
    try:
        plan_hand_paths(world, label, arm, setting, np.random.default_rng(0), STEADY)
    except UnreachableError:
        return False
    return True
