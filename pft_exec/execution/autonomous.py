"""Autonomous execution: from a standstill onto a tube and along it to its end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pft_exec.demonstration import Scene
from pft_exec.description.success import Verdict, judge_motion
from pft_exec.exceptions import InvalidFlowTubeError
from pft_exec.execution.candidates import Candidate
from pft_exec.execution.control_loop import ControlLoop, Observer
from pft_exec.execution.faults import Fault
from pft_exec.execution.log import ExecutionLog
from pft_exec.execution.pursuit import Outcome
from pft_exec.execution.refusal import refusal_here
from pft_exec.execution.safety.force_watch import ForceWatch
from pft_exec.execution.safety.stopping import stop
from pft_exec.execution.safety.watch import pursue
from pft_exec.execution.safety.yielding import give_way
from pft_exec.execution.surroundings import Surroundings
from pft_exec.execution.takeover import Takeover, plan_takeover
from pft_exec.execution.timeliness import undisturbed, warm_up
from pft_exec.geometry import Pose, geodesic_distance
from pft_exec.handoff.take_back import THRESHOLD
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.simulation import Push, World
from pft_exec.simulation.placement import task_for

SOFTNESS = 0.1
"""s^4/m^2; see `pft_exec.control.compute_compliance`."""
STARTING = 0.3
"""s in which a tube comes up to its speed from a standstill."""
END_TOLERANCE = (0.01, 0.05)
"""m, rad; how near to its tube's end a motion must end that no task knows."""

AT_ONCE = 0.2
"""s after it went on within which a force that takes the arm back again was there before."""
IN_VAIN = 3
"""Times in a row for which it may go on so."""


@undisturbed()
def execute(
    world: World,
    flow_tube: FlowTube,
    arm: str | None = None,
    *,
    pushes: Sequence[Push] = (),
    faults: Sequence[Fault] = (),
    pace: float = 1.0,
    take_back: float = THRESHOLD,
    softness: float = SOFTNESS,
    solver: str = "daqp",
    avoid: Sequence[str] = (),
    substitute: Mapping[str, str] | None = None,
    observer: Observer | None = None,
) -> ExecutionLog:
    """Execute a flow tube from where the arm is.

    Parameters
    ----------
    world : World
    flow_tube : FlowTube
        World frame, of the world's present scene.
    arm : str or None
        None is the only arm, else "right".
    pushes : sequence of Push
    faults : sequence of Fault
        Injected while it runs (`pft_exec.execution.faults`); whatever happens then is in the log, nothing is raised.
    pace : float
        Speed relative to the tube's own.
    take_back : float, N
        Force at the tool, felt in the joints, from which the arm gives way to a person; it goes on once they let go.
    softness : float, s^4/m^2
        See `pft_exec.control.compute_compliance`.
    solver : str
        Of the quadratic program.
    avoid : sequence of str
        Objects and furniture of the task to keep off, wherever they move; then the arm keeps off the robot's own
        parts too. What the motion must touch is not to be among them.
    substitute : {name: name}, optional
        Taught object to the one that takes its place, as the tube was asked for; the motion is judged on that one.
    observer : callable or None
        Called with the world after every control period.

    Returns
    -------
    ExecutionLog
        `success` is the task's own predicate where the task knows the motion, else that the tube's end was reached.

    Raises
    ------
    UnreachableError
        Before anything moves, if the tube is beyond the arm's reach; with the nearest placement that would do, where
        the task knows the motion and it is the placement that is at fault.
    UnknownMethodError
        If there is no such solver.
    MissingObjectError
        If the task has no object that is to be avoided.
    InvalidFlowTubeError
        If it is not one tube.
    """
    if not isinstance(flow_tube, FlowTube):
        raise InvalidFlowTubeError(f"one flow tube is executed at a time; got a {type(flow_tube).__name__}.")
    loop = ControlLoop(world, arm, pushes, observer, faults)
    if avoid:
        loop.surroundings = Surroundings(world, loop.name, avoid)
    warm_up(loop, solver)
    scene, start = world.scene, world.tool(loop.name)
    flow_tube = loop.injector.tube(flow_tube)
    candidate = Candidate(loop, flow_tube, softness)
    candidate.path(0.0).extend_until(float(flow_tube.time[-1]))
    takeover = plan_takeover(loop, candidate, 0.0, pace, starting=STARTING)
    if takeover.reason and not faults:
        raise refusal_here(world, flow_tube.label, loop.name, f"{takeover.reason}.", substitute)
    if takeover.reason:
        stop(loop, takeover.reason)
        return loop.log.finish(False, takeover.reason, label=flow_tube.label, **about_run(loop))
    outcome = _carry_out(loop, candidate, takeover, ForceWatch(loop, take_back), pace, solver)
    if outcome.ending != "finished":
        stop(loop, outcome.reason)
    verdict = judge_end(loop, flow_tube, scene, start, substitute)
    return loop.log.finish(
        verdict.success and outcome.ending == "finished",
        told(verdict, outcome),
        label=flow_tube.label,
        details={**end_figures(loop, flow_tube), **takeover.jumps(), "join_time": takeover.transition.duration},
        **about_run(loop),
    )


