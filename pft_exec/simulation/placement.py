"""Scenes that an arm reaches: drawn from a task's placements, and scenes of the user's held against the arm.

A task is written for the arm that a robot has alone, or else for its right one; for another arm it is mirrored in the
xz plane of the robot's base.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pft_exec.demonstration import Scene
from pft_exec.description import (
    TaskDescription,
    draw_scene,
    nominal_setting,
    path_is_free,
    random_stream,
    resolve_waypoints,
)
from pft_exec.exceptions import UnreachableError
from pft_exec.geometry import Array, Pose
from pft_exec.model import Arm, RobotModel, solve_inverse_kinematics

_ATTEMPTS = 100
_WORK, _PARKED = "work", "parked"  # named configurations, where the robot has them


def default_arm(robot: RobotModel) -> str:
    """Name of the arm that is meant where none is named, and that tasks are written for: the only one, else "right"."""
    return robot.arms[0] if len(robot.arms) == 1 else "right"


def task_for(robot: RobotModel, task: TaskDescription, arm: str) -> TaskDescription:
    """The task as written for the default arm, mirrored for any other, however it comes."""
    is_mirrored = arm != default_arm(robot)
    return task if (task.mirror is not None) == is_mirrored else task.mirrored()


def standing_configuration(arm: Arm, is_parked: bool = False) -> Array:
    """Joints (n,), rad, in which an arm stands ready, or parked: as named where it has such a name, else mid-range."""
    name = _PARKED if is_parked else _WORK
    return arm.configuration(name) if name in arm.configurations else 0.5 * (arm.limits.lower + arm.limits.upper)


def check_reach(arm: Arm, task: TaskDescription, label: str, scene: Scene, start: Pose | None = None) -> None:
    """Refuse a scene in which an arm does not reach a motion's start or a waypoint of it.

    Parameters
    ----------
    arm : Arm
    task : TaskDescription
        Mirrored where the arm needs it (`task_for`).
    label : str
    scene : Scene
    start : Pose or None
        Of the tool, world frame; None is the middle of where it may stand.

    Raises
    ------
    UnreachableError
        With the distance that is missing.
    UnknownMotionError
        If the task has no such motion.
    MissingObjectError
        If the scene lacks an object that the motion refers to.
    """
    seed = standing_configuration(arm)
    for what, pose in _poses(task, label, scene, start):
        reached = solve_inverse_kinematics(arm, task.robot_base.inverse() @ pose, seed)
        if not reached.found:
            place = ", ".join(f"{x:.3f}" for x in pose.position)
            raise UnreachableError(
                f"the {arm.name} arm cannot make {label!r} in this scene: {what} lies at ({place}) m, and the tool "
                f"stays {reached.position_error:.3f} m and {reached.rotation_error:.3f} rad away from it."
            )
        seed = reached.configuration


def draw_reachable_scene(
    robot: RobotModel, task: TaskDescription, arm: str, seed: int, label: str | None = None
) -> Scene:
    """Draw a scene that the task allows and in which the arm can make a motion from the nominal start.

    Without a label, every motion that has no placements of its own.

    Parameters
    ----------
    robot : RobotModel
    task : TaskDescription
    arm : str
        Mirrors the placements where the task is not written for it.
    seed : int
        Not negative; the same seed gives the same scene.
    label : str or None

    Raises
    ------
    UnreachableError
        If none is found; the message ends with why the last one was refused.
    """
    task = task_for(robot, task, arm)
    rng = random_stream(seed, "evaluate", "scene", *(() if label is None else (label,)))
    labels = (label,) if label is not None else tuple(each for each in task.labels if not _own_placements(task, each))
    reason = ""
    for _ in range(_ATTEMPTS):
        scene = Scene(draw_scene(task, rng, label))
        try:
            _check_scene(robot.arm(arm), task, labels, scene)
        except UnreachableError as error:
            reason = str(error)
        else:
            return scene
    raise UnreachableError(f"task {task.name!r}: none of {_ATTEMPTS} placements can be worked in; {reason}")


def _own_placements(task: TaskDescription, label: str) -> bool:
    """Whether a motion, or one that it follows, is made in scenes of its own."""
    return any(task.motion(part).placements for part in task.chain(label))


def _check_scene(arm: Arm, task: TaskDescription, labels: Sequence[str], scene: Scene) -> None:
    for label in labels:
        if not path_is_free(task, label, nominal_setting(task, label, scene.objects)):
            raise UnreachableError(f"an object stands in the way of {label!r}.")
    for label in labels:
        check_reach(arm, task, label, scene)


def _poses(task: TaskDescription, label: str, scene: Scene, start: Pose | None) -> Iterator[tuple[str, Pose]]:
    """Poses that a motion passes through, and what each is; those of the motions that it follows come first."""
    here = start or nominal_setting(task, label, scene.objects).start
    for part in task.chain(label):
        waypoints = resolve_waypoints(task, part, scene, here)
        last = len(waypoints.positions) - 1
        for index, (position, quaternion) in enumerate(zip(waypoints.positions, waypoints.quaternions, strict=True)):
            what = "its start" if index == 0 else "its end" if index == last else f"waypoint {index}"
            yield what if part == label else f"{what} of {part!r}", Pose(position, quaternion)
        here = waypoints.end
