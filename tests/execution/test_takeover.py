"""Taking over: what a transition may ask of the joints."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.execution import takeover
from pft_exec.execution.candidates import Candidate
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.takeover import SPEED_SHARE, plan_takeover
from pft_exec.handoff import plan_transition
from pft_exec.learning import MotionLibrary
from pft_exec.simulation import World


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
