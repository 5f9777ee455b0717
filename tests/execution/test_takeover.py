"""Taking over: what a transition may ask of the joints, and that it does not cut off what the tube does meanwhile."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.description import draw_settings, random_stream
from pft_exec.execution import prepare, takeover
from pft_exec.execution.candidates import Candidate
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.hand.hand_path import plan_hand_paths
from pft_exec.execution.takeover import EASING, SPEED_SHARE, Takeover, frechet_distance, plan_takeover
from pft_exec.handoff import plan_transition
from pft_exec.learning import Motion, MotionLibrary, learn_motion
from pft_exec.model import Arm
from pft_exec.simulation import World

TIMES = np.linspace(0.0, 1.0, 100)


def test_a_transition_leaves_the_feedback_room_below_the_velocity_limits(
    shared_world: World, library: MotionLibrary, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Planned up to the limits themselves, an arm with an unknown payload is driven past them."""
    allowed = []

    def plan(state, target, limits, **settings):
        allowed.append(limits)
        return plan_transition(state, target, limits, **settings)

    monkeypatch.setattr(takeover, "plan_transition", plan)
    shared_world.reset()
    loop = ControlLoop(shared_world, "right")
    tube = library["reach"].flow_tube(shared_world.scene, shared_world.tool("right"))
    planned = plan_takeover(loop, Candidate(loop, tube, 1.0), 0.0, starting=0.5)
    assert planned.transition.found, planned.transition.reason
    assert SPEED_SHARE < 1.0
    for limits in allowed:
        np.testing.assert_allclose(limits.velocity, SPEED_SHARE * loop.arm.limits.velocity)
        np.testing.assert_array_equal(limits.acceleration, loop.arm.limits.acceleration)
    fastest = [np.abs(planned.transition.at(t)[1]) for t in np.linspace(0.0, planned.transition.duration, 100)]
    assert (np.array(fastest) <= SPEED_SHARE * loop.arm.limits.velocity + 1e-6).all()
    assert allowed


def _shaking(world: World) -> Motion:
    """Shakes as hands plan them."""
    rng = random_stream(0, "teach", "shake", "tests of taking over")
    demonstrations = []
    for setting in draw_settings(world.task, "shake", 5, rng):
        plan = plan_hand_paths(world, "shake", "right", setting, rng)[-1]
        time = np.arange(0.0, plan.duration, 0.01)
        objects = {name: pose.array for name, pose in setting.objects.items()}
        demonstrations.append(Demonstration("shake", time, *plan.at(time), objects=objects))
    return learn_motion(demonstrations)


def _highest(planned: Takeover, arm: Arm) -> float:
    """Greatest height, m, base frame, that the tool is led to in the second after a take-over."""
    join, states = planned.transition.duration, (planned.transition.at, planned.trajectory.at)
    postures = [states[0](time)[0] if time < join else states[1](time).configuration for time in TIMES]
    return max(float(arm.forward(posture).position[2]) for posture in postures)


def test_a_take_over_does_not_cut_off_the_far_end_of_a_swing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The arm comes slowly out of the lower end of the first swing, when the tube is thought to be half-way up."""
    with World("pr2", "bottle", seed=0) as world:
        prepare(world, "shake", seed=1)
        loop = ControlLoop(world, "right")
        tube = _shaking(world).flow_tube(world.scene, world.tool())
        height = tube.position[:, 2]
        low = int(np.argmin(height[: len(height) // 2]))
        rising = low + int(np.argmax(height[low:] > height[0]))
        candidate, phase = Candidate(loop, tube, 0.1), float(tube.phase[rising])
        on_tube = plan_takeover(loop, candidate, phase).trajectory
        on_tube.path.extend_until(float(tube.time[-1]))
        behind = on_tube.path.reference(candidate.tube_time(phase) - 0.1, 0.3, 0.0)
        state = behind.configuration, behind.velocity, np.zeros(7)
        monkeypatch.setattr(loop, "sense", lambda: state[:2])
        chasing = takeover._planned(loop, candidate, phase, state, (1.0, 0.0, 0.0))
        planned = plan_takeover(loop, candidate, phase)
        top = max(float(loop.arm.forward(chasing.trajectory.at(t).configuration).position[2]) for t in TIMES)
        assert _highest(chasing, loop.arm) < top - 0.015
        assert abs(_highest(planned, loop.arm) - top) < 0.01
        assert planned.detour(loop.arm) < chasing.detour(loop.arm) - 0.01
        assert planned.trajectory.time_law.starting == EASING


def test_the_frechet_distance_counts_what_is_cut_off_and_what_is_gone_twice() -> None:
    def apart(one: list[float], other: list[float]) -> np.ndarray:
        return np.abs(np.array(one)[:, None] - np.array(other))

    swing = [0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0]
    assert frechet_distance(apart(swing, swing)) == 0.0
    assert frechet_distance(apart(np.repeat(swing, 3).tolist(), swing)) == 0.0, "another tempo"
    assert frechet_distance(apart([0.0, 1.0, 0.5, 0.0], swing)) == 2.0, "cut off"
    assert frechet_distance(apart([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 4.0, 2.0, 0.0], swing)) == 2.0, "beyond"
    assert frechet_distance(apart([0.0, 2.0, 0.0, 2.0, 4.0], [0.0, 1.0, 2.0, 3.0, 4.0])) == 1.0, "gone twice"
