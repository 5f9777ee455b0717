"""Robots and tasks as data: TOML files become frozen dataclasses, strictly.

A robot's folder says what the robot is, a task's folder what is to be done; neither names the other. The model, the
simulator and the demonstrator read them from here.
"""

from pft_exec.description.robot import (
    ArmDescription,
    CounterbalanceDescription,
    Graded,
    GripperDescription,
    Provenance,
    RobotDescription,
    load_robot_description,
)
from pft_exec.description.strict import read_strictly

__all__ = [
    "ArmDescription",
    "CounterbalanceDescription",
    "Graded",
    "GripperDescription",
    "Provenance",
    "RobotDescription",
    "load_robot_description",
    "read_strictly",
]
