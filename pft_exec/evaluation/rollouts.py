"""Rollouts with random faults: one short run each, all of it drawn from one seed, and what became of it.

Two robots stand free, without a table in the way; a library learned from synthetic people gives short tubes. A rollout
draws robot, posture, motion, how wrong the model is, and one or two faults, and runs; in every fourth a hand leads in a
task, and samples, camera and recognizer have faults too. What is judged is the plant: its
joints as they are, not as the encoders say.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields, replace
from functools import cache
from typing import Any

import numpy as np

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.demonstration.synthetic import human_path
from pft_exec.description import load_task, random_stream
from pft_exec.evaluation.assisted_rollouts import DURATION as ASSISTED_DURATION
from pft_exec.evaluation.assisted_rollouts import KINDS as ASSISTED_KINDS
from pft_exec.evaluation.assisted_rollouts import TASKS, run_assisted
from pft_exec.evaluation.witness import TOLERANCE, Witness
from pft_exec.exceptions import UnreachableError
from pft_exec.execution import ExecutionLog, Stage, execute
from pft_exec.execution.control_loop import Observer
from pft_exec.execution.faults import Fault, draw_fault
from pft_exec.geometry import Pose
from pft_exec.learning import MotionLibrary, learn_library
from pft_exec.model import Arm, load_robot
from pft_exec.simulation import ORDINARY, Mismatch, World

ROBOTS = {"pr2": "right", "wam": "arm"}
CONTROL_PERIODS, PHYSICS_STEP = (2e-3, 1e-3), 1e-3
QUICK_SHARE = 0.25
"""Share of the rollouts that are controlled at the second period; most at the first, where less is borne."""
LABELS = ("raise", "sweep", "tilt")
DURATION = 1.2
"""s; about how long a tube is."""
KINDS = (
    "none",
    "solver_fails",
    "solver_nan",
    "encoder_spike",
    "encoder_jump",
    "encoder_nan",
    "encoder_frozen",
    "gripper_opens",
    "push",
    "payload",
    "saturation",
    "beyond_reach",
)
"""Faults of rollouts in which nobody leads; those of the recognizer's stream need a hand."""
ASSISTED = 4
"""One rollout in so many is assisted: a hand leads, and the recognizer's stream has faults too."""
LEAST_STRENGTH = {"pr2": 0.05, "wam": 0.4}
"""Share of their torque that weak motors keep at least: with less they cannot hold the arm's own weight."""
_STRIDE = np.array([0.12, 0.12, 0.1])
"""m; how far a motion goes along each axis at most."""
_UNEXPECTED = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
)


@dataclass(frozen=True)
class Plan:
    """What a rollout does, drawn from its seed.

    Parameters
    ----------
    seed : int
    robot, label : str
    posture : tuple of float, rad
        Added to the arm's posture for teaching.
    mismatch : Mismatch
    faults : tuple of Fault
    task : str
        In which a hand leads; empty where nobody does.
    control_period : float, s
    """

    seed: int
    robot: str
    label: str
    posture: tuple[float, ...]
    mismatch: Mismatch
    faults: tuple[Fault, ...]
    task: str = ""
    control_period: float = CONTROL_PERIODS[0]


@dataclass(frozen=True)
class Rollout:
    """What became of a plan.

    Parameters
    ----------
    seed : int
    robot : str
    faults : tuple of str
        Kinds, or "none".
    ending : "finished", "refused", "stopped" or "exception"
    reason : str
    went : "on", "slower", "aside" or "nowhere"
        How it got there: at full pace, slowed down, having given way to a push.
    torque, velocity : float
        Largest share of the limit that any joint had.
    beyond : float, rad
        How far a joint was beyond its hard position limit; negative: the least distance to it.
    is_finite : bool
        Whether every number of the log and of the plant was one.
    duration : float, s
    end_error : float, m
        Between the tool and the tube's end; NaN where it did not finish.
    driven : float
        Largest share of a velocity limit by the controller's own doing: a push may pass it, see `Witness`.
    task : str
        In which a hand led; empty where nobody did.
    trespass : float, rad
        Beyond a hard position limit by the controller's own doing, or too far by a push's: see `Witness`.
    """

    seed: int
    robot: str
    faults: tuple[str, ...]
    ending: str
    reason: str
    went: str
    torque: float
    velocity: float
    beyond: float
    is_finite: bool
    duration: float
    end_error: float
    driven: float = 0.0
    task: str = ""
    trespass: float = 0.0

    @property
    def broken_rules(self) -> tuple[str, ...]:
        """What must never happen and did: torque, velocity, position, finite, exception, reason."""
        rules = {
            "torque": self.torque > 1.0 + TOLERANCE,
            "velocity": self.driven > 1.0 + TOLERANCE,
            "position": self.trespass > TOLERANCE,
            "finite": not self.is_finite,
            "exception": self.ending == "exception",
            "reason": self.ending != "finished" and not self.reason,
        }
        return tuple(name for name, is_broken in rules.items() if is_broken)

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        return {**asdict(self), "broken_rules": list(self.broken_rules)}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Rollout:
        """What `to_dict` gave."""
        own = {field.name: values[field.name] for field in fields(cls)}
        return cls(**{**own, "faults": tuple(own["faults"])})


