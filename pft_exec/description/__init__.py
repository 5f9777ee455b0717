"""Robots and tasks as data: TOML files become frozen dataclasses, strictly.

A robot's folder says what the robot is, a task's folder what is to be done; neither names the other. The model, the
simulator and the demonstrator read them from here. `placement` draws scenes and starts from a task, `path` turns a
motion's waypoints into poses, `clearance` measures free space, `success` judges an end, and `randomness` keeps what
is taught apart from what is evaluated.
"""

from pft_exec.description.arm import ArmDescription, CounterbalanceDescription, Graded, GripperDescription
from pft_exec.description.clearance import hand_clearance, object_clearance, workspace_excess
from pft_exec.description.motion import HeldObject, MotionDescription
from pft_exec.description.object import LiquidDescription, ObjectDescription
from pft_exec.description.path import Waypoints, nominal_goal, resolve_waypoints
from pft_exec.description.placement import (
    Setting,
    draw_scene,
    draw_setting,
    draw_settings,
    nominal_setting,
    path_is_free,
    setting_from,
)
from pft_exec.description.randomness import random_stream
from pft_exec.description.robot import Provenance, RobotDescription, load_robot_description
from pft_exec.description.shape import (
    BoxShape,
    CompoundShape,
    CylinderShape,
    SphereShape,
    TrayShape,
    VesselShape,
)
from pft_exec.description.strict import read_strictly
from pft_exec.description.success import Measured, Verdict, judge_motion
from pft_exec.description.task import TaskDescription, load_task

__all__ = [
    "ArmDescription",
    "BoxShape",
    "CompoundShape",
    "CounterbalanceDescription",
    "CylinderShape",
    "Graded",
    "GripperDescription",
    "HeldObject",
    "LiquidDescription",
    "Measured",
    "MotionDescription",
    "ObjectDescription",
    "Provenance",
    "RobotDescription",
    "Setting",
    "SphereShape",
    "TaskDescription",
    "TrayShape",
    "Verdict",
    "VesselShape",
    "Waypoints",
    "draw_scene",
    "draw_setting",
    "draw_settings",
    "hand_clearance",
    "judge_motion",
    "load_robot_description",
    "load_task",
    "nominal_goal",
    "nominal_setting",
    "object_clearance",
    "path_is_free",
    "random_stream",
    "read_strictly",
    "resolve_waypoints",
    "setting_from",
    "workspace_excess",
]
