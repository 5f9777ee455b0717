"""Grasping: a world set up with what the gripper holds, and a gripper that is worked as a tube says.

`GripperReplay` attends a pursuit: at the phase of each event of the tube it tells the gripper to close or open;
`GripperWait` lets the reference wait until it has. What is held then, `pft_exec.execution.handling` finds in the
physics.
"""

from __future__ import annotations

from collections.abc import Mapping

from pft_exec.demonstration import Scene
from pft_exec.description import Setting, TaskDescription
from pft_exec.execution.pursuit import GO_ON, Instant, Verdict
from pft_exec.geometry import Array
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.simulation import SetUp, World

GRIPPER_CLOSED = "gripper_closed"
"""Name of the discrete variable: 1 while the gripper is told to close."""
GRIPPER_WIDTH = "gripper"
"""Name of the continuous variable, m; it tells motions apart by what the gripper holds, unless that is a substitute."""
SETTLED_SPEED = 0.002
"""m/s of the pads, below which the gripper has closed or opened."""
LEAST_WAIT, MOST_WAIT = 0.25, 1.0
"""s that a gripper is given to close or open: at least, at most."""
_ROUNDING = 1e-9  # of a phase


class GripperReplay:
    """Attends a pursuit of a tube: tells the gripper to close or open when the tube does.

    Parameters
    ----------
    world : World
    name : str
        Of the arm.
    tube : FlowTube
    phase : float
        Where along the tube the pursuit begins; the gripper is told at once what it should be by then.
    """

    def __init__(self, world: World, name: str, tube: FlowTube, phase: float = 0.0) -> None:
        self._world, self._name = world, name
        events = [event for event in tube.events() if event.name == GRIPPER_CLOSED]
        past = [event.value for event in events if event.phase <= phase]
        self._events = events[len(past) :]
        values = [value for value in (tube.initial_values.get(GRIPPER_CLOSED), *past) if value is not None]
        if values:
            self._tell(bool(values[-1]))

    def __call__(self, instant: Instant) -> None:
        while self._events and instant.phase >= self._events[0].phase - _ROUNDING:
            self._tell(bool(self._events.pop(0).value))

    def _tell(self, closed: bool) -> None:
        if self._world.has_gripper(self._name) and closed != self._world.is_gripper_closed(self._name):
            self._world.grip(self._name, closed)


class GripperWait:
    """Supervises a pursuit: the reference waits while the gripper closes or opens.

    Parameters
    ----------
    world : World
    name : str
        Of the arm.
    """

    def __init__(self, world: World, name: str) -> None:
        self._world, self._name = world, name
        self._closed, self._width = world.is_gripper_closed(name), world.gripper(name)
        self._told: float | None = None

    def __call__(self, instant: Instant) -> Verdict:
        del instant
        world, closed = self._world, self._world.is_gripper_closed(self._name)
        if closed != self._closed:
            self._closed, self._told = closed, world.time
        if self._told is None:
            return GO_ON
        since, width, before = world.time - self._told, world.gripper(self._name), self._width
        self._width = width
        is_still = abs(width - before) <= SETTLED_SPEED * world.control_period
        if since >= MOST_WAIT or (since >= LEAST_WAIT and is_still):
            self._told = None
            return GO_ON
        return Verdict(0.0, None, "the gripper moves")


def set_up_motion(
    world: World,
    label: str,
    arm: str,
    setting: Setting,
    configuration: Array,
    substitute: Mapping[str, str] | None = None,
) -> None:
    """Set a world up for a motion: objects, arm, and what the gripper holds when it (or what it follows) begins."""
    task, now = world.task, substitute or {}
    motion = task.motion(task.chain(label)[0])
    set_up = SetUp(
        holding={} if motion.holds is None else {arm: now.get(motion.holds.object, motion.holds.object)},
        opened=(arm,) if motion.begins_open else (),
        liquid=None if motion.liquid is None else now.get(motion.liquid, motion.liquid),
    )
    world.reset(Scene(setting.objects), {arm: configuration}, set_up)


def handles_objects(task: TaskDescription) -> bool:
    """Whether any motion of a task works the gripper; then all its demonstrations say what the gripper does."""
    return any(motion.moves_gripper for motion in task.motions.values())