NOTHING = Rollout(0, "", ("none",), "refused", "", "nowhere", 0.0, 0.0, -np.inf, True, 0.0, np.nan)
"""A rollout that could not begin."""


def draw_plan(seed: int) -> Plan:
    """Draw all of a rollout from its seed."""
    rng = random_stream(seed, "fault", "rollout")
    robot = str(rng.choice(sorted(ROBOTS)))
    mismatch = replace(ORDINARY, seed=seed) if rng.random() < 0.3 else Mismatch(seed=seed)
    task = str(rng.choice(TASKS[robot])) if seed % ASSISTED == ASSISTED - 1 else ""
    faults = _draw_faults(rng, *((ASSISTED_KINDS, ASSISTED_DURATION) if task else (KINDS, DURATION)))
    return Plan(
        seed,
        robot,
        str(rng.choice(load_task(task).labels if task else LABELS)),
        tuple(rng.uniform(-0.15, 0.15, 7).tolist()),
        mismatch,
        tuple(_possible(fault, robot) for fault in faults),
        task,
        CONTROL_PERIODS[int(rng.random() < QUICK_SHARE)],
    )


def _draw_faults(rng: np.random.Generator, kinds: tuple[str, ...], duration: float) -> list[Fault]:
    """One fault or two of some kinds, within a duration, s."""
    count = 2 if rng.random() < 0.25 else 1
    drawn = [str(rng.choice(kinds)) for _ in range(count)]
    return [draw_fault(rng, duration, (kind,)) for kind in drawn if kind != "none"]


def _possible(fault: Fault, robot: str) -> Fault:
    """A drawn fault as it can happen in a rollout: a tube lies where it lies from the start; motors hold the arm."""
    if fault.kind == "beyond_reach":
        return replace(fault, start=0.0)
    if fault.kind == "saturation":
        return replace(fault, size=max(fault.amount, LEAST_STRENGTH[robot]))
    return fault


def roll_out(seed: int) -> Rollout:
    """Draw a rollout, run it, and judge it."""
    return run_plan(draw_plan(seed))[0]


def run_plan(plan: Plan) -> tuple[Rollout, ExecutionLog | None]:
    """Run a plan; what became of it, and its log unless an exception came out of the loop."""
    witnesses: list[Witness] = []

    def witness(world: World) -> Observer:
        name = world.arm_name()
        witnesses.append(Witness(name, world.arm(name)))
        return witnesses[-1].look

    try:
        log = _run(plan, witness)
    except UnreachableError as error:
        if witnesses:
            return _judged(plan, witnesses[-1], None, f"{type(error).__name__}: {error}"), None
        return replace(NOTHING, seed=plan.seed, robot=plan.robot, task=plan.task, reason=str(error)), None
    except _UNEXPECTED as error:
        seen = witnesses[-1] if witnesses else Witness("", load_robot(plan.robot).arm(ROBOTS[plan.robot]))
        return _judged(plan, seen, None, f"{type(error).__name__}: {error}"), None
    return _judged(plan, witnesses[-1], log), log


