"""Each fault comes in where it says, when it says, and as its seed draws it."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.control import QuadraticProgram, Solution
from pft_exec.exceptions import ControlError, UnknownNameError
from pft_exec.execution.faults import KINDS, Fault, FaultInjector, Sample, draw_fault
from pft_exec.execution.log import LogRecorder
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.recognition import Belief
from pft_exec.simulation import World


def injector(world: World, *faults: Fault) -> FaultInjector:
    world.reset()
    return FaultInjector(faults, world, "right", LogRecorder())


def sample(k: int) -> Sample:
    return Sample(0.01 * k, np.full(3, float(k)), np.array([0.0, 0.0, 0.0, 1.0]), {})


def stream(world: World, kind: str, count: int = 20) -> list[list[float]]:
    """Times of the samples that arrive at each sample's time, where a fault acts from the sixth to the tenth."""
    broken = injector(world, Fault(kind, 0.055, 0.05, size=0.02))
    arriving = []
    for k in range(count):
        broken.advance(0.01 * k)
        arriving.append([round(100 * given.time) for given in broken.samples(sample(k))])
    return arriving


def test_without_faults_everything_passes_untouched(shared_world: World) -> None:
    whole = injector(shared_world)
    given, scene = sample(3), shared_world.scene
    assert whole.samples(given) == [given]
    assert whole.scene(scene) is scene
    np.testing.assert_array_equal(whole.force(), np.zeros(3))


def test_a_fault_begins_and_ends_and_is_named_once(shared_world: World) -> None:
    broken = injector(shared_world, Fault("push", 0.1, 0.2, 20.0))
    sizes = []
    for time in (0.0, 0.1, 0.25, 0.31):
        broken.advance(time)
        sizes.append(float(np.linalg.norm(broken.force())))
    np.testing.assert_allclose(sizes, [0.0, 20.0, 20.0, 0.0])
    events = broken._log.finish(True, "over").events
    assert [(event.time, event.name) for event in events] == [(0.1, "fault")]
    assert "20 N" in events[0].detail


def test_late_samples_come_later_with_their_own_time(shared_world: World) -> None:
    arriving = stream(shared_world, "sample_late")
    assert arriving[5] == [5]
    assert arriving[6:11] == [[], [], [6], [7], [8]]
    assert arriving[11] == [11, 9, 10]
    assert arriving[12] == [12]


def test_repeated_samples_come_with_the_one_before(shared_world: World) -> None:
    arriving = stream(shared_world, "sample_repeated")
    assert arriving[6] == [5, 6, 6]
    assert arriving[11] == [11]


def test_samples_out_of_order_change_places(shared_world: World) -> None:
    arriving = stream(shared_world, "sample_out_of_order")
    assert arriving[6:10] == [[], [7, 6], [], [9, 8]]
    assert sorted(time for given in arriving for time in given) == list(range(20))


def test_samples_that_are_no_numbers_keep_their_time(shared_world: World) -> None:
    broken = injector(shared_world, Fault("sample_nan", 0.0, 0.1))
    broken.advance(0.05)
    (given,) = broken.samples(sample(5))
    assert given.time == pytest.approx(0.05)
    assert np.isnan(given.position).all()


@pytest.mark.parametrize(
    ("kind", "expected"),
    [("encoder_jump", 0.2), ("encoder_spike", 0.3), ("encoder_nan", np.nan), ("encoder_frozen", 0.0)],
)
def test_encoders_err_by_what_they_should_and_are_mended(shared_world: World, kind: str, expected: float) -> None:
    broken = injector(shared_world, Fault(kind, 0.1, 0.1, seed=4))
    true = shared_world.true_state("right")[0]
    broken.advance(0.1)
    error = shared_world.state("right")[0] - true
    np.testing.assert_allclose(error[Fault(kind, seed=4).joint(7)], expected)
    broken.advance(0.25)
    np.testing.assert_array_equal(shared_world.state("right")[0], true)


def test_spikes_are_single_readings(shared_world: World) -> None:
    broken = injector(shared_world, Fault("encoder_spike", 0.0, 1.0))
    true, off = shared_world.true_state("right")[0], []
    for k in range(100):
        broken.advance(0.001 * k)
        shared_world.set_encoder("right", broken._read)  # a new instant, without a step
        off.append(bool(np.abs(shared_world.state("right")[0] - true).max() > 0.1))
    assert off == [k % 20 == 0 for k in range(100)]


