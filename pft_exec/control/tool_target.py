r"""The tool target: forward kinematics of a joint reference, and the measured tool's error from it.

The error is (position in base axes; rotation vector of ``reference^-1 * tool`` in the reference tool frame), as in the
covariance of a tube. Gains and weights of a tube hold in these mixed axes; `ToolTarget` turns them into base axes.
"""

from __future__ import annotations

from dataclasses import dataclass

from pft_exec.control.compliance import Compliance
from pft_exec.control.objectives import Objective
from pft_exec.control.reference import JointReference
from pft_exec.control.tool_kernel import aim, corrected, error_of, matrix_of, weight_in_base
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
        tool = measured.position, measured.quaternion, measured.velocity
        error: Array = error_of(tool, self.position, self.quaternion, self.rotation, self.velocity)
        return error

    def corrected(self, gain: Array, error: Array) -> Array:
        """Tool acceleration (6,), base frame, that a gain (6, 12) asks for at an error (12,)."""
        wanted: Array = corrected(self.rotation, self.acceleration, gain, error)
        return wanted

    def weight_in_base(self, weight: Array) -> Array:
        """Weight (6, 6) with angular rows and columns turned from tool into base axes."""
        turned: Array = weight_in_base(self.rotation, weight)
        return turned

    def shifted(self, shift: tuple[Array, Array, Array]) -> ToolTarget:
        """The target led aside by a position, a velocity and an acceleration (3,), m, m/s and m/s^2, base frame."""
        velocity, acceleration = self.velocity.copy(), self.acceleration.copy()
        velocity[:3] += shift[1]
        acceleration[:3] += shift[2]
        return ToolTarget(self.position + shift[0], self.quaternion, self.rotation, velocity, acceleration)

    def objective(self, compliance: Compliance, phase: float, error: Array, measured: ArmDynamics) -> Objective:
        """Cost of not following, at a phase of a compliance and an error (12,) of the measured tool."""
        gains, mine = (compliance.gain, compliance.weight), (self.rotation, self.acceleration)
        return Objective(*aim(gains, phase, mine, error, measured.jacobian, measured.jacobian_drift))


def tool_target(arm: Arm, reference: JointReference) -> ToolTarget:
    """Tool target of a joint reference."""
    motion = arm.tool_motion(reference.configuration, reference.velocity, reference.acceleration)
    position, quaternion, velocity, acceleration = motion
    return ToolTarget(position, quaternion, matrix_of(quaternion), velocity, acceleration)