def _run(plan: Plan, witness: Callable[[World], Observer]) -> ExecutionLog:
    if plan.task:
        run = plan.robot, plan.task, plan.label, plan.seed
        return run_assisted(*run, plan.mismatch, plan.faults, witness, plan.control_period)
    arm_name = ROBOTS[plan.robot]
    with _opened(plan.robot, plan.mismatch, plan.control_period) as world:
        arm = world.arm(arm_name)
        world.reset(configurations={arm_name: _resting(arm, plan.posture)})
        tube = _library(plan.robot)[plan.label].flow_tube(Scene(), world.tool(arm_name))
        return execute(world, tube, arm_name, faults=plan.faults, observer=witness(world))


def _judged(plan: Plan, witness: Witness, log: ExecutionLog | None, error: str = "") -> Rollout:
    finite = witness.is_finite and (log is None or _is_finite(log))
    return Rollout(
        seed=plan.seed,
        robot=plan.robot,
        faults=tuple(sorted({fault.kind for fault in plan.faults})) or ("none",),
        ending="exception" if log is None else _ending(log),
        reason=error if log is None else _reason(log),
        went="nowhere" if log is None else _went(log),
        torque=witness.torque,
        velocity=witness.velocity,
        beyond=witness.beyond,
        is_finite=finite,
        duration=0.0 if log is None else float(log.time[-1]),
        end_error=np.nan if log is None else log.details.get("end_position_error", np.nan),
        driven=witness.driven,
        task=plan.task,
        trespass=witness.trespass,
    )


def _ending(log: ExecutionLog) -> str:
    if log.event("stop") is None:
        return "finished" if log.label else "refused"
    was_led = bool((log.stage == Stage.GUIDED).any())
    return "stopped" if was_led or log.event("joined") or "join_time" in log.details else "refused"


def _reason(log: ExecutionLog) -> str:
    """Why it ended: of a stop, what the log's event says."""
    stop = log.event("stop")
    return log.reason if stop is None else stop.detail


def _went(log: ExecutionLog) -> str:
    if log.event("take_back") is not None:
        return "aside"
    return "slower" if log.event("slow") is not None else "on"


def _is_finite(log: ExecutionLog) -> bool:
    names = (
        "configuration",
        "velocity",
        "torque",
        "position",
        "quaternion",
        "reference_position",
        "reference_velocity",
    )
    return all(bool(np.isfinite(getattr(log, name)).all()) for name in names)


def _resting(arm: Arm, offset: tuple[float, ...]) -> np.ndarray:
    """The arm's posture for teaching, a little off."""
    limits = arm.limits
    posture = arm.configuration("teach") + np.array(offset)
    inside: np.ndarray = np.clip(posture, limits.lower + 0.1, limits.upper - 0.1)
    return inside


@contextmanager
def _opened(robot: str, mismatch: Mismatch, control_period: float = CONTROL_PERIODS[0]) -> Iterator[World]:
    """A robot that stands free of the task's table."""
    task = load_task("tabletop")
    aside = replace(task, robot_base=Pose(np.array([-2.0, 0.0, 0.0])))
    with World(
        robot, aside, _scene(), control_period=control_period, physics_step=PHYSICS_STEP, mismatch=mismatch
    ) as world:
        yield world


@cache
def _scene() -> Scene:
    """Some placement of the task's objects; nobody comes near them."""
    with World("pr2", "tabletop", seed=0) as world:
        return world.scene


@cache
def _library(robot: str) -> MotionLibrary:
    """Three short motions that synthetic people make where a robot is taught."""
    rng = random_stream(0, "teach", "rollouts", robot)
    with _opened(robot, Mismatch()) as world:
        name = ROBOTS[robot]
        tool = world.robot.arm(name).forward(world.arm(name).configuration("teach"))
        start = world.base @ tool
    demonstrations = []
    for label in LABELS:
        via, end = start.position + _STRIDE * rng.uniform(-1.0, 1.0, (2, 3))
        for _ in range(3):
            places = np.array([start.position, via, end]) + 0.01 * rng.standard_normal((3, 3))
            places += 0.1 * rng.standard_normal(3)  # wherever they start, they go as far
            path = human_path(places, np.tile(start.quaternion, (3, 1)), np.full(2, 0.5 * DURATION), rng)
            clock = np.arange(0.0, path.duration, 0.01)
            demonstrations.append(Demonstration(label, clock, *path.at(clock)))
    return learn_library(demonstrations)
