"""Robots as mechanisms: where the tool is, what gravity asks of the motors, how to reach a pose.

Stands between the description of a robot and everything that moves one. The only importer of pinocchio beside
`pft_exec.control`; its index conventions and its shared memory stop here.
"""

from pft_exec.model.arm import Arm, ArmDynamics
from pft_exec.model.arm_geometry import ArmGeometry
from pft_exec.model.inverse_kinematics import InverseKinematics, JointPath, follow_path, solve_inverse_kinematics
from pft_exec.model.limits import JointFriction, JointLimits
from pft_exec.model.link_capsules import LinkCapsule
from pft_exec.model.obstacle import Box, Capsule, Cylinder, Obstacle, Solid, Sphere, task_obstacles
from pft_exec.model.robot_model import RobotModel, load_robot

__all__ = [
    "Arm",
    "ArmDynamics",
    "ArmGeometry",
    "Box",
    "Capsule",
    "Cylinder",
    "InverseKinematics",
    "JointFriction",
    "JointLimits",
    "JointPath",
    "LinkCapsule",
    "Obstacle",
    "RobotModel",
    "Solid",
    "Sphere",
    "follow_path",
    "load_robot",
    "solve_inverse_kinematics",
    "task_obstacles",
]
