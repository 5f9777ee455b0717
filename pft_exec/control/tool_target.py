r"""The tool target: forward kinematics of a joint reference, and the measured tool's error from it.

The error is (position in base axes; rotation vector of ``reference^-1 * tool`` in the reference tool frame), as in the
covariance of a tube. Gains and weights of a tube hold in these mixed axes; `ToolTarget` turns them into base axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio

from pft_exec.control.reference import JointReference
from pft_exec.geometry import Array
from pft_exec.model import Arm, ArmDynamics


@dataclass(frozen=True, eq=False)
class ToolTarget:
    """Where the tool should be.

    Parameters
    ----------
    position, quaternion : (3,), m, and (4,), (x, y, z, w), base frame
    rotation : (3, 3)
        Of the tool frame in the base frame.
    velocity, acceleration : (6,), m/s and rad/s, m/s^2 and rad/s^2
        Linear then angular, base frame.
    """

    position: Array
    quaternion: Array
    rotation: Array
    velocity: Array
    acceleration: Array

    def error(self, measured: ArmDynamics) -> Array:
        """Error (12,) of the measured tool, m and rad, then m/s and rad/s; linear in base, angular in tool axes."""
        back = self.rotation.T
        rate = measured.velocity - self.velocity
        error = np.empty(12)
        error[:3] = measured.position - self.position
        error[3:6] = pinocchio.log3(back @ _rotation(measured.quaternion))
        error[6:9] = rate[:3]
        error[9:] = back @ rate[3:]
        return error

    def corrected(self, gain: Array, error: Array) -> Array:
        """Tool acceleration (6,), base frame, that a gain (6, 12) asks for at an error (12,)."""
        answer = gain @ error
        answer[3:] = self.rotation @ answer[3:]
        corrected: Array = self.acceleration - answer
        return corrected

    def weight_in_base(self, weight: Array) -> Array:
        """Weight (6, 6) with angular rows and columns turned from tool into base axes."""
        rotation, turned = self.rotation, weight.copy()
        turned[:, 3:] = turned[:, 3:] @ rotation.T
        turned[3:] = rotation @ turned[3:]
        return turned


def tool_target(arm: Arm, reference: JointReference) -> ToolTarget:
    """Tool target of a joint reference."""
    tool = arm.dynamics(reference.configuration, reference.velocity)
    acceleration = tool.jacobian @ reference.acceleration + tool.jacobian_drift
    return ToolTarget(tool.position, tool.quaternion, _rotation(tool.quaternion), tool.velocity, acceleration)


def _rotation(quaternion: Array) -> Array:
    matrix: Array = pinocchio.Quaternion(quaternion).toRotationMatrix()
    return matrix
