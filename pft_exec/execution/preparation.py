"""Setting up a world for a motion that is to be assisted: objects, and the arm at the motion's start."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from pft_exec.demonstration import Scene
from pft_exec.description import Setting, TaskDescription, draw_setting, nominal_setting, random_stream, setting_from
from pft_exec.exceptions import MissingObjectError, UnreachableError
from pft_exec.execution.grasping import set_up_motion
from pft_exec.execution.hand.guiding import lead_there
from pft_exec.execution.hand.hand_path import HandPath, plan_hand_paths, resting_posture
from pft_exec.execution.refusal import refusal
from pft_exec.geometry import Pose
from pft_exec.learning.motion import substituted
from pft_exec.model import solve_inverse_kinematics
from pft_exec.simulation import World, task_for


def prepare(
    world: World,
    label: str,
    arm: str | None = None,
    *,
    seed: int | None = None,
    scene: Scene | None = None,
    start: Pose | None = None,
    substitute: Mapping[str, str] | None = None,
) -> Setting:
    """Set up: objects and the arm as they may stand before a motion, in a scene that no demonstration had.

    What the motion holds is in the gripper then, and the motions that it follows have been made, by a synthetic person
    who leads the arm; time goes on from there.

    Parameters
    ----------
    world : World
        Set up anew; other arms are parked.
    label : str
    arm : str or None
        None is the only arm, else "right".
    seed : int or None
        None is the world's. Of the placement and the start; the stream is "evaluate", never that of teaching.
    scene : Scene or None
        Objects, world frame; None draws them from the task's placements until the arm can make the motion.
    start : Pose or None
        Of the tool, world frame; None draws it from the task's starts.
    substitute : {name: name}, optional
        Taught object to the one that takes its place: in a drawn scene, or in the gripper, the two trade places.

    Returns
    -------
    Setting
        Of a motion that follows others that of the first of them; the world itself says how it stands now.

    Raises
    ------
    UnknownMotionError, UnknownArmError
        If the task has no such motion, or the robot no such arm.
    MissingObjectError
        If a substitution names an object that the scene lacks.
    UnreachableError
        If the arm does not reach the start, or none of many drawn placements lets it make the motion.
    """
    name = world.arm_name(arm)
    task = task_for(world.robot, world.task, name)
    task.motion(label)
    seed = world.seed if seed is None else seed

    def planned(setting: Setting) -> list[HandPath]:
        return plan_hand_paths(world, label, name, setting, random_stream(seed, "assist", label, name))

    setting = _setting(world, label, name, seed, planned, None if scene is None else scene.objects, start)
    if substitute and (scene is None or task.motion(task.chain(label)[0]).holds is not None):
        setting = trade_places(task, task.chain(label)[0], setting, substitute)
    if len(task.chain(label)) > 1:
        lead_there(world, setting, planned(_as_taught(setting, substitute)), substitute=substitute)
        return setting
    model = world.arm(name)
    found = solve_inverse_kinematics(model, world.base.inverse() @ setting.start, resting_posture(model))
    if not found.found:
        reason = (
            f"the {name} arm does not reach the start of {label!r}: the tool stays "
            f"{1e3 * found.position_error:.0f} mm and {found.rotation_error:.2f} rad away from it."
        )
        raise refusal(world, label, name, setting, reason)
    set_up_motion(world, label, name, setting, found.configuration, substitute)
    return setting


def trade_places(task: TaskDescription, label: str, setting: Setting, substitute: Mapping[str, str]) -> Setting:
    """The setting in which each substitute is where the taught object was, and the other way round.

    What stood still stands on what it stood on; what was held lies in the hand as the taught object did.

    Raises
    ------
    MissingObjectError
        If the setting lacks one of them.
    """
    objects, holds = dict(setting.objects), task.motion(label).holds
    for taught, now in substitute.items():
        for name in (taught, now):
            if name not in setting.objects:
                raise MissingObjectError("object", name, setting.objects, f"They are what {label!r} finds.")
        rise = 0.5 * (task.objects[now].shape.height - task.objects[taught].shape.height)
        is_held = holds is not None and holds.object == taught
        objects[now] = _lifted(setting.objects[taught], 0.0 if is_held else rise)
        objects[taught] = _lifted(setting.objects[now], -rise)
    return Setting(objects, setting.start)


def _lifted(pose: Pose, rise: float) -> Pose:
    return Pose(pose.position + np.array([0.0, 0.0, rise]), pose.quaternion)


def _as_taught(setting: Setting, substitute: Mapping[str, str] | None) -> Setting:
    """As the motion was taught: each taught object where its substitute is."""
    return Setting(dict(substituted(Scene(setting.objects), substitute or {}).objects), setting.start)


def _setting(
    world: World,
    label: str,
    arm: str,
    seed: int,
    planned: Callable[[Setting], list[HandPath]],
    objects: Mapping[str, Pose] | None,
    start: Pose | None,
) -> Setting:
    """Objects and start, drawn where they are not given, such that a person can lead the arm through the motion."""
    task = world.task_for(arm)
    rng = random_stream(seed, "evaluate", "setting", label, arm)

    def feasible(setting: Setting) -> bool:
        try:
            planned(setting)
        except UnreachableError:
            return False
        return True

    if start is None:
        try:
            return draw_setting(task, label, rng, feasible, objects=objects)
        except UnreachableError as error:
            if objects is None:
                raise
            raise refusal(world, label, arm, nominal_setting(task, label, objects), str(error)) from error
    if objects is None:
        objects = draw_setting(task, label, rng, feasible).objects
    return setting_from(task, label, objects, start)
