"""The path on which a person leads the tool, planned and checked before anything moves.

A person makes the path of their motion through the task's waypoints; inverse kinematics says beforehand whether the
arm can follow. Teaching uses it, and so does assistance, where the hand only begins the motion.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.demonstration import Scene
from pft_exec.demonstration.synthetic import HumanPath, HumanStyle, human_path
from pft_exec.description import Setting, TaskDescription, random_stream, resolve_waypoints, workspace_excess
from pft_exec.exceptions import UnreachableError
from pft_exec.geometry import Array, Pose, multiply
from pft_exec.learning.motion import substituted
from pft_exec.model import Arm, JointPath, follow_path
from pft_exec.simulation import HandGuide, World

GRIP_DELAY = 0.1  # s between a hand's arrival and its telling the gripper to move
CHECK_PERIOD = 0.04  # s between the samples of a path that inverse kinematics checks
LIMIT_MARGIN = 0.05  # rad that every joint keeps from its soft limit on a path that may be led
LEAST_MANIPULABILITY = 0.03  # smallest singular value of the Jacobian on such a path; 0 is singular
VELOCITY_SHARE = 0.7  # of each joint's velocity limit that such a path may take

_POSTURES = ("teach", "work")  # named configurations from which a search begins, the first that the robot has


@dataclass(frozen=True, eq=False)
class HandPath:
    """Where the hand is at every time, with rests at both ends, and the joints that go with it.

    Parameters
    ----------
    label : str
    arm : str
    path : HumanPath
        World frame.
    rest_before, rest_after : float, s
    goal : Pose
        Where the motion should end, if done without error, world frame.
    joints : JointPath
        By inverse kinematics, every `CHECK_PERIOD` of the path.
    grips : tuple of (float, str)
        When, s, the gripper is told to "close" or "open".
    """

    label: str
    arm: str
    path: HumanPath
    rest_before: float
    rest_after: float
    goal: Pose
    joints: JointPath
    grips: tuple[tuple[float, str], ...] = ()

    @property
    def duration(self) -> float:
        """With the rests, s."""
        return self.rest_before + self.path.duration + self.rest_after

    @property
    def configuration(self) -> Array:
        """Joints (n,), rad, at the beginning."""
        first: Array = self.joints.samples[0]
        return first

    def at(self, time: ArrayLike) -> tuple[Array, Array]:
        """Position (..., 3), m, and orientation (..., 4), (x, y, z, w), of the hand at times (...), s, world frame."""
        return self.path.at(np.asarray(time, dtype=float) - self.rest_before)


def plan_hand_path(
    world: World,
    label: str,
    arm: str | None,
    setting: Setting,
    rng: np.random.Generator,
    style: HumanStyle | None = None,
    seed: ArrayLike | None = None,
) -> HandPath:
    """Let a synthetic person plan a motion, and check that the arm can follow.

    Parameters
    ----------
    world : World
        Only its robot and task matter; nothing moves.
    label : str
    arm : str or None
        None is the default arm.
    setting : Setting
        Objects and the tool's start, world frame.
    rng : Generator
        The person's.
    style : HumanStyle, optional
    seed : (n,), rad, or None
        Joints now; None: the search begins at the arm's posture for teaching.

    Raises
    ------
    UnreachableError
        If the arm cannot follow: by how much, when, and where.
    UnknownArmError, UnknownMotionError, MissingObjectError
        If there is no such arm, motion, or object in the setting.
    """
    name = world.arm_name(arm)
    task = world.task_for(name)
    waypoints = resolve_waypoints(task, label, Scene(setting.objects), setting.start)
    path = human_path(
        waypoints.positions,
        waypoints.quaternions,
        waypoints.durations,
        rng,
        style,
        rests=waypoints.rests,
        curve=waypoints.curve,
        curve_duration=waypoints.curve_duration,
    )
    rest_before, rest_after = rng.uniform((0.15, 0.25), (0.4, 0.5)).tolist()
    arrivals = rest_before + path.arrivals
    grips = tuple((float(arrivals[index - 1]) + GRIP_DELAY, what) for index, what in waypoints.grips)
    if grips and grips[-1][0] > rest_before + path.duration:
        rest_after += float(waypoints.rests[-1])
    model = world.arm(name)
    joints = _checked_joints(world, label, model, path, resting_posture(model) if seed is None else seed)
    return HandPath(label, name, path, rest_before, rest_after, waypoints.end, joints, grips)


def _checked_joints(world: World, label: str, model: Arm, path: HumanPath, seed: ArrayLike) -> JointPath:
    """The joints that go with a hand's path, searched from a seed (n,), rad; refused where the arm cannot follow."""
    time, positions, quaternions = path.sample(CHECK_PERIOD)
    back = world.base.inverse()
    joints = follow_path(model, back.apply(positions), multiply(back.quaternion, quaternions), seed)
    _check_workspace(world.task_for(model.name), label, positions)
    _check_reach(label, model.name, time, positions, joints)
    _check_room(label, model, time, joints)
    return joints


def plan_hand_paths(
    world: World,
    label: str,
    arm: str | None,
    setting: Setting,
    rng: np.random.Generator,
    style: HumanStyle | None = None,
) -> list[HandPath]:
    """Plan a motion and, before it, those that it follows, each from where the last one ends; as `plan_hand_path`.

    The setting is that of the first of them.
    """
    plans: list[HandPath] = []
    start, seed = setting.start, None
    for part in world.task.chain(label):
        plan = plan_hand_path(world, part, arm, Setting(setting.objects, start), rng, style, seed)
        plans.append(plan)
        start, seed = Pose(*plan.at(plan.duration)), plan.joints.samples[-1]
    return plans


