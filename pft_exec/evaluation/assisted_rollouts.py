"""Assisted runs with faults: a hand begins a motion of a task, and samples, camera or recognizer go wrong.

The libraries come from what a synthetic person wants, without an arm in its hand: they cost no simulation, and are
learned once in a process.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.description import draw_settings, load_task, random_stream
from pft_exec.exceptions import UnreachableError
from pft_exec.execution import ExecutionLog, assist, prepare
from pft_exec.execution.assistance import LET_GO
from pft_exec.execution.faults import Fault
from pft_exec.execution.hand.hand_path import plan_hand_path
from pft_exec.learning import MotionLibrary, learn_library
from pft_exec.model import load_robot
from pft_exec.simulation import Mismatch, World

TASKS = {"pr2": ("tabletop",), "wam": ("cable", "anchor")}
"""What each robot is assisted in."""
TOOLS = {"pr2": None, "wam": "gripper"}
"""Attachment of each robot."""
DURATION = 2.5
"""s; about how long a hand and then the robot move."""
KINDS = (
    "none",
    "sample_late",
    "sample_repeated",
    "sample_out_of_order",
    "sample_nan",
    "object_lost",
    "object_jump",
    "wrong_recognition",
    "wrong_recognition",
    "push",
    "encoder_spike",
    "encoder_jump",
    "encoder_frozen",
    "solver_fails",
    "payload",
)
"""Faults of these runs."""
_DEMONSTRATIONS = 4
_STEP = 0.01


def run_assisted(
    robot: str,
    task: str,
    label: str,
    seed: int,
    mismatch: Mismatch,
    faults: Sequence[Fault],
    witness: Callable[[World], Callable[[World], None]] | None = None,
    control_period: float = 2e-3,
    let_go: float = LET_GO,
) -> ExecutionLog:
    """Let a hand begin a motion in a scene that nobody taught, and let faults act.

    Parameters
    ----------
    robot, task, label : str
    seed : int
        Of the scene and the person.
    mismatch : Mismatch
    faults : sequence of Fault
    witness : callable or None
        Given the world that was set up; what it returns looks on after every control period.
    control_period : float, s
    let_go : float, s
        For which the hand's force fades out.

    Raises
    ------
    UnreachableError
        Before anything moves, if no drawn scene lets the arm make the motion.
    """
    library = task_library(robot, task)
    model = load_robot(robot, tool=TOOLS[robot])
    with World(model, task, seed=seed, control_period=control_period, physics_step=1e-3, mismatch=mismatch) as world:
        prepare(world, label, seed=seed)
        observer = None if witness is None else witness(world)
        return assist(world, library, label, seed=seed, faults=faults, observer=observer, let_go=let_go)


@cache
def task_library(robot: str, task: str) -> MotionLibrary:
    """Every motion of a task, learned from what a hand wants."""
    with World(load_robot(robot, tool=TOOLS[robot]), task, seed=0) as world:
        return learn_library(item for label in load_task(task).labels for item in _wanted(world, label))


def _wanted(world: World, label: str) -> list[Demonstration]:
    rng = random_stream(0, "teach", label, "assisted rollouts")
    demonstrations: list[Demonstration] = []
    while len(demonstrations) < _DEMONSTRATIONS:
        for setting in draw_settings(world.task, label, _DEMONSTRATIONS, rng):
            try:
                plan = plan_hand_path(world, label, None, setting, rng)
            except UnreachableError:
                continue
            clock = np.arange(0.0, plan.duration, _STEP)
            objects = {name: pose.array for name, pose in setting.objects.items()}
            demonstrations.append(Demonstration(label, clock, *plan.at(clock), objects=objects))
    return demonstrations[:_DEMONSTRATIONS]
