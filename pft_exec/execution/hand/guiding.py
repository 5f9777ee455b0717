"""Hand guiding: the arm floats, the hand leads, and figures that say how well the tool followed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.control import GravityCompensation
from pft_exec.description import Setting
from pft_exec.execution.control_loop import ControlLoop, Observer
from pft_exec.execution.grasping import set_up_motion
from pft_exec.execution.hand.hand_path import Hand, HandPath
from pft_exec.execution.log import Stage
from pft_exec.execution.safety.stopping import stop
from pft_exec.geometry import Array
from pft_exec.model import Arm
from pft_exec.simulation import HandGuide, World


@dataclass(frozen=True)
class GuidingFigures:
    """How well one demonstration was led.

    Parameters
    ----------
    label : str
    rms_error, largest_error : float, m
        Between the hand and the tool, over the whole demonstration.
    peak_force : float, N
        Largest force of the hand.
    swivel_drift : float, rad
        Of the elbow, once for all demonstrations that were taught together: see `measure_swivel_drift`.
    duration : float, s
    real_time_factor : float
        Simulated time per computing time; differs from run to run.
    """

    label: str
    rms_error: float
    largest_error: float
    peak_force: float
    swivel_drift: float
    duration: float
    real_time_factor: float


def lead(loop: ControlLoop, hand: Hand, sample: Callable[[], None] | None = None) -> bool:
    """Let the hand lead the floating arm along its whole path; False where the arm had to stop on the way.

    Parameters
    ----------
    loop : ControlLoop
    hand : Hand
    sample : callable or None
        Called at every sample's time, before the arm moves on.
    """
    floating = GravityCompensation(loop.arm, period=loop.world.control_period)
    for _ in range(round(hand.duration / loop.world.control_period) + 1):
        if sample is not None and loop.is_sample_due():
            sample()
        if loop.arm is not floating.arm:
            floating.carry(loop.arm)
        started = perf_counter()
        state = loop.sense()
        if loop.guard.is_lost:
            stop(loop, loop.guard.reason)
            return False
        command = floating.update(loop.time, *state)
        loop.apply(command, Stage.GUIDED, perf_counter() - started, hand.pull)
    return True


def lead_there(
    world: World,
    setting: Setting,
    plans: Sequence[HandPath],
    observer: Observer | None = None,
    substitute: Mapping[str, str] | None = None,
) -> None:
    """Set a world up for the last of several motions: let the hand lead the arm through those before it.

    Parameters
    ----------
    world : World
    setting : Setting
        Of the first of them.
    plans : sequence of HandPath
        As `plan_hand_paths` makes them.
    observer : callable or None
        Called with the world after every control period.
    substitute : {name: name}, optional
        Taught object to the one that takes its place.
    """
    set_up_motion(world, plans[-1].label, plans[-1].arm, setting, plans[0].configuration, substitute)
    for plan in plans[:-1]:
        lead(ControlLoop(world, plan.arm, observer=observer), Hand(world, plan))


def guiding_figures(loop: ControlLoop, plan: HandPath, swivel_drift: float) -> GuidingFigures:
    """The figures of a demonstration that a loop has just made along a planned path."""
    factor = loop.real_time_factor
    log = loop.log.finish(True, "led by hand", label=plan.label)
    error = np.linalg.norm(log.position - plan.at(log.time)[0], axis=1)
    return GuidingFigures(
        label=plan.label,
        rms_error=float(np.sqrt(np.mean(error**2))),
        largest_error=float(error.max()),
        peak_force=float(log.hand_force.max()),
        swivel_drift=swivel_drift,
        duration=float(log.time[-1]),
        real_time_factor=factor,
    )


def measure_swivel_drift(world: World, setting: Setting, plan: HandPath) -> float:
    """How far the elbow has drifted when the tool was led along a path and back again, rad.

    Parameters
    ----------
    world : World
        Set up anew; left as the trial ended.
    setting : Setting
    plan : HandPath

    Returns
    -------
    float
        Rotation of the arm between shoulder and wrist: see `swivel_between`.
    """
    set_up_motion(world, plan.label, plan.arm, setting, plan.configuration)
    loop = ControlLoop(world, plan.arm)
    before = loop.sense()[0]
    lead(loop, Hand(world, plan, HandGuide(_OutAndBack(plan), step=world.physics_step)))
    return swivel_between(loop.arm, before, loop.sense()[0])


def swivel_between(arm: Arm, before: Array, after: Array) -> float:
    """How far the elbow swivels between two configurations (n,), rad, apart from what moves the tool; 0 for n <= 6.

    Notes
    -----
    The change of joints is projected into the null space of the Jacobian; of the links that it turns while the tool
    stays, the one that turns most is the upper arm or forearm, which swivels about the line from shoulder to wrist.
    Its rotation is the sum of the joints' axes up to it (the Jacobian's angular columns) times their part: exact for
    small changes.
    """
    if len(before) <= 6:
        return 0.0
    jacobian = arm.jacobian(0.5 * (before + after))
    null_space = np.linalg.svd(jacobian)[2][6:]
    change = null_space.T @ (null_space @ (after - before))
    turned = np.cumsum(jacobian[3:] * change, axis=1)
    return float(np.linalg.norm(turned, axis=0).max())


@dataclass(frozen=True, eq=False)
class _OutAndBack:
    """A path, and then the same path backwards."""

    path: HandPath

    @property
    def duration(self) -> float:
        return 2.0 * self.path.duration

    def at(self, time: ArrayLike) -> tuple[Array, Array]:
        since = np.asarray(time, dtype=float)
        return self.path.at(np.minimum(since, self.duration - since))
