"""The physical world: a robot before a table, driven by joint torques, and the hand that guides it.

Teaching, execution and assistance happen here. The only importer of PyBullet; its conventions stop at this door:
outside are poses with quaternions (x, y, z, w), world frame, and arrays in the order of an arm's joints.
"""

from pft_exec.simulation import banner  # noqa: F401 - first, before PyBullet is imported elsewhere
from pft_exec.simulation.camera import Camera
from pft_exec.simulation.contents import SetUp
from pft_exec.simulation.disturbance import ORDINARY, Mismatch
from pft_exec.simulation.hand import HandGrip, HandGuide, ToolPath
from pft_exec.simulation.placement import check_reach, default_arm, task_for
from pft_exec.simulation.push import Push
from pft_exec.simulation.replay import WorldState, render_states
from pft_exec.simulation.view import VIEWS, View, extent, whole_view
from pft_exec.simulation.world import World

__all__ = [
    "ORDINARY",
    "VIEWS",
    "Camera",
    "HandGrip",
    "HandGuide",
    "Mismatch",
    "Push",
    "SetUp",
    "ToolPath",
    "View",
    "World",
    "WorldState",
    "check_reach",
    "default_arm",
    "extent",
    "render_states",
    "task_for",
    "whole_view",
]