def test_weak_motors_and_unknown_payloads_come_and_go(shared_world: World) -> None:
    broken = injector(shared_world, Fault("saturation", 0.0, 0.1, 0.1))
    limit = shared_world.arm("right").limits.torque
    strengths = []
    for time in (0.0, 0.2):
        broken.advance(time)
        shared_world.command("right", limit)
        strengths.append(float((shared_world.torque("right") / limit).max()))
    assert strengths == pytest.approx([0.1, 1.0])


def test_a_broken_solver_finds_nothing_or_lies(shared_world: World) -> None:
    class Whole:
        name = "whole"

        def solve(self, program: QuadraticProgram) -> Solution:
            return Solution(True, np.zeros(program.size), np.zeros(len(program.lower)), "solved")

    eye = np.eye(2)
    program = QuadraticProgram(eye, np.zeros(2), eye, -np.ones(4), np.ones(4), np.zeros(4, dtype=bool))
    failing = injector(shared_world, Fault("solver_fails", 0.0, 0.1), Fault("solver_nan", 0.2, 0.1))
    solver = failing.solver(Whole())
    failing.advance(0.05)
    assert not solver.solve(program).found
    failing.advance(0.15)
    np.testing.assert_array_equal(solver.solve(program).x, np.zeros(2))
    failing.advance(0.25)
    lie = solver.solve(program)
    assert lie.found
    assert np.isnan(lie.x).all()


def test_objects_are_lost_and_seen_elsewhere(shared_world: World) -> None:
    name = sorted(shared_world.scene)[0]
    broken = injector(
        shared_world, Fault("object_lost", 0.0, 0.1, name=name), Fault("object_jump", 0.2, 0.1, name=name)
    )
    scene = shared_world.scene
    broken.advance(0.05)
    assert name not in broken.scene(scene)
    broken.advance(0.25)
    moved = broken.scene(scene)[name].position - scene[name].position
    assert np.linalg.norm(moved) == pytest.approx(0.15)


def test_the_recognizer_is_made_sure_of_another_motion(shared_world: World) -> None:
    none = {"reach": 0.0, "go_home": 0.0}
    belief = Belief("reach", {"reach": 0.9, "go_home": 0.1}, 0.2, none, none, none)
    broken = injector(shared_world, Fault("wrong_recognition", 0.1))
    assert broken.belief(belief) is belief
    broken.advance(0.1)
    forced = broken.belief(belief)
    assert forced.label == "go_home"
    assert sum(forced.probability.values()) == pytest.approx(1.0)


def test_a_tube_beyond_reach_lies_farther_from_the_robot(shared_world: World) -> None:
    time = np.linspace(0.0, 1.0, 5)
    position = shared_world.base.position + [0.6, 0.0, 0.8] + 0.0 * time[:, None]
    tube = FlowTube("here", time, position, None, np.tile(1e-4 * np.eye(3), (5, 1, 1)))
    broken = injector(shared_world, Fault("beyond_reach"))
    broken.advance(0.0)
    np.testing.assert_allclose(broken.tube(tube).position - position, np.tile([0.8, 0.0, 0.0], (5, 1)), atol=1e-12)


def test_every_kind_says_what_breaks_and_what_the_arm_does() -> None:
    for name, kind in KINDS.items():
        assert kind.meaning
        assert kind.answer
        assert kind.duration > 0.0
        assert name in str(Fault(name))


def test_drawn_faults_are_the_same_for_the_same_seed() -> None:
    first, again = (draw_fault(np.random.default_rng(5), 2.0) for _ in range(2))
    assert first == again
    drawn = {draw_fault(np.random.default_rng(seed), 2.0).kind for seed in range(300)}
    assert drawn == set(KINDS)


def test_what_is_no_fault_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean 'encoder_jump'"):
        Fault("encoder_jmp")
    with pytest.raises(ControlError, match="at least 0 s"):
        Fault("push", -1.0)
    with pytest.raises(ControlError, match="finite size"):
        Fault("push", size=np.nan)