class Hand:
    """A synthetic person's hand that leads an arm's tool along a planned path.

    Parameters
    ----------
    world : World
    plan : HandPath
    guide : HandGuide or None
        How it holds the tool and where it goes; None follows the plan with an ordinary grip.
    """

    def __init__(self, world: World, plan: HandPath, guide: HandGuide | None = None) -> None:
        self.plan = plan
        self.guide = guide or HandGuide(plan, step=world.physics_step)
        self._world = world
        self._felt = -1.0, np.zeros(6)
        self._grips = list(plan.grips)

    @property
    def duration(self) -> float:
        """With the rests before and after, s."""
        return self.guide.duration

    @property
    def goal(self) -> Pose:
        """Where the motion should end, if done without error, world frame."""
        return self.plan.goal

    def share(self, time: float) -> float:
        """Share of the motion, rests apart, that the hand has made by a time, s: 0 to 1."""
        return float(np.clip((time - self.plan.rest_before) / self.plan.path.duration, 0.0, 1.0))

    def pull(self, time: float) -> Array:
        """Force, N, and torque, N m, (6,), on the tool now, world frame; time in s since the path began.

        As long as the hand holds the tool it also tells the gripper to close and open; once it lets go, no more.
        """
        while self._grips and time >= self._grips[0][0] and self.guide.strength(time) == 1.0:
            self._world.grip(self.plan.arm, self._grips.pop(0)[1] == "close")
        if time != self._felt[0]:  # the loop asks twice a period: to log, and to act
            force, torque = self.guide.wrench(time, *self._world.tool_motion(self.plan.arm))
            self._felt = time, np.concatenate([force, torque])
        return self._felt[1]


def lead_motion(
    world: World,
    label: str,
    arm: str | None = None,
    seed: int = 0,
    style: HumanStyle | None = None,
    substitute: Mapping[str, str] | None = None,
) -> Hand:
    """The hand of a person who makes a motion in the world as it stands, from where the tool is.

    Parameters
    ----------
    world : World
        Nothing moves yet.
    label : str
    arm : str or None
        None is the default arm.
    seed : int
        The person's; the stream is "assist", never that of teaching.
    style : HumanStyle or None
    substitute : {name: name}, optional
        Object that the task names to the one that the hand takes in its place.

    Raises
    ------
    UnreachableError
        If the arm cannot follow.
    UnknownArmError, UnknownMotionError, MissingObjectError
        If there is no such arm, motion, or object in the scene.
    """
    name = world.arm_name(arm)
    setting = Setting(dict(substituted(world.scene, substitute or {}).objects), world.tool(name))
    rng = random_stream(seed, "assist", label, name)
    return Hand(world, plan_hand_path(world, label, name, setting, rng, style, world.state(name)[0]))


def resting_posture(arm: Arm) -> Array:
    """Joints (n,), rad, from which searches begin: the arm's posture for teaching, else the middle of its limits."""
    for name in _POSTURES:
        if name in arm.configurations:
            return arm.configuration(name)
    limits = arm.limits
    middle: Array = 0.5 * (np.maximum(limits.lower, -np.pi) + np.minimum(limits.upper, np.pi))
    return middle


def _check_workspace(task: TaskDescription, label: str, positions: Array) -> None:
    excess = workspace_excess(task, positions)
    if excess > 0.0:
        raise UnreachableError(
            f"the hand's path of {label!r} would leave the workspace of task {task.name!r} by {1e3 * excess:.0f} mm."
        )


def _check_reach(label: str, arm: str, time: Array, positions: Array, joints: JointPath) -> None:
    if joints.found:
        return
    worst = int(np.argmax(joints.position_error + 0.1 * joints.rotation_error))
    place = ", ".join(f"{value:.3f}" for value in positions[worst])
    raise UnreachableError(
        f"the {arm} arm cannot be led through {label!r}: at {time[worst]:.2f} s the hand would be at ({place}) m, "
        f"which the tool misses by {1e3 * joints.position_error[worst]:.0f} mm and {joints.rotation_error[worst]:.2f} "
        f"rad. Bring the objects or the start nearer to where the task draws them."
    )


def _check_room(label: str, arm: Arm, time: Array, joints: JointPath) -> None:
    """The path keeps away from limits, singularities and the joints' speed limits."""
    speed = np.abs(np.diff(joints.samples, axis=0)) / np.diff(time)[:, None] / arm.limits.velocity
    problems = []
    if joints.limit_margin < LIMIT_MARGIN:
        problems.append(f"a joint would be {joints.limit_margin:.3f} rad from its limit (least: {LIMIT_MARGIN})")
    if joints.manipulability < LEAST_MANIPULABILITY:
        problems.append(f"it would be nearly singular ({joints.manipulability:.3f}; least: {LEAST_MANIPULABILITY})")
    if speed.max() > VELOCITY_SHARE:
        problems.append(f"a joint would turn at {speed.max():.2f} of its velocity limit (most: {VELOCITY_SHARE})")
    if problems:
        raise UnreachableError(f"the {arm.name} arm cannot be led through {label!r}: {'; '.join(problems)}.")
