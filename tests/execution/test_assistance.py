"""The hand begins, the robot recognizes, takes over and finishes; in doubt it asks; what it does not know it leaves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pft_exec.exceptions import UnknownMotionError, UnreachableError
from pft_exec.execution import ExecutionLog, Stage, assist, prepare
from pft_exec.execution.assistance import LET_GO
from pft_exec.execution.candidates import Candidate
from pft_exec.execution.companion import SOON
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.takeover import Takeover, plan_takeover
from pft_exec.geometry import Array
from pft_exec.handoff import PolicySettings
from pft_exec.handoff.moving_frame import JointState
from pft_exec.learning import MotionLibrary, learn_library
from pft_exec.model import Arm
from pft_exec.recognition import Belief
from pft_exec.simulation import World

NEVER = PolicySettings(least_time=100.0, ask_time=100.0)
ALWAYS_ASK = PolicySettings(
    threshold=0.999999, hold_time=60.0, least_phase=0.1, ask_margin=1e-12, ask_time=0.0, unknown_limit=0.999
)


@pytest.fixture(scope="module")
def log(shared_world: World, library: MotionLibrary) -> ExecutionLog:
    prepare(shared_world, "reach", seed=3)
    return assist(shared_world, library, "reach", seed=3)


def test_the_motion_is_taken_over_and_finished(log: ExecutionLog) -> None:
    assert log.label == "reach"
    assert log.success, log.reason
    assert log.details["take_over_share"] < 0.6


def test_belief_and_stages_tell_the_same_moment(log: ExecutionLog) -> None:
    taken = log.event("take_over")
    assert taken is not None
    assert log.time[log.stage == Stage.GUIDED].max() < taken.time
    assert log.time[log.stage == Stage.TRANSITION].min() == pytest.approx(taken.time)
    assert log.belief.probability[-1, log.belief.labels.index("reach")] >= 0.95
    np.testing.assert_allclose(log.belief.probability.sum(axis=1), 1.0)


def test_the_hand_is_gone_after_the_take_over(log: ExecutionLog) -> None:
    assert log.hand_force[log.stage == Stage.GUIDED].max() > 0.0
    taken = log.event("take_over")
    assert taken is not None
    assert not log.hand_force[log.time > taken.time + LET_GO].any()


def test_the_recognizer_is_never_told_the_label(log: ExecutionLog, shared_world: World, library: MotionLibrary) -> None:
    """A library in which the names of two motions are exchanged: the motion is recognized under the other's name."""
    exchanged = {"reach": "move_left", "move_left": "reach"}
    renamed = learn_library(
        replace(item, label=exchanged.get(item.label, item.label))
        for motion in library.motions.values()
        for item in motion.demonstrations
    )
    prepare(shared_world, "reach", seed=3)
    fooled = assist(shared_world, renamed, "reach", seed=3)
    assert fooled.label == "move_left"
    assert not np.isnan(log.details["take_over_time"])
    assert fooled.details["take_over_time"] == pytest.approx(log.details["take_over_time"], abs=0.02)


def test_the_same_seed_gives_the_same_run_bit_for_bit(
    log: ExecutionLog, shared_world: World, library: MotionLibrary
) -> None:
    prepare(shared_world, "reach", seed=3)
    again = assist(shared_world, library, "reach", seed=3)
    for name in ("configuration", "torque", "position", "stage", "hand_force"):
        np.testing.assert_array_equal(getattr(log, name), getattr(again, name))
    np.testing.assert_array_equal(log.belief.probability, again.belief.probability)


def test_the_other_arm_does_the_same_in_the_mirror_image(
    log: ExecutionLog, shared_world: World, library: MotionLibrary
) -> None:
    setting = prepare(shared_world, "reach", seed=3)
    plane = shared_world.base
    scene = shared_world.scene.mirrored(plane)
    prepare(shared_world, "reach", "left", scene=scene, start=setting.start.mirrored(plane))
    mirrored = assist(shared_world, library.mirrored(plane), "reach", "left", seed=3)
    assert mirrored.label == "reach"
    assert mirrored.success, mirrored.reason
    np.testing.assert_allclose(mirrored.position[-1], log.position[-1] * [1.0, -1.0, 1.0], atol=0.005)


