"""The force watch: what friction holds of a force is no person's; what is felt where nobody moves the arm is usual."""

from __future__ import annotations

import numpy as np

from pft_exec.control import GravityCompensation
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.safety.force_watch import BLUNTEST, ForceWatch
from pft_exec.execution.safety.yielding import CALM
from pft_exec.geometry import Array
from pft_exec.handoff import TakeBack
from pft_exec.handoff.take_back import THRESHOLD, USUAL_LIMIT
from pft_exec.simulation import World


def felt_at_rest(world: World, torque: Array, periods: int = 300) -> tuple[ForceWatch, Array]:
    """A watch that has felt an arm at rest which something loads with joint torques (7,), N m; the forces beyond."""
    world.reset()
    loop = ControlLoop(world, "right")
    watch, floating = ForceWatch(loop), GravityCompensation(loop.arm, damping=0.0)
    q, v = loop.sense()
    held = floating.update(0.0, q, 0.0 * v)
    object.__setattr__(held, "torque", held.torque - torque)
    for _ in range(periods):
        watch.feel(q, 0.0 * v, held)
    return watch, watch.beyond_friction(q, 0.0 * v)


def test_what_friction_may_hold_is_nobody(shared_world: World) -> None:
    friction = shared_world.arm("right").friction.coulomb
    watch, beyond = felt_at_rest(shared_world, friction * np.array([1, -1, 1, 1, -1, -1, 1]))
    assert watch.size > 1.0, "it is felt"
    np.testing.assert_allclose(beyond, 0.0, atol=1e-6)


def test_a_hand_that_beats_friction_is_felt_beyond_it(shared_world: World) -> None:
    arm = shared_world.arm("right")
    shared_world.reset()
    pull = np.array([0.0, 0.0, 30.0])
    torque = arm.jacobian(shared_world.state("right")[0])[:3].T @ pull
    _, beyond = felt_at_rest(shared_world, torque)
    assert np.linalg.norm(beyond) > CALM[0]
    assert beyond @ pull > 0.0


def test_the_robot_goes_on_with_what_it_feels_as_usual() -> None:
    watch = TakeBack()
    watch.resume(np.array([0.0, 0.0, -8.0]), 20.0)
    at_once = [watch.update(0.002 * k, np.array([0.0, 0.0, -8.0 - 15.0])) for k in range(10)]
    assert not any(at_once)
    assert any(watch.update(0.1 + 0.002 * k, np.array([0.0, 0.0, -8.0 - 25.0])) for k in range(10))
    watch.resume(np.array([100.0, 0.0, 0.0]), THRESHOLD)
    assert np.linalg.norm(watch.usual) <= USUAL_LIMIT * (1.0 + 1e-9)


def test_a_force_that_fluctuates_never_blunts_the_watch_for_good(shared_world: World) -> None:
    watch, _ = felt_at_rest(shared_world, np.zeros(7))
    watch._variance = 1e6
    watch.go_on()
    assert watch._take_back.threshold == BLUNTEST * THRESHOLD
