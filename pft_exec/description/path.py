"""The demonstrator's path: a motion's waypoints and curve as tool poses in one scene, from one start, world frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pft_exec.description.curve import tabulate_curve
from pft_exec.description.motion import START, WORLD, Waypoint
from pft_exec.description.task import TaskDescription
from pft_exec.geometry import Array, Pose, mirror_positions, multiply, read_only, rotate


class Objects(Protocol):
    """Poses of objects by name, world frame: a `Scene`, or a plain mapping."""

    def __getitem__(self, name: str, /) -> Pose:
        """Pose of one object."""


@dataclass(frozen=True, eq=False)
class Waypoints:
    """A motion's tool poses in one scene.

    Parameters
    ----------
    positions : (W + 1, 3), m, world frame
        The start, then the waypoints.
    quaternions : (W + 1, 4), (x, y, z, w), world frame
    durations : (W,), s
        From each to the next, of an average person.
    rests : (W,), s
        After each, the start apart: the hand stands still while the gripper moves; 0 where it runs through.
    grips : tuple of (int, str)
        Index of a waypoint, 1 the first after the start, and what the gripper does there: "close" or "open".
    curve : (M, 3), m, world frame, or None
        Displacement from the last waypoint at even shares of `curve_duration`, s.
    """

    positions: Array
    quaternions: Array
    durations: Array
    rests: Array
    grips: tuple[tuple[int, str], ...] = ()
    curve: Array | None = None
    curve_duration: float = 0.0

    @property
    def end(self) -> Pose:
        """Where the path ends."""
        last = self.positions[-1] if self.curve is None else self.positions[-1] + self.curve[-1]
        return Pose(last, self.quaternions[-1])


def resolve_waypoints(task: TaskDescription, label: str, objects: Objects, start: Pose) -> Waypoints:
    """The tool poses of a motion in one scene.

    Parameters
    ----------
    task : TaskDescription
        As written, or mirrored: then objects and start are those of the mirrored world.
    label : str
    objects : Scene or mapping of name to Pose, world frame
    start : Pose
        Of the tool, world frame.

    Raises
    ------
    UnknownMotionError
        If the task has no such motion.
    MissingObjectError
        If `objects` is a `Scene` that lacks one that a waypoint refers to.
    """
    motion = task.motion(label)
    frames = {name: _mirrored(objects[name], task.mirror) for name in motion.objects}
    frames[START] = _mirrored(start, task.mirror)
    frames[WORLD] = Pose(np.zeros(3))
    poses = [start, *(_mirrored(_resolved(waypoint, frames), task.mirror) for waypoint in motion.waypoints)]
    return Waypoints(
        read_only([pose.position for pose in poses]),
        read_only([pose.quaternion for pose in poses]),
        read_only([waypoint.duration for waypoint in motion.waypoints]),
        read_only([waypoint.rest for waypoint in motion.waypoints]),
        tuple((index, way.gripper) for index, way in enumerate(motion.waypoints, start=1) if way.gripper is not None),
        None if motion.curve is None else read_only(_mirrored_curve(tabulate_curve(motion.curve), task.mirror)),
        0.0 if motion.curve is None else motion.curve.duration,
    )


def nominal_goal(task: TaskDescription, label: str, objects: Objects, start: Pose) -> Pose:
    """Where a motion ends in one scene, if done without error, world frame; parameters as `resolve_waypoints`."""
    return resolve_waypoints(task, label, objects, start).end


def _mirrored(pose: Pose, plane: Pose | None) -> Pose:
    return pose if plane is None else pose.mirrored(plane)


def _resolved(waypoint: Waypoint, frames: dict[str, Pose]) -> Pose:
    position, orientation = waypoint.position, waypoint.orientation
    origin = frames[position.frame]
    offset = np.array(position.offset)
    if position.axes == "own":
        offset = rotate(origin.quaternion, offset)
    turned = multiply(frames[orientation.frame].quaternion, orientation.quaternion)
    return Pose(origin.position + offset - rotate(turned, np.array(position.aim)), turned)


def _mirrored_curve(curve: Array, plane: Pose | None) -> Array:
    """Displacements (M, 3) in the mirrored world."""
    if plane is None:
        return curve
    return mirror_positions(curve, plane) - mirror_positions(np.zeros((1, 3)), plane)
