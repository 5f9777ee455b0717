"""Hand-off: joining a tube from many states, the seams in closed loop, taking back; with the alternative beside it."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from pft_exec.control import Command, TrackingController, joined
from pft_exec.control.reference import JointReference
from pft_exec.evaluation.benchmarks.assisted_seams import FADES, assisted_seam_rows
from pft_exec.evaluation.benchmarks.joining import Start, random_starts
from pft_exec.evaluation.benchmarks.plant import Mismatch, Plant
from pft_exec.evaluation.benchmarks.stopwatch import Tables
from pft_exec.evaluation.protocol import Progress
from pft_exec.geometry import Array, relative_rotation_vector
from pft_exec.handoff import ForceObserver, JointState, TakeBack, Transition, plan_transition
from pft_exec.model import Arm

STATES, LOOPS, PUSHES = 1000, 20, 20
PERIOD = 0.001
"""s; control period and physics step."""
_SETTLED = 0.05  # s after the join that are still looked at
_TAKEN = (
    "felt ms, median",
    "free ms, median",
    "free ms, longest",
    "torque step N m, largest",
    "of slow joints",
    "beyond the push",
)
_HAND = 8.0  # N
_MISMATCHES = {
    "perfect": Mismatch(),
    "friction 20 % wrong": Mismatch(friction=1.2),
    "payload 0.5 kg unknown": Mismatch(payload=0.5),
}
_PUSHED = {
    "10 N": (10.0, Mismatch()),
    "10 N, friction 20 % wrong": (10.0, Mismatch(friction=1.2)),
    "10 N, friction 20 % wrong, noise": (10.0, Mismatch(friction=1.2, noise=1e-4)),
    "none, payload 0.5 kg unknown": (0.0, Mismatch(payload=0.5)),
    "20 N": (20.0, Mismatch()),
    "20 N, friction 20 % wrong": (20.0, Mismatch(friction=1.2)),
    "20 N, friction 20 % wrong, noise": (20.0, Mismatch(friction=1.2, noise=1e-4)),
    "40 N": (40.0, Mismatch()),
    "40 N, friction 20 % wrong": (40.0, Mismatch(friction=1.2)),
}


def measure_handoff(seed: int, progress: Progress) -> Tables:
    """Joining, seams, hands that let go slowly, and taking back, on the PR2's right arm."""
    from pft_exec.model import load_robot

    arm = load_robot("pr2").arm("right")
    progress("states beside random tubes", 0.0)
    starts = random_starts(arm, STATES, seed)
    progress(f"{STATES} transitions", 0.05)
    tables: Tables = {}
    tables[f"joining from {STATES} states within 6 cm and 0.2 rad, at 0.5 to 1.5 of the speed"] = _joining(arm, starts)
    some = starts[:: max(1, len(starts) // LOOPS)][:LOOPS]
    tables[f"the seams in closed loop, {LOOPS} states"] = [
        _seam_row(arm, some, name, mismatch, way, progress)
        for name, mismatch in _MISMATCHES.items()
        for way in ("transition", "none: switch directly")
    ]
    progress("hands that let go slowly", 0.6)
    tables["hands that let go slowly: assisted runs in the world"] = assisted_seam_rows(seed)
    tables["a force of 8 N, anywhere, that begins at the seam and fades out"] = [
        _fade_row(arm, some, fade, seed) for fade in FADES
    ]
    rows = []
    for place, (name, (force, mismatch)) in enumerate(_PUSHED.items()):
        progress(f"taking back: {name}", 0.75 + 0.25 * place / len(_PUSHED))
        rows.append(_take_back_row(arm, some, name, force, mismatch, seed))
    tables["taking back: a push for 0.2 s while the robot has the arm"] = rows
    return tables


def _state(reference: JointReference) -> JointState:
    return reference.configuration, reference.velocity, reference.acceleration


def _plan(arm: Arm, start: Start, way: str = "transition") -> Transition:
    def deviation(time: float, q: Array) -> tuple[Array, Array]:
        return start.place.metric.deviation(arm, start.target.at(time), q)

    return plan_transition(
        (start.q, start.v, 0.0 * start.q),
        lambda t: _state(start.target.at(t)),
        arm.limits,
        deviation=deviation if way == "transition" else None,
    )


def _joining(arm: Arm, starts: list[Start]) -> list[dict[str, Any]]:
    """Plans for all states, with and without regard to the tube; without a plan, the jump is the whole difference."""
    return [_joining_row(arm, starts, way) for way in ("transition", "ruckig's alone")] + [_unplanned(arm, starts)]


def _joining_row(arm: Arm, starts: list[Start], way: str) -> dict[str, Any]:
    """The row of one way to plan."""
    plans, times = [], np.empty(len(starts))
    for k, start in enumerate(starts):
        begin = time.perf_counter()
        plans.append(_plan(arm, start, way))
        times[k] = 1e3 * (time.perf_counter() - begin)
    found = [(start, plan) for start, plan in zip(starts, plans, strict=True) if plan.found]
    seams = np.array([_jumps(start, plan) for start, plan in found])
    rises = np.array([_rise(arm, start, plan) for start, plan in found])
    duration = np.array([plan.duration for _, plan in found])
    return {
        "way": way,
        "found %": 100.0 * len(found) / len(starts),
        "join s, median": float(np.median(duration)),
        "p99": float(np.percentile(duration, 99)),
        "plan ms, median": float(np.median(times)),
        "plan p99": float(np.percentile(times, 99)),
        "jump rad": float(seams[:, 0].max()),
        "jump rad/s": float(seams[:, 1].max()),
        "jump rad/s2 / (jerk x period)": float(seams[:, 2].max()),
        "Mahalanobis rise, largest": float(rises.max()),
        "rise above 0.3, %": 100.0 * float(np.mean(rises > 0.3)),
    }


def _unplanned(arm: Arm, starts: list[Start]) -> dict[str, Any]:
    """The row of a direct switch."""
    here = [(start, _state(start.target.at(0.0))) for start in starts]
    return {
        "way": "none: switch directly",
        "found %": 100.0,
        "join s, median": 0.0,
        "p99": 0.0,
        "plan ms, median": 0.0,
        "plan p99": 0.0,
        "jump rad": float(max(np.abs(on[0] - start.q).max() for start, on in here)),
        "jump rad/s": float(max(np.abs(on[1] - start.v).max() for start, on in here)),
        "jump rad/s2 / (jerk x period)": float(max((np.abs(on[2]) / arm.limits.jerk).max() / PERIOD for _, on in here)),
        "Mahalanobis rise, largest": "-",
        "rise above 0.3, %": "-",
    }


def _jumps(start: Start, plan: Transition) -> tuple[float, float, float]:
    """Largest jumps of position, velocity and acceleration (in jerk limits times period) at the two seams."""
    limits = _limits_of(start)
    before, begin = (start.q, start.v, 0.0 * start.q), plan.at(1e-12)
    arrive, after = plan.at(plan.duration * (1.0 - 1e-12)), _state(start.target.at(plan.duration))
    pairs = ((before, begin), (arrive, after))
    return (
        max(float(np.abs(b[0] - a[0]).max()) for a, b in pairs),
        max(float(np.abs(b[1] - a[1]).max()) for a, b in pairs),
        max(float((np.abs(b[2] - a[2]) / (limits * PERIOD)).max()) for a, b in pairs),
    )


def _limits_of(start: Start) -> Array:
    return start.place.path.arm.limits.jerk


def _distance(arm: Arm, start: Start, q: Array, reference: JointReference) -> float:
    """Mahalanobis distance of the tool from where the tube's is at the same time."""
    tool, on = arm.forward(q), arm.forward(reference.configuration)
    turned = relative_rotation_vector(on.quaternion, tool.quaternion)
    error = np.concatenate([tool.position - on.position, turned])
    precision = start.place.precision
    index = round(reference.phase * (len(precision) - 1))
    return float(np.sqrt(error @ precision[index] @ error))


def _rise(arm: Arm, start: Start, plan: Transition) -> float:
    """How far the planned transition's distance from the tube rises above that of its start."""
    times = np.linspace(0.0, plan.duration, 30)
    distances = [_distance(arm, start, plan.at(t)[0], start.target.at(t)) for t in times]
    return max(distances) - distances[0]


def _follow(arm: Arm, start: Start, way: str) -> tuple[TrackingController, float]:
    """A controller that has just taken over, and the time, s, until it is on the tube."""
    controller = TrackingController(arm, PERIOD)
    plan = _plan(arm, start)
    if way == "transition":
        controller.follow(joined(plan.at, plan.duration, start.target.at), start.place.compliance, 0.0)
    else:
        controller.follow(start.target.at, start.place.compliance, 0.0)
    return controller, plan.duration


def _seam(
    arm: Arm, start: Start, mismatch: Mismatch, way: str, force: Callable[[float], Array] | None = None
) -> tuple[float, float, float]:
    """Largest torque step, N m, rise of the distance from the tube, and the distance at the join, in closed loop."""
    from pft_exec.control import GravityCompensation

    controller, join = _follow(arm, start, way)
    plant = Plant(arm, start.q, mismatch)
    plant.v = np.array(start.v)
    before: Array = GravityCompensation(arm).update(0.0, start.q, start.v).torque
    step = 0.0
    distances: list[float] = []
    for k in range(round((join + _SETTLED) / PERIOD)):
        now = k * PERIOD
        torque = controller.update(now, *plant.sense()).torque
        step, before = max(step, float(np.abs(torque - before).max())), torque
        if now <= join:
            distances.append(_distance(arm, start, plant.q, start.target.at(now)))
        plant.act(torque, np.zeros(3) if force is None else force(now), 1)
    return step, max(distances) - distances[0], distances[-1]


def _seam_row(
    arm: Arm, starts: list[Start], name: str, mismatch: Mismatch, way: str, progress: Progress
) -> dict[str, Any]:
    progress(f"seams: {name}, {way}", 0.1 + 0.2 * list(_MISMATCHES).index(name))
    seen = np.array([_seam(arm, start, mismatch, way) for start in starts])
    return {"plant": name, "way": way, **_told(seen)}


def _told(seen: Array) -> dict[str, float]:
    return {
        "torque step N m, median": float(np.median(seen[:, 0])),
        "torque step, largest": float(seen[:, 0].max()),
        "Mahalanobis rise, largest": float(seen[:, 1].max()),
        "at the join, median": float(np.median(seen[:, 2])),
        "at the join, largest": float(seen[:, 2].max()),
    }


def _fade_row(arm: Arm, starts: list[Start], fade: float, seed: int) -> dict[str, Any]:
    rng, seen = np.random.default_rng([seed, 31]), []
    for start in starts:
        direction = _direction(rng)
        seen.append(_seam(arm, start, Mismatch(), "transition", _fading(_HAND * direction, fade)))
    return {"fade s": fade, **_told(np.array(seen))}


def _fading(force: Array, fade: float) -> Callable[[float], Array]:
    """A force (3,), N, that fades out over some time, s."""
    return lambda now: force * max(0.0, 1.0 - now / fade) if fade > 0.0 else 0.0 * force


def _direction(rng: np.random.Generator) -> Array:
    vector: Array = rng.standard_normal(3)
    return vector / np.linalg.norm(vector)


def _take_back_row(
    arm: Arm, starts: list[Start], name: str, force: float, mismatch: Mismatch, seed: int
) -> dict[str, Any]:
    rng, seen = np.random.default_rng([seed, 37]), []
    for number in range(PUSHES):
        seen.append(_push(arm, starts[number % len(starts)], force * _direction(rng), mismatch, seed + number))
    taken = np.array([row for row in seen if row is not None]).reshape(-1, 5)
    row: dict[str, Any] = {"push": name, "taken back %": 100.0 * len(taken) / PUSHES}
    if not len(taken):
        return row | dict.fromkeys(_TAKEN, "-")
    felt, free = 1e3 * taken[:, 0], 1e3 * taken[:, 1]
    figures = (np.median(felt), np.median(free), free.max(), *taken[:, 2:].max(axis=0))
    return row | {column: float(figure) for column, figure in zip(_TAKEN, figures, strict=True)}


def _push(arm: Arm, start: Start, force: Array, mismatch: Mismatch, seed: int) -> tuple[float, ...] | None:
    """Times from the push to the take-back and to floating, s, and the largest torque steps then; None: not felt.

    The step, N m, is that of any joint's torque from one period to the next: by itself, of joints that the push has not
    brought near their velocity limits, and by how much it is more than the push has put on that joint. Floating means
    less than 0.5 N m left in every joint of what pulled to the tube.
    """
    from pft_exec.execution.safety.yielding import RACING_SHARE, Yielding

    on_tube = start.target.at(0.0)
    controller, plant = TrackingController(arm, PERIOD), Plant(arm, on_tube.configuration, mismatch, seed)
    plant.v = np.array(on_tube.velocity)
    controller.follow(start.target.at, start.place.compliance, 0.0, blend=False)
    observer, take_back, yielding = ForceObserver(arm, PERIOD), TakeBack(), Yielding(arm, PERIOD)
    begin, steps = 0.3, np.zeros(3)
    felt: float | None = None
    command: Command | None = None
    for k in range(600):
        now, (q, v) = k * PERIOD, plant.sense()
        external = observer.update(q, v, None if command is None else command.torque)
        if felt is None and take_back.update(now, external.force, external.sudden):
            felt = now
            yielding.begin(now, command)
        before = command
        command = controller.update(now, q, v) if felt is None else yielding.update(now, q, v)
        if felt is not None and before is not None:
            change = np.abs(command.torque - before.torque)
            slow = change * (np.abs(v) < RACING_SHARE * arm.limits.velocity)
            beyond = change - np.abs(arm.jacobian(q)[:3].T @ force)
            steps = np.maximum(steps, [change.max(), slow.max(), beyond.max()])
            if yielding.is_free:
                return felt - begin, now - begin, *(float(value) for value in steps)
        plant.act(command.torque, force if begin <= now < begin + 0.2 else 0.0 * force, 1)
    return None
