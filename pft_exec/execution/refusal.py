"""Refusals: before anything moves, why a motion cannot be made in a scene, and the nearest placement that will do."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pft_exec.demonstration.synthetic import STEADY
from pft_exec.description import Setting, nominal_setting, path_is_free
from pft_exec.description.nearest import nearest_setting, told_placement
from pft_exec.exceptions import UnreachableError
from pft_exec.execution.hand.hand_path import plan_hand_paths
from pft_exec.learning.motion import substituted
from pft_exec.simulation import World


def refusal(
    world: World,
    label: str,
    arm: str,
    setting: Setting,
    reason: str,
    substitute: Mapping[str, str] | None = None,
) -> UnreachableError:
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
    substitute : {name: name}, optional
        Object that the task names to the one that takes its place, and stands in the setting in its stead.
    """
    task = world.task_for(arm)
    nearest = nearest_setting(task, label, setting, lambda tried: can_be_made(world, label, arm, tried))
    return UnreachableError(f"{reason} {told_placement(task, label, setting, nearest, substitute)}".rstrip())


def refusal_here(
    world: World, label: str, arm: str, reason: str, substitute: Mapping[str, str] | None = None
) -> UnreachableError:
    """The error that says why a motion cannot be made as the world stands now, and which placement near it would do.

    Where the task does not know the motion, or a person could make it from here, the placement is not what is wrong:
    then nothing is said of another. A motion that follows others is looked at from where the first of them begins.

    Parameters
    ----------
    world : World
        Nothing moves.
    label, arm : str
    reason : str
        Why.
    substitute : {name: name}, optional
        Object that the task names to the one that takes its place.
    """
    task = world.task_for(arm)
    if label not in task.labels:
        return UnreachableError(reason)
    objects = dict(substituted(world.scene, substitute or {}).objects)
    follows = len(task.chain(label)) > 1
    setting = nominal_setting(task, label, objects) if follows else Setting(objects, world.tool(arm))
    if can_be_made(world, label, arm, setting):
        return UnreachableError(reason)
    return refusal(world, label, arm, setting, reason, substitute)


def can_be_made(world: World, label: str, arm: str, setting: Setting) -> bool:
    """Whether the hand's way is free and the arm can be led along it, by a person who moves steadily."""
    if not path_is_free(world.task_for(arm), label, setting):
        return False
    try:
        plan_hand_paths(world, label, arm, setting, np.random.default_rng(0), STEADY)
    except UnreachableError:
        return False
    return True
