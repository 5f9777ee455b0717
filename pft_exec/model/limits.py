"""What the joints of an arm may do, and the friction that a simulated one has."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pft_exec.description import ArmDescription
from pft_exec.description.urdf import UrdfStructure
from pft_exec.geometry import Array, read_only


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Limits of n joints, each an array (n,) in the order of the arm's joint names.

    Parameters
    ----------
    lower, upper : rad
        Soft limits where the URDF states them (its safety controller), else the hard ones. Plans stay inside.
    velocity, acceleration, jerk : rad/s, rad/s^2, rad/s^3
        Largest absolute values.
    torque : N m
        Largest absolute motor torque; springs come on top.
    hard_lower, hard_upper : rad
        Mechanical stops.
    """

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    torque: Array
    hard_lower: Array
    hard_upper: Array

    def margin(self, q: Array) -> Array:
        """Distance (n,), rad, of a configuration from the nearer limit; negative outside."""
        margin: Array = np.minimum(q - self.lower, self.upper - q)
        return margin


@dataclass(frozen=True, eq=False)
class JointFriction:
    """Friction of n joints: Coulomb (n,), N m, and viscous (n,), N m s/rad."""

    coulomb: Array
    viscous: Array


def joint_limits(description: ArmDescription, urdf: UrdfStructure) -> JointLimits:
    """Gather the limits of an arm's joints from its URDF and its description."""
    joints = [urdf.joints[name] for name in description.joints]
    return JointLimits(
        lower=read_only([joint.soft_lower for joint in joints]),
        upper=read_only([joint.soft_upper for joint in joints]),
        velocity=read_only([joint.velocity for joint in joints]),
        acceleration=read_only(description.acceleration.values),
        jerk=read_only(description.jerk.values),
        torque=read_only([joint.effort for joint in joints]),
        hard_lower=read_only([joint.lower for joint in joints]),
        hard_upper=read_only([joint.upper for joint in joints]),
    )


def joint_friction(description: ArmDescription) -> JointFriction:
    """Friction of an arm's joints from its description."""
    return JointFriction(read_only(description.coulomb.values), read_only(description.viscous.values))
