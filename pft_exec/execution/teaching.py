"""Kinesthetic teaching: a person leads the floating arm through a motion several times, and what it did is recorded.

Each time the objects and the tool's start stand elsewhere. The arm compensates gravity and does not know what is
shown; the hand, a spring and damper at the tool, makes the motion. A demonstration holds where the tool
was, not where the hand wanted it.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from pft_exec.demonstration import Demonstration, Recorder, Scene
from pft_exec.demonstration.recorder import RECORDING
from pft_exec.demonstration.synthetic import HumanStyle
from pft_exec.description import Setting, draw_settings, nominal_setting, random_stream
from pft_exec.exceptions import LearningError, StorageError, UnreachableError
from pft_exec.execution.control_loop import SAMPLE_PERIOD, ControlLoop, Observer
from pft_exec.execution.faults import Fault
from pft_exec.execution.grasping import GRIPPER_CLOSED, GRIPPER_WIDTH, handles_objects
from pft_exec.execution.hand.guiding import GuidingFigures, guiding_figures, lead, lead_there, measure_swivel_drift
from pft_exec.execution.hand.hand_path import Hand, HandPath, plan_hand_paths
from pft_exec.execution.refusal import refusal
from pft_exec.simulation import World, check_reach

__all__ = ["GuidingFigures", "teach"]

Report = Callable[[GuidingFigures], None]


def teach(
    world: World,
    label: str,
    arm: str | None = None,
    count: int = 5,
    *,
    seed: int | None = None,
    scene: Scene | None = None,
    style: HumanStyle | None = None,
    report: Report | None = None,
    observer: Observer | None = None,
    faults: Sequence[Fault] = (),
    record: str | Path | None = None,
) -> list[Demonstration]:
    """Let a synthetic person teach one motion by hand.

    Parameters
    ----------
    world : World
        Set up anew for each demonstration; it is left as the last one ended.
    label : str
    arm : str or None
        None is the only arm, else "right". For an arm that mirrors it, the mirror image of the task is taught.
    count : int
        Number of demonstrations.
    seed : int or None
        Not negative; None is the world's. The same seed gives the same demonstrations, bit for bit. Placements that any
        seed teaches are none that `World.draw_scene` draws (`pft_exec.description.random_stream`).
    scene : Scene or None
        Objects for every demonstration; None draws them anew each time.
    style : HumanStyle or None
        How the person moves.
    report : callable or None
        Given the `GuidingFigures` of each demonstration. The first path is then led out and back beforehand, to see how
        far the elbow drifts; the demonstrations are the same.
    observer : callable or None
        Called with the world after every control period.
    faults : sequence of Fault
        Injected in each demonstration (`pft_exec.execution.faults`). One in which the arm had to stop is left out, with
        a warning.
    record : str, Path or None
        A folder, made where there is none, in which each demonstration is written down while it is made, sample by
        sample: a killed process loses none (`recover_recordings`).

    Returns
    -------
    list of Demonstration
        At 100 Hz, with objects, joints and the width of the gripper as continuous variable "gripper", m; in a task
        that grasps, with "gripper_closed" as discrete variable. A motion that follows another is taught from where the
        hand has led the arm through that one.

    Raises
    ------
    UnknownMotionError, UnknownArmError
        If the task has no such motion, or the robot no such arm.
    UnreachableError
        Before anything moves, if the arm cannot be led through the motion in the given scene, with the distance; or
        if the task's placements leave no scene in which it can.
    LearningError
        If `count` is below 1.
    StorageError
        If nothing can be written to `record`.
    """
    if count < 1:
        raise LearningError(f"at least one demonstration is taught; got count={count}.")
    name = world.arm_name(arm)
    lessons = _plan(world, label, name, count, world.seed if seed is None else seed, scene, style)
    drift = 0.0 if report is None else measure_swivel_drift(world, lessons[0][0], lessons[0][1][0])
    demonstrations = []
    for number, (setting, plans) in enumerate(lessons):
        path = None if record is None else recording_path(record, label, name, number)
        loop, demonstration = _demonstrate(world, setting, plans, observer, faults, path)
        if demonstration is None:
            continue
        demonstrations.append(demonstration)
        if report is not None:
            report(guiding_figures(loop, plans[-1], drift))
    return demonstrations


def _plan(
    world: World, label: str, arm: str, count: int, seed: int, scene: Scene | None, style: HumanStyle | None
) -> list[tuple[Setting, list[HandPath]]]:
    """Settings, and the hand's paths in them, which the arm is known to follow; the last one is taught."""
    task = world.task_for(arm)
    task.motion(label)
    if scene is not None:
        _check_scene(world, label, arm, scene)
    person = _Planner(world, label, arm, random_stream(seed, "teach", label, arm, "person"), style)
    placing = random_stream(seed, "teach", label, arm, "placement")
    try:
        objects = None if scene is None else scene.objects
        settings = draw_settings(task, label, count, placing, person.accepts, objects=objects)
    except UnreachableError as error:
        reason = f"{error} {person.refusal}".rstrip()
        if scene is None:
            raise UnreachableError(reason) from error
        raise refusal(world, label, arm, nominal_setting(task, label, scene.objects), reason) from error
    return [(setting, person.plans[id(setting)]) for setting in settings]