def _carry_out(
    loop: ControlLoop, candidate: Candidate, takeover: Takeover, force: ForceWatch, pace: float, solver: str
) -> Outcome:
    """Pursue; give way to a person who pushes, and go on from the same phase once they let go."""
    outcome = pursue(loop, takeover, force, solver=solver, floating=False)
    in_vain = 0
    while outcome.ending == "taken_back":
        if not give_way(loop, force, outcome.command):
            return replace(outcome, ending="stopped", reason=loop.guard.reason or "a person keeps the arm")
        takeover = plan_takeover(loop, candidate, outcome.phase, pace)
        if takeover.reason:
            return replace(outcome, ending="stopped", reason=takeover.reason)
        loop.log.event(loop.time, "take_over", f"nobody moves the arm any more: {candidate.label!r} goes on")
        earlier, begin = outcome.fallbacks, loop.time
        outcome = pursue(loop, takeover, force, solver=solver, floating=True)
        outcome = replace(outcome, fallbacks=outcome.fallbacks + earlier)
        in_vain = in_vain + 1 if loop.time - begin < AT_ONCE else 0
        if outcome.ending == "taken_back" and in_vain >= IN_VAIN:
            reason = f"{outcome.reason}, {IN_VAIN} times at once after it went on"
            return replace(outcome, ending="stopped", reason=reason)
    return outcome


def told(verdict: Verdict, outcome: Outcome) -> str:
    """Why a run ended as it did: the task's verdict, and what happened on the way."""
    if outcome.ending != "finished":
        return outcome.reason
    return f"{verdict.reason}; a control period fell back" if outcome.fallbacks else verdict.reason


def about_run(loop: ControlLoop) -> dict[str, str]:
    """The names under which a run is logged."""
    return {"robot": loop.world.robot.name, "task": loop.world.task.name, "arm": loop.name}


def end_figures(loop: ControlLoop, tube: FlowTube) -> dict[str, float]:
    """The tool's end beside the tube's, m and rad; simulated time per computing time; a load's slip and turn."""
    tool = loop.world.true_tool(loop.name)
    turned = 0.0 if tube.quaternion is None else float(geodesic_distance(tube.end.quaternion, tool.quaternion))
    return {
        "end_position_error": float(np.linalg.norm(tool.position - tube.end.position)),
        "end_rotation_error": turned,
        "real_time_factor": loop.real_time_factor,
        **({} if loop.world.held(loop.name) is None else _moved_in_gripper(loop)),
    }


def _moved_in_gripper(loop: ControlLoop) -> dict[str, float]:
    return {"slip": loop.handling.slip, "turned_in_gripper": loop.handling.turned}


def judge_end(
    loop: ControlLoop, tube: FlowTube, scene: Scene, start: Pose, substitute: Mapping[str, str] | None = None
) -> Verdict:
    """Whether the motion did what the task asks for, from the scene and the tool pose in which it began."""
    world = loop.world
    task = task_for(world.robot, world.task, loop.name)
    if tube.label in task.labels:
        ends = start, world.true_tool(loop.name)
        measured = loop.handling.measured()
        return judge_motion(task, tube.label, scene.objects, world.scene.objects, *ends, measured, substitute)
    figures = end_figures(loop, tube)
    distance, turned = figures["end_position_error"], figures["end_rotation_error"]
    reached = distance <= END_TOLERANCE[0] and turned <= END_TOLERANCE[1]
    return Verdict(reached, f"the tool ended {1e3 * distance:.1f} mm and {turned:.3f} rad from the tube's end")