def test_a_person_who_is_asked_decides(shared_world: World, library: MotionLibrary) -> None:
    asked: list[tuple[str, ...]] = []

    def answer(labels: tuple[str, ...], belief: Belief) -> str | None:
        asked.append(labels)
        assert belief.probability[labels[0]] >= belief.probability[labels[1]]
        return "reach" if "reach" in labels else None

    prepare(shared_world, "reach", seed=3)
    log = assist(shared_world, library, "reach", seed=3, settings=ALWAYS_ASK, answer=answer)
    assert asked
    assert log.details["asked"] == len(asked)
    assert log.label == "reach"
    assert log.event("ask") is not None


def test_a_way_that_would_stray_from_the_tube_waits_for_a_better_moment(
    log: ExecutionLog, shared_world: World, library: MotionLibrary, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks: list[float] = []

    def away_at_first(takeover: Takeover, arm: Arm) -> Array:
        looks.append(shared_world.time)
        return np.array([[0.03, 0.1], [0.06, 0.06], [0.03, 0.04]][min(len(looks), 3) - 1])

    monkeypatch.setattr(Takeover, "distances", away_at_first)
    prepare(shared_world, "reach", seed=3)
    later = assist(shared_world, library, "reach", seed=3)
    assert later.success, later.reason
    assert later.details["take_over_time"] == pytest.approx(log.details["take_over_time"] + 2 * SOON)


def test_a_transition_onto_a_tube_near_by_does_not_stray(shared_world: World, library: MotionLibrary) -> None:
    prepare(shared_world, "reach", seed=3)
    loop = ControlLoop(shared_world)
    candidate = Candidate(loop, library["reach"].flow_tube(shared_world.scene, shared_world.tool()), 0.1)
    planned = plan_takeover(loop, candidate, 0.0, starting=0.3)
    near = planned.distances(loop.arm)
    assert near.max() - near[0] < 0.005
    gone_round = replace(planned, transition=replace(planned.transition, duration=1.0, _path=_aside(planned)))
    far = gone_round.distances(loop.arm)
    assert far.max() - far[0] > 0.03


def _aside(planned: Takeover) -> Callable[[float], JointState]:
    """A way onto the tube that turns the first joint by 0.1 rad and back on the way."""

    def at(time: float) -> JointState:
        q, v, a = planned.transition.end
        return q + 0.1 * np.sin(np.pi * time) * np.eye(len(q))[0], v, a

    return at


def test_a_motion_that_is_never_taken_over_is_the_hands(shared_world: World, library: MotionLibrary) -> None:
    prepare(shared_world, "move_left", seed=3)
    log = assist(shared_world, library, "move_left", seed=3, settings=NEVER)
    assert not log.success
    assert log.label == ""
    assert "the hand finished by itself" in log.reason
    assert set(log.stage) == {Stage.GUIDED}


def test_a_motion_that_was_not_taught_is_declined(shared_world: World, library: MotionLibrary) -> None:
    known = MotionLibrary({label: library[label] for label in ("put_on_table", "go_home")})
    prepare(shared_world, "move_left", seed=3)
    log = assist(shared_world, known, "move_left", seed=3)
    assert log.label == ""
    declined = log.event("decline")
    assert declined is not None
    assert "none of the motions" in declined.detail


def test_an_unknown_motion_is_refused_with_the_nearest_name(shared_world: World, library: MotionLibrary) -> None:
    with pytest.raises(UnknownMotionError, match="Did you mean 'reach'"):
        assist(shared_world, library, "raech")


def test_a_placement_that_only_the_other_arm_reaches_is_refused_with_the_distance(
    shared_world: World, library: MotionLibrary
) -> None:
    prepare(shared_world, "put_on_table", seed=3)
    scene = shared_world.scene
    start = prepare(shared_world, "put_on_table", "left", seed=3).start
    with pytest.raises(UnreachableError, match=r"nearest placement .* mat at \("):
        prepare(shared_world, "put_on_table", "left", scene=scene)
    prepare(shared_world, "put_on_table", "left", scene=scene, start=start)
    before = shared_world.time
    with pytest.raises(UnreachableError, match=r"'put_on_table' would leave the workspace .* by \d+ mm"):
        assist(shared_world, library.mirrored(shared_world.base), "put_on_table", "left")
    assert shared_world.time == before
