r"""One arm as a mechanism: kinematics and dynamics of its joints, tool and springs.

Torques follow one convention everywhere: the plant is
:math:`M(q) \ddot q + C \dot q + g(q) = \tau_{motor} + \tau_{cb}(q) - \tau_{friction} + J^T F`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio
from numpy.typing import ArrayLike

from pft_exec.description import ArmDescription
from pft_exec.exceptions import ConfigurationError, UnknownNameError
from pft_exec.geometry import Array, Pose, read_only
from pft_exec.model.arm_geometry import ArmGeometry
from pft_exec.model.counterbalance import Counterbalance
from pft_exec.model.limits import JointFriction, JointLimits

_AT_TOOL = pinocchio.LOCAL_WORLD_ALIGNED  # origin at the tool, axes of the base


@dataclass(frozen=True, eq=False)
class ArmDynamics:
    """Dynamics of an arm of n joints at one state; not to be changed: whoever asks for the same state shares it.

    Parameters
    ----------
    mass_matrix : (n, n), kg m^2
    bias : (n,), N m
        Coriolis and gravity torque, without counterbalance and friction.
    jacobian : (6, n)
        Linear, then angular velocity of the tool in the base frame, per joint velocity.
    jacobian_drift : (6,), m/s^2 and rad/s^2
        Acceleration of the tool at zero joint acceleration: ``dJ/dt v``, classical.
    position : (3,), m
        Tool in the base frame.
    quaternion : (4,)
        Tool in the base frame, (x, y, z, w).
    velocity : (6,), m/s and rad/s
        Of the tool, linear then angular, in the base frame.
    """

    mass_matrix: Array
    bias: Array
    jacobian: Array
    jacobian_drift: Array
    position: Array
    quaternion: Array
    velocity: Array


class Arm:
    """One arm of a robot; made by `RobotModel.arm`.

    Parameters
    ----------
    description : ArmDescription
        What the robot's folder says of it.
    model : pinocchio.Model
        The arm's n joints alone; all others are held at zero. Never changed.
    limits, friction : JointLimits, JointFriction
    springs : Counterbalance
    shape : callable
        Makes the arm's shape when it is first asked for.

    Notes
    -----
    Configurations `q` are (n,) rad and velocities `v` (n,) rad/s, from base to tool in the order of `joint_names`.
    Not for several threads at once: pinocchio's scratch memory is kept between calls.
    """

    def __init__(
        self,
        description: ArmDescription,
        model: pinocchio.Model,
        limits: JointLimits,
        friction: JointFriction,
        springs: Counterbalance,
        shape: Callable[[], ArmGeometry],
    ) -> None:
        self.description = description
        self.limits = limits
        self.friction = friction
        self._springs = springs
        self._shape_maker = shape
        self._model = model
        self._data = model.createData()
        self._tool = model.getFrameId(description.tool_frame)
        self._shape = (model.nv,)
        self._zero = np.zeros(model.nv)
        self._latest: tuple[bytes, ArmDynamics] | None = None

    @property
    def name(self) -> str:
        """Name of the arm, such as "right"."""
        return self.description.name

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, base to tool."""
        return self.description.joints

    @property
    def tool_frame(self) -> str:
        """Name of the link whose pose `forward` gives."""
        return self.description.tool_frame

    @property
    def mirror_arm(self) -> str | None:
        """Name of the arm on the other side, if there is one."""
        return self.description.mirror_arm

    @property
    def configurations(self) -> tuple[str, ...]:
        """Names that `configuration` knows."""
        return tuple(self.description.configurations)

    def __repr__(self) -> str:
        return f"Arm({self.name!r}, {len(self.joint_names)} joints, tool {self.tool_frame!r})"

    def check_configuration(self, q: ArrayLike) -> None:
        """Refuse a configuration that does not fit.

        Raises
        ------
        ConfigurationError
            If `q` is not (n,).
        """
        self._checked(q)

    def _checked(self, q: ArrayLike, what: str = "configuration q", unit: str = "rad") -> Array:
        values = np.asarray(q, dtype=float)
        if values.shape != self._shape:
            message = f"arm {self.name!r} has {self._shape[0]} joints: {', '.join(self.joint_names)}"
            raise ConfigurationError(f"{message}; its {what} must be ({self._shape[0]},), {unit}, got {values.shape}.")
        return values

    def forward(self, q: ArrayLike) -> Pose:
        """Pose of the tool in the robot's base frame."""
        pose = self._placement(self._checked(q))
        return Pose(pose[:3], pose[3:])

    def _placement(self, q: Array) -> Array:
        pinocchio.forwardKinematics(self._model, self._data, q)
        placement: Array = pinocchio.SE3ToXYZQUAT(pinocchio.updateFramePlacement(self._model, self._data, self._tool))
        return placement

    def jacobian(self, q: ArrayLike) -> Array:
        """Jacobian (6, n) of the tool: linear, then angular velocity in the base frame."""
        jacobian: Array = pinocchio.computeFrameJacobian(
            self._model, self._data, self._checked(q), self._tool, _AT_TOOL
        )
        return jacobian

    def kinematics(self, q: Array) -> tuple[Array, Array, Array]:
        """Position (3,) m, rotation matrix (3, 3) and Jacobian (6, n) of the tool in one pass; `q` is not checked."""
        pinocchio.computeJointJacobians(self._model, self._data, q)
        placement = pinocchio.updateFramePlacement(self._model, self._data, self._tool)
        jacobian = pinocchio.getFrameJacobian(self._model, self._data, self._tool, _AT_TOOL)
        return placement.translation.copy(), placement.rotation.copy(), jacobian

    def tool_motion(self, q: Array, v: Array, acceleration: Array) -> tuple[Array, Array, Array, Array]:
        """How the tool moves where the joints do, in one pass without dynamics; arguments (n,) are not checked.

        Returns
        -------
        position, quaternion : (3,), m, and (4,), (x, y, z, w)
        velocity, acceleration : (6,), m/s and rad/s, m/s^2 and rad/s^2
            Linear, then angular, in the base frame.
        """
        model, data, tool = self._model, self._data, self._tool
        pinocchio.forwardKinematics(model, data, q, v, acceleration)
        placement = pinocchio.SE3ToXYZQUAT(pinocchio.updateFramePlacement(model, data, tool))
        velocity = pinocchio.getFrameVelocity(model, data, tool, _AT_TOOL).vector
        classical = pinocchio.getFrameClassicalAcceleration(model, data, tool, _AT_TOOL).vector
        return placement[:3], placement[3:], velocity, classical

    @property
    def geometry(self) -> ArmGeometry:
        """The arm's shape, for collision avoidance."""
        return self._shape_maker()

    def joint_frames(self, q: Array) -> tuple[Array, Array, Array]:
        """Where the joints' frames are; `q` is not checked.

        Returns
        -------
        rotation, translation : (n, 3, 3) and (n, 3), m
            Of each joint's frame in the base frame.
        jacobian : (6, n)
            Column k: what one rad/s of joint k does to a point of anything it moves: the velocity of the point that is
            at the origin of the base frame, then the angular velocity, in the base frame.
        """
        jacobian = pinocchio.computeJointJacobians(self._model, self._data, q).copy()
        frames = [place.homogeneous for place in self._data.oMi]
        stacked = np.array(frames[1:])
        return stacked[:, :3, :3], stacked[:, :3, 3], jacobian

    def gravity(self, q: ArrayLike) -> Array:
        """Torque (n,), N m, that holds the arm still against gravity, were there no springs."""
        gravity: Array = pinocchio.computeGeneralizedGravity(self._model, self._data, self._checked(q))
        return gravity

    def counterbalance(self, q: ArrayLike) -> Array:
        """Torque (n,), N m, that the springs put on the joints; zero for an arm that has none."""
        return self._springs.torque(self._checked(q))

    def mass_matrix(self, q: ArrayLike) -> Array:
        """Mass matrix (n, n), kg m^2, symmetric."""
        mass_matrix: Array = pinocchio.crba(self._model, self._data, self._checked(q))
        return mass_matrix

    def dynamics(self, q: ArrayLike, v: ArrayLike) -> ArmDynamics:
        """Compute all that a controller needs at one state, in one pass; asked again for that state, say it again."""
        q, v = self._checked(q), self._checked(v, "velocity v", "rad/s")
        state = q.tobytes() + v.tobytes()
        if self._latest is None or self._latest[0] != state:
            self._latest = state, self._compute_dynamics(q, v)
        return self._latest[1]

    def _compute_dynamics(self, q: Array, v: Array) -> ArmDynamics:
        model, data = self._model, self._data
        mass_matrix = pinocchio.crba(model, data, q, pinocchio.Convention.WORLD)  # fills the Jacobians on the way
        bias = pinocchio.nonLinearEffects(model, data, q, v)
        pinocchio.forwardKinematics(model, data, q, v, self._zero)
        placement = pinocchio.SE3ToXYZQUAT(pinocchio.updateFramePlacement(model, data, self._tool))
        jacobian = pinocchio.getFrameJacobian(model, data, self._tool, _AT_TOOL)
        drift = pinocchio.getFrameClassicalAcceleration(model, data, self._tool, _AT_TOOL).vector
        return ArmDynamics(mass_matrix, bias, jacobian, drift, placement[:3], placement[3:], jacobian @ v)

    def configuration(self, name: str) -> Array:
        """Look up a named configuration (n,), rad.

        Raises
        ------
        UnknownNameError
            If the robot's description has none of that name.
        """
        if name not in self.description.configurations:
            raise UnknownNameError("configuration", name, self.configurations, f"The arm is {self.name!r}.")
        return read_only(self.description.configurations[name])

    def mirror_configuration(self, q: ArrayLike) -> Array:
        """Compute the configuration (n,), rad, in which the other arm mirrors this one in the base's xz plane.

        Raises
        ------
        ConfigurationError
            If the arm has no mirror image.
        """
        if self.description.mirror_signs is None:
            raise ConfigurationError(f"arm {self.name!r} has no arm on the other side to mirror to.")
        mirrored: Array = self._checked(q) * np.array(self.description.mirror_signs)
        return mirrored

    def with_payload(self, mass: float, center: ArrayLike = (0.0, 0.0, 0.0)) -> Arm:
        """Make the same arm holding a point mass.

        Parameters
        ----------
        mass : float, kg
            Negative takes a load away.
        center : (3,), m
            Center of mass in the tool frame.

        Raises
        ------
        ConfigurationError
            If mass or center is not finite, or the center is not (3,).
        """
        center = np.asarray(center, dtype=float)
        if center.shape != (3,) or not np.isfinite(np.append(center, mass)).all():
            raise ConfigurationError(f"a payload has a mass, kg, and a center (3,), m; got {mass} and {center}.")
        model = pinocchio.Model(self._model)
        frame = model.frames[self._tool]
        lever = frame.placement.act(center)
        load = pinocchio.Inertia(float(mass), lever, np.zeros((3, 3)))
        model.inertias[frame.parentJoint] = model.inertias[frame.parentJoint] + load
        return Arm(self.description, model, self.limits, self.friction, self._springs, self._shape_maker)