def _check_scene(world: World, label: str, arm: str, scene: Scene) -> None:
    """Refuse a scene of the user's that the arm does not reach."""
    task = world.task_for(arm)
    try:
        check_reach(world.arm(arm), task, label, scene)
    except UnreachableError as error:
        raise refusal(world, label, arm, nominal_setting(task, label, scene.objects), str(error)) from error


class _Planner:
    """Plans a path in each setting that is offered, and remembers the paths that the arm follows."""

    def __init__(self, world: World, label: str, arm: str, rng: np.random.Generator, style: HumanStyle | None) -> None:
        self._about = (world, label, arm)
        self._rng, self._style = rng, style
        self._offered: list[Setting] = []  # kept, so that no two share an identity
        self.plans: dict[int, list[HandPath]] = {}
        self.refusal = ""

    def accepts(self, setting: Setting) -> bool:
        self._offered.append(setting)
        try:
            self.plans[id(setting)] = plan_hand_paths(*self._about, setting, self._rng, self._style)
        except UnreachableError as error:
            self.refusal = f"The last one drawn: {error}"
            return False
        return True


def _demonstrate(
    world: World,
    setting: Setting,
    plans: list[HandPath],
    observer: Observer | None,
    faults: Sequence[Fault],
    path: Path | None,
) -> tuple[ControlLoop, Demonstration | None]:
    """One demonstration: set up, make what comes before, let the arm float, let the hand lead, record.

    None where the arm had to stop on the way.
    """
    lead_there(world, setting, plans, observer)
    plan = plans[-1]
    loop = ControlLoop(world, plan.arm, observer=observer, faults=faults)
    with Recorder(plan.label, SAMPLE_PERIOD, path) as recorder:
        if lead(loop, Hand(world, plan), lambda: _record(recorder, loop)):
            return loop, recorder.demonstration()
    warnings.warn(
        f"a demonstration of {plan.label!r} is left out: {loop.guard.reason} at {loop.time:.2f} s.",
        RuntimeWarning,
        stacklevel=3,
    )
    return loop, None


def recording_path(folder: str | Path, label: str, arm: str, number: int) -> Path:
    """Where the recording of a demonstration, counted from 0, is written; its folder is made.

    Raises
    ------
    StorageError
        If the folder cannot be made.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(f"the folder {folder} cannot be made ({error.strerror}).") from error
    return folder / f"{label}_{arm}_{number:03d}{RECORDING}"


def _record(recorder: Recorder, loop: ControlLoop) -> None:
    """One sample: what the arm does and what the camera would see."""
    world, name = loop.world, loop.name
    if loop.guard.doubt > 0.0:
        return  # the next period that has not had a sample takes one
    tool = loop.tool()
    works_gripper = handles_objects(world.task) and world.has_gripper(name)
    recorder.add(
        loop.time,
        tool.position,
        tool.quaternion,
        continuous={GRIPPER_WIDTH: world.gripper(name)},
        discrete={GRIPPER_CLOSED: int(world.is_gripper_closed(name))} if works_gripper else {},
        objects={key: pose.array for key, pose in loop.seen.items()},
        configuration=loop.sense()[0],
    )
