r"""The tool target: forward kinematics of a joint reference, and the measured tool's error from it.

The error is (position in base axes; rotation vector of ``reference^-1 * tool`` in the reference tool frame), as in the
covariance of a tube. Gains and weights of a tube are turned into base axes for the program.
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
    velocity, acceleration : (6,), m/s and rad/s, m/s^2 and rad/s^2
        Linear then angular, base frame.
    """

    position: Array
    quaternion: Array
    velocity: Array
    acceleration: Array

    @property
    def rotation(self) -> Array:
        """Rotation matrix (3, 3) of the tool in the base frame."""
        matrix: Array = pinocchio.Quaternion(self.quaternion).toRotationMatrix()
        return matrix

    def error(self, measured: ArmDynamics) -> Array:
        """Error (6,), m and rad, of the measured tool, rotation in the target's tool frame."""
        tool = pinocchio.Quaternion(measured.quaternion).toRotationMatrix()
        return np.concatenate([measured.position - self.position, pinocchio.log3(self.rotation.T @ tool)])

    def feedback(self, gain: Array, measured: ArmDynamics) -> Array:
        """Tool acceleration (6,), base frame, that a gain (6, 12) answers the measured tool's error with."""
        rotation = self.rotation
        rate = measured.velocity - self.velocity
        state = np.concatenate([self.error(measured), rate[:3], rotation.T @ rate[3:]])
        answer = gain @ state
        answer[3:] = rotation @ answer[3:]
        feedback: Array = -answer
        return feedback

    def weight_in_base(self, weight: Array) -> Array:
        """Weight (6, 6) with angular rows and columns turned from the tool's into base axes."""
        turn = np.eye(6)
        turn[3:, 3:] = self.rotation
        turned: Array = turn @ weight @ turn.T
        return turned


def tool_target(arm: Arm, reference: JointReference) -> ToolTarget:
    """Tool target of a joint reference."""
    dynamics = arm.dynamics(reference.configuration, reference.velocity)
    acceleration = dynamics.jacobian @ reference.acceleration + dynamics.jacobian_drift
    return ToolTarget(dynamics.position, dynamics.quaternion, dynamics.velocity, acceleration)
