"""The control loop of one arm: sense, let a command act for one control period, log it.

Teaching under the hand, assistance and autonomous execution all turn this one crank. What acts on the tool from outside
(the hand, a push) enters here, on the side of the physics: no controller sees it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from time import perf_counter

import numpy as np

from pft_exec.control import Command
from pft_exec.execution.faults import Fault, FaultInjector
from pft_exec.execution.handling import Handling
from pft_exec.execution.log import LogRecorder, Stage
from pft_exec.execution.safety.plausibility import StateGuard
from pft_exec.execution.surroundings import Surroundings
from pft_exec.geometry import Array, Pose
from pft_exec.model import Arm
from pft_exec.simulation import Push, World

Pull = Callable[[float], Array]
"""From the time of the run, s, to the wrench (6,) of a hand at the tool now: N and N m, world frame."""
Observer = Callable[[World], None]
"""Called after every control period; a film is made this way."""

SAMPLE_PERIOD = 0.01
"""s; demonstrations are recorded, and motions recognized, at 100 Hz."""


class ControlLoop:
    """Steps one arm of a world by control periods and logs each.

    Parameters
    ----------
    world : World
    arm : str or None
        None is the default arm.
    pushes : sequence of Push
    observer : callable or None
        Called with the world after every control period.
    faults : sequence of Fault
        To be injected; times are on the clock of the run.
    """

    def __init__(
        self,
        world: World,
        arm: str | None = None,
        pushes: Sequence[Push] = (),
        observer: Observer | None = None,
        faults: Sequence[Fault] = (),
    ) -> None:
        self.world = world
        self.name = world.arm_name(arm)
        self.handling = Handling(world, self.name)
        self.log = LogRecorder()
        self.surroundings: Surroundings | None = None
        self._pushes = tuple(pushes)
        self._observer = observer
        self._begin = world.time
        self._wall = perf_counter()
        self._seen: dict[str, Pose] = dict(world.scene.objects)
        self._at_origin = world.base == Pose(np.zeros(3))
        self.injector = FaultInjector(faults, world, self.name, self.log)
        self.guard = StateGuard(self.arm.limits, world.control_period)
        self._sensed: tuple[float, Array, Array] | None = None
        self._is_braking = False
        self.injector.advance(0.0)

    @property
    def arm(self) -> Arm:
        """The model of the arm, with what it holds now."""
        return self.handling.arm

    @property
    def time(self) -> float:
        """Simulated time of the run, s."""
        return self.world.time - self._begin

    @property
    def real_time_factor(self) -> float:
        """Simulated time per computing time of the run so far."""
        return self.time / max(perf_counter() - self._wall, 1e-9)

    def sense(self) -> tuple[Array, Array]:
        """Measured configuration and velocity (n,), rad and rad/s; in place of what cannot be, what is expected."""
        now = self.world.time
        if self._sensed is None or self._sensed[0] != now:
            self._sensed = now, *self.guard.update(*self.world.state(self.name))
        return self._sensed[1].copy(), self._sensed[2].copy()

    def tool(self) -> Pose:
        """Pose of the tool, world frame, by the model from what `sense` says."""
        dynamics = self.arm.dynamics(*self.sense())  # which the controller has computed, or is about to
        pose = Pose(dynamics.position, dynamics.quaternion)
        return pose if self._at_origin else self.world.base @ pose

    @property
    def seen(self) -> Mapping[str, Pose]:
        """Objects as the camera sees them now, world frame; one that is lost stands where it was seen last."""
        self._seen.update(self.injector.scene(self.world.scene).objects)
        return self._seen

    def brake(self) -> None:
        """Let the motors brake by themselves from now on: commands are logged, but do not act."""
        self._is_braking = True
        self.world.brake(self.name, by_motors=True)

    def is_sample_due(self) -> bool:
        """Whether a sample is due now: every `SAMPLE_PERIOD`, on whole control periods."""
        every = max(1, round(SAMPLE_PERIOD / self.world.control_period))
        return round(self.time / self.world.control_period) % every == 0

    def apply(self, command: Command, stage: Stage, tick: float, pull: Pull | None = None, rate: float = 1.0) -> None:
        """Let a command act for one control period, and log it.

        Parameters
        ----------
        command : Command
        stage : Stage
        tick : float, s
            What it took to compute.
        pull : callable or None
            The hand, if it holds the tool.
        rate : float
            Of the reference's clock beside the planned one.
        """
        state, tool = self.sense(), self.tool()
        if not self._is_braking:
            self.world.command(self.name, command.torque)
        for step in range(self.world.steps_per_period):
            force, torque = self._outside(pull)
            if step == 0:
                self._log_row(command, stage, tick, state, tool, force, rate)
            if force.any() or torque.any():
                self.world.push(self.name, force, torque)
            self.world.step()
        if self.is_sample_due():
            self._note_handling()
        if self._observer is not None:
            self._observer(self.world)
        self.injector.advance(self.time)

    def _note_handling(self) -> None:
        """See what the gripper holds; log what has left it, asked for or not."""
        before = self.handling.held
        self.handling.update()
        if before is not None and self.handling.held is None:
            self.log.event(self.time, "released", f"{before!r} has left the gripper")

    def _outside(self, pull: Pull | None) -> tuple[Array, Array]:
        """Force and torque at the tool from outside, (3,) each, N and N m, world frame."""
        time = self.time
        wrench = np.zeros(6) if pull is None else pull(time)
        force = wrench[:3] + self.injector.force()
        for push in self._pushes:
            force += push.force_at(time)
        return force, wrench[3:]

    def _log_row(
        self,
        command: Command,
        stage: Stage,
        tick: float,
        state: tuple[Array, Array],
        tool: Pose,
        force: Array,
        rate: float,
    ) -> None:
        self.log.add(
            command,
            rate,
            time=self.time,
            configuration=state[0],
            velocity=state[1],
            torque=command.torque,
            position=tool.position,
            quaternion=tool.quaternion,
            phase=np.nan if stage in (Stage.GUIDED, Stage.STOPPED) else command.phase,
            reference_position=command.configuration,
            reference_velocity=command.velocity,
            reference_acceleration=command.reference_acceleration,
            stage=stage,
            hand_force=float(np.linalg.norm(force)),
            tick=tick,
        )
