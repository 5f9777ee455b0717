"""An arm that differs from its model, and a tube to follow: what the benchmarks of the controller are measured on.

The arm's rigid-body dynamics with dry and viscous friction, integrated at 1 kHz without a physics engine, so that
nothing but the controller and the stated mismatch is measured.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit

from pft_exec.control import Command, JointTrajectory, TrackingController, plan_joint_trajectory
from pft_exec.geometry import Array, Pose, relative_rotation_vector
from pft_exec.learning import FlowTube
from pft_exec.model import Arm, JointFriction, solve_inverse_kinematics

STEP = 0.001
"""s; physics step."""
PERIOD = 0.002
"""s; control period."""
START = (0.45, -0.30, 0.90)
"""m; where the tube begins, with the tool turned as in the arm's working posture: in the middle of the workspace."""
LENGTH, ARCH, DURATION = 0.18, 0.10, 5.0
"""m, m, s; of the tube: along x, up along z and back."""
SPREAD = (0.0025, 0.05)
"""m; deviation of the tube across it, along y: at its ends, and in its middle."""
_SAMPLES = 100
_PASSES = 20

Force = Callable[[float], Array]
"""From the time, s, to the force (3,), N, at the tool, base frame."""


@dataclass(frozen=True)
class Mismatch:
    """How a plant differs from the model that the controller has.

    Parameters
    ----------
    friction : float
        Factor on the model's joint friction.
    payload : float, kg
        At the tool.
    noise : float, rad
        Standard deviation of the encoders; of the velocities thirty times that, rad/s.
    ripple : float, N m
        Amplitude of the motors' torque ripple, twelve times a turn.
    is_late : bool
        Whether torques act one control period late.
    """

    friction: float = 1.0
    payload: float = 0.0
    noise: float = 0.0
    ripple: float = 0.0
    is_late: bool = False


class Plant:
    """An arm at a configuration and a velocity, integrated step by step.

    Parameters
    ----------
    arm : Arm
    q : (n,), rad
    mismatch : Mismatch
    seed : int
        Of the noise.
    """

    def __init__(self, arm: Arm, q: Array, mismatch: Mismatch | None = None, seed: int = 0) -> None:
        self.mismatch = Mismatch() if mismatch is None else mismatch
        self.arm = arm.with_payload(self.mismatch.payload) if self.mismatch.payload else arm
        self.q, self.v = np.array(q, dtype=float), np.zeros(len(q))
        self._rng = np.random.default_rng([seed, 11])
        self._late: Array | None = None

    @property
    def tool(self) -> Pose:
        """Pose of the tool, base frame."""
        return self.arm.forward(self.q)

    def sense(self) -> tuple[Array, Array]:
        """Configuration and velocity (n,) as the encoders give them, rad and rad/s."""
        noise: Array = self.mismatch.noise * self._rng.standard_normal((2, len(self.q)))
        return self.q + noise[0], self.v + 30.0 * noise[1]

    def act(self, torque: Array, force: Array, steps: int) -> None:
        """Let a motor torque (n,), N m, and a force (3,), N, at the tool act for some physics steps."""
        acting = torque if self._late is None or not self.mismatch.is_late else self._late
        self._late = torque
        for _ in range(steps):
            self._step(acting + self.mismatch.ripple * np.sin(12.0 * self.q), force)

    def _step(self, torque: Array, force: Array) -> None:
        dynamics = self.arm.dynamics(self.q, self.v)
        applied = torque + self.arm.counterbalance(self.q) - dynamics.bias + dynamics.jacobian[:3].T @ force
        viscous = np.asarray(self.mismatch.friction * self.arm.friction.viscous, dtype=float)
        inverse = np.asarray(np.linalg.inv(dynamics.mass_matrix + STEP * np.diag(viscous)), dtype=float)
        free = self.v + STEP * inverse @ (applied - viscous * self.v)
        self.v = _after_dry_friction(free, inverse, self.mismatch.friction * self.arm.friction.coulomb)
        self.q = self.q + STEP * self.v


@njit(cache=True)
def _after_dry_friction(v: Array, inverse: Array, coulomb: Array) -> Array:
    """Velocity (n,), rad/s, after each joint's friction, at most its Coulomb value, worked against it for a step."""
    dry = np.zeros_like(v)
    for _ in range(_PASSES):
        for i in range(len(v)):
            wanted = dry[i] - v[i] / (STEP * inverse[i, i])
            change = min(max(wanted, -coulomb[i]), coulomb[i]) - dry[i]
            dry[i] += change
            v = v + STEP * inverse[:, i] * change
    return v


def with_friction(arm: Arm, coulomb: float, viscous: float = 0.0) -> Arm:
    """The same arm with this friction, N m and N m s/rad, in every joint."""
    other = arm.with_payload(0.0)
    ones = np.ones(len(arm.joint_names))
    other.friction = JointFriction(coulomb * ones, viscous * ones)
    return other


def arch_tube(arm: Arm) -> FlowTube:
    """A tube of 18 cm with an arch of 10 cm, wide across its middle and narrow elsewhere; base frame."""
    s = np.linspace(0.0, 1.0, _SAMPLES)
    along = 10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5
    position = np.array(START) + np.stack([LENGTH * along, 0.0 * s, ARCH * np.sin(np.pi * along)], axis=1)
    deviation = np.full((_SAMPLES, 6), 0.005)
    deviation[:, 1] = SPREAD[0] + (SPREAD[1] - SPREAD[0]) * np.sin(np.pi * s) ** 2
    deviation[:, 3:] = 0.03
    turn = np.tile(arm.forward(arm.configuration("work")).quaternion, (_SAMPLES, 1))
    return FlowTube("arch", DURATION * s, position, turn, deviation[:, :, None] ** 2 * np.eye(6))


def arch_trajectory(arm: Arm, tube: FlowTube) -> JointTrajectory:
    """The joint trajectory along the tube from its start on."""
    start = solve_inverse_kinematics(arm, tube.start, arm.configuration("work"))
    return plan_joint_trajectory(arm, tube, start.configuration)


@dataclass(frozen=True, eq=False)
class Run:
    """What a closed loop did over T control periods.

    Parameters
    ----------
    time : (T,), s
    error : (T, 6), m and rad
        Of the true tool from the reference: position in base axes, rotation vector in the reference tool frame.
    commands : T commands
    plant : Plant
        As it ended.
    """

    time: Array
    error: Array
    commands: tuple[Command, ...]
    plant: Plant


def still(_: float) -> Array:
    """No force."""
    return np.zeros(3)


def run(
    controller: TrackingController,
    plant: Plant,
    duration: float,
    force: Force = still,
    before: Callable[[float], None] | None = None,
) -> Run:
    """Close the loop for a time, s, under a force; `before` is called with the time before each control period."""
    count, steps = round(duration / controller.control_period), round(controller.control_period / STEP)
    time: Array = controller.control_period * np.arange(count, dtype=float)
    error, commands = np.empty((count, 6)), []
    for k, now in enumerate(time):
        if before is not None:
            before(float(now))
        command = controller.update(float(now), *plant.sense())
        tool = plant.tool
        error[k, :3] = tool.position - command.position
        error[k, 3:] = relative_rotation_vector(command.quaternion, tool.quaternion)
        commands.append(command)
        plant.act(command.torque, force(float(now)), steps)
    return Run(time, error, tuple(commands), plant)
