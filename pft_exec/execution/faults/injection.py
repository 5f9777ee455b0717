"""Injection: the faults of a run, each let in where it would come in on a real arm."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pft_exec.control import QuadraticProgram, Solution, Solver
from pft_exec.demonstration import Scene
from pft_exec.execution.faults.fault import Fault
from pft_exec.execution.log import LogRecorder
from pft_exec.geometry import Array, Pose
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.recognition import Belief
from pft_exec.simulation import World

SPIKE_EVERY = 0.02
"""s between the readings that are off where single readings are."""
CERTAIN = 0.999
"""Probability of a motion that the recognizer is made to believe in."""


class Sample(NamedTuple):
    """What the recognizer is given: time (s), tool position (3,), quaternion (4,), continuous signals."""

    time: float
    position: Array
    quaternion: Array
    continuous: Mapping[str, float]


class FaultInjector:
    """Let faults act in a world and on what is read from it.

    Parameters
    ----------
    faults : sequence of Fault
    world : World
        As it was set up; the next reset mends what faults did to it.
    arm : str
    log : LogRecorder
        Where each fault's beginning is noted.
    """

    def __init__(self, faults: Sequence[Fault], world: World, arm: str, log: LogRecorder) -> None:
        self.faults = tuple(faults)
        self.time = 0.0
        self._world, self._arm, self._log = world, arm, log
        self._joints = len(world.arm(arm).joint_names)
        self._begun: set[int] = set()
        self._acting: tuple[int, ...] = ()
        self._frozen: tuple[Array, Array] | None = None
        self._waiting: list[Sample] = []
        self._last: Sample | None = None

    def active(self, kind: str) -> list[Fault]:
        """The faults of a kind that act now."""
        return [fault for fault in self.faults if fault.kind == kind and fault.is_active(self.time)]

    def advance(self, time: float) -> None:
        """Let faults begin and end; before each control period."""
        self.time = time
        if not self.faults:
            return
        self._note()
        self._open_gripper()
        acting = tuple(index for index, fault in enumerate(self.faults) if fault.is_active(time))
        if acting != self._acting:
            self._acting = acting
            self._disturb_plant()
            self._disturb_encoders()

    def _note(self) -> None:
        for index, fault in enumerate(self.faults):
            if fault.is_active(self.time) and index not in self._begun:
                self._begun.add(index)
                self._log.event(self.time, "fault", str(fault))

    def _open_gripper(self) -> None:
        gripper = self._world.robot.description.arms[self._arm].gripper
        if gripper is not None and self.active("gripper_opens"):
            self._world.set_gripper(self._arm, gripper.open_width)

    def _disturb_plant(self) -> None:
        if not any(fault.kind in ("payload", "saturation") for fault in self.faults):
            return
        usual = self._world.mismatch
        payload = usual.payload + sum(fault.amount for fault in self.active("payload"))
        strength = min([usual.strength, *(min(fault.amount, 1.0) for fault in self.active("saturation"))])
        self._world.disturb(replace(usual, payload=payload, strength=strength))

    def _disturb_encoders(self) -> None:
        kinds = ("encoder_jump", "encoder_spike", "encoder_nan", "encoder_frozen")
        is_broken = any(self.active(kind) for kind in kinds)
        self._frozen = self._world.state(self._arm) if self.active("encoder_frozen") else None
        self._world.set_encoder(self._arm, self._read if is_broken else None)

    def _read(self, q: Array, v: Array) -> tuple[Array, Array]:
        """What broken encoders report of a configuration and velocity (n,), rad and rad/s."""
        if self._frozen is not None:
            return self._frozen[0].copy(), self._frozen[1].copy()
        q = q.copy()
        for fault in self.active("encoder_jump"):
            q[fault.joint(self._joints)] += fault.amount
        for fault in self.active("encoder_spike"):
            period = self._world.control_period
            if round((self.time - fault.start) / period) % max(2, round(SPIKE_EVERY / period)) == 0:
                q[fault.joint(self._joints)] += fault.amount
        for fault in self.active("encoder_nan"):
            q[fault.joint(self._joints)] = np.nan
        return q, v

    def force(self) -> Array:
        """Force (3,), N, world frame, of what pushes the tool now."""
        force = np.zeros(3)
        for fault in self.active("push"):
            force += fault.amount * fault.direction()
        return force

    def samples(self, sample: Sample) -> list[Sample]:
        """What reaches the recognizer at the time of a sample, in this order."""
        if not self.faults:
            return [sample]
        last, self._last = self._last, sample
        if self.active("sample_nan"):
            sample = sample._replace(position=np.full(3, np.nan))
        if self.active("sample_late"):
            self._waiting.append(sample)
            delay = self.active("sample_late")[0].amount
            return self._arrived(lambda waiting: waiting.time + delay <= sample.time + 1e-9)
        if self.active("sample_out_of_order"):
            self._waiting.append(sample)
            return self._arrived(lambda _: True)[::-1] if len(self._waiting) > 1 else []
        if self.active("sample_repeated") and last is not None:
            return [last, sample, sample]
        return [sample, *self._arrived(lambda _: True)]

    def _arrived(self, has_arrived: Callable[[Sample], bool]) -> list[Sample]:
        arrived = [sample for sample in self._waiting if has_arrived(sample)]
        self._waiting = [sample for sample in self._waiting if not has_arrived(sample)]
        return arrived

    def belief(self, belief: Belief) -> Belief:
        """A belief, or what the recognizer is made to believe."""
        for fault in self.active("wrong_recognition"):
            others = sorted(set(belief.probability) - {belief.label}) or [belief.label]
            label = fault.name or others[int(fault.generator().integers(len(others)))]
            if label in belief.probability:
                rest = (1.0 - CERTAIN) / max(len(belief.probability) - 1, 1)
                probability = {key: CERTAIN if key == label else rest for key in belief.probability}
                belief = replace(belief, label=label, probability=probability, unknown=0.0)
        return belief

    def scene(self, scene: Scene) -> Scene:
        """What the camera sees of a scene."""
        objects = dict(scene.objects)
        for fault in self.active("object_lost"):
            objects.pop(self._object(fault, scene), None)
        for fault in self.active("object_jump"):
            name = self._object(fault, scene)
            if name in objects:
                offset = fault.amount * fault.direction()
                objects[name] = Pose(objects[name].position + offset, objects[name].quaternion)
        return Scene(objects) if self.active("object_lost") or self.active("object_jump") else scene

    def _object(self, fault: Fault, scene: Scene) -> str:
        names = sorted(scene)
        return fault.name or (names[int(fault.generator().integers(len(names)))] if names else "")

    def tube(self, tube: FlowTube) -> FlowTube:
        """A tube (world frame), or one that lies farther from the robot."""
        for fault in self.active("beyond_reach"):
            away = tube.end.position - self._world.base.position
            away[2] = 0.0
            tube = tube.transformed(Pose(fault.amount * away / max(float(np.linalg.norm(away)), 1e-9)))
        return tube

    def solver(self, solver: Solver) -> Solver:
        """A solver that fails where a fault says so."""
        breaks = any(fault.kind in ("solver_fails", "solver_nan") for fault in self.faults)
        return _BrokenSolver(solver, self) if breaks else solver


class _BrokenSolver:
    """A solver that finds nothing, or passes NaN on as a solution, while a fault says so."""

    def __init__(self, solver: Solver, injector: FaultInjector) -> None:
        self.name = solver.name
        self._solver, self._injector = solver, injector

    def solve(self, program: QuadraticProgram) -> Solution:
        nothing = np.full(program.size, np.nan)
        rows = np.zeros(len(program.lower))
        if self._injector.active("solver_fails"):
            return Solution(False, nothing, rows, "the solver found nothing")
        if self._injector.active("solver_nan"):
            return Solution(True, nothing, rows, "solved")
        return self._solver.solve(program)
