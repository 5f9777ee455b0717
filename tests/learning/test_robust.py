"""The robust method: invariances, covariance, closed motions, and inputs at the edge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2, norm

from pft_exec.demonstration import Demonstration, Scene, convert_recordings
from pft_exec.geometry import Pose, geodesic_distance
from pft_exec.learning import FlowTube, learn_motion
from tests.learning.bottle_motions import LABELS, perform
from tests.learning.taught import TRUTH, lesson, moved, stirring, taught, turned, with_objects


def _tube(demonstrations: list[Demonstration], new: Demonstration) -> FlowTube:
    return learn_motion(demonstrations).flow_tube(new.scene, new.start)


def _gap(one: FlowTube, other: FlowTube) -> float:
    """Greatest distance of the two paths at equal phases, m."""
    return float(np.linalg.norm(one.position - other.position, axis=1).max())


NEW = {label: taught(label, np.random.default_rng(99)) for label in TRUTH}


@pytest.mark.parametrize("label", sorted(TRUTH))
def test_the_tube_of_a_new_scene_begins_at_the_tool_and_ends_where_the_relation_says(label: str) -> None:
    tube = _tube(lesson(label), NEW[label])
    np.testing.assert_allclose(tube.position[0], NEW[label].position[0], atol=1e-9)
    assert np.linalg.norm(tube.position[-1] - NEW[label].position[-1]) < 0.012
    assert geodesic_distance(tube.end.quaternion, NEW[label].end.quaternion) < 0.05


@settings(max_examples=8, deadline=None)
@given(
    angle=st.floats(-3.0, 3.0),
    shift=st.tuples(*[st.floats(-2.0, 2.0)] * 3),
    label=st.sampled_from(["reach", "put_on_table", "move_left"]),
)
def test_a_rigid_motion_of_everything_moves_the_tube_with_it(
    angle: float, shift: tuple[float, float, float], label: str
) -> None:
    transform = Pose(np.array(shift), turned(angle))
    demonstrations, new = lesson(label), NEW[label]
    expected = _tube(demonstrations, new).transformed(transform)
    tube = _tube([moved(d, transform) for d in demonstrations], moved(new, transform))
    assert _gap(tube, expected) < 0.003
    assert tube.quaternion is not None
    assert expected.quaternion is not None
    assert geodesic_distance(tube.quaternion, expected.quaternion).max() < 0.01


@settings(max_examples=5, deadline=None)
@given(factor=st.floats(0.1, 10.0))
def test_time_scaling_does_not_change_the_path(factor: float) -> None:
    demonstrations = lesson("reach")
    slower = [replace(d, time=factor * d.time) for d in demonstrations]
    one, other = _tube(demonstrations, NEW["reach"]), _tube(slower, NEW["reach"])
    assert _gap(one, other) < 1e-9
    np.testing.assert_allclose(other.time, factor * one.time, rtol=1e-9)


@settings(max_examples=5, deadline=None)
@given(order=st.permutations(range(5)))
def test_the_order_of_demonstrations_does_not_matter(order: list[int]) -> None:
    demonstrations = lesson("put_on_table")
    one = _tube(demonstrations, NEW["put_on_table"])
    other = _tube([demonstrations[k] for k in order], NEW["put_on_table"])
    assert _gap(one, other) < 1e-9
    np.testing.assert_allclose(one.covariance, other.covariance, atol=1e-12)


def _idle(d: Demonstration, before: int, after: int) -> Demonstration:
    """The demonstration with resting samples at both ends."""
    index = np.concatenate([np.zeros(before, int), np.arange(len(d)), np.full(after, len(d) - 1)])
    step = d.duration / (len(d) - 1)
    assert d.quaternion is not None
    return replace(
        d,
        time=np.arange(len(index)) * step,
        position=d.position[index],
        quaternion=d.quaternion[index],
        continuous={},
        discrete={},
    )


def test_idle_ends_change_the_path_by_less_than_3_mm() -> None:
    demonstrations = lesson("reach")
    idle = [_idle(d, 20 + 7 * k, 50 - 9 * k) for k, d in enumerate(demonstrations)]
    one, other = _tube(demonstrations, NEW["reach"]), _tube(idle, NEW["reach"])
    assert _gap(one, other) < 0.003
    assert other.duration < 1.1 * one.duration


def test_duplicated_samples_change_the_path_by_less_than_half_a_millimeter() -> None:
    demonstrations = lesson("reach")
    doubled = []
    for d in demonstrations:
        assert d.quaternion is not None
        index = np.repeat(np.arange(len(d)), 2)
        time = np.repeat(d.time, 2) + np.tile([0.0, 1e-6], len(d))
        doubled.append(
            replace(
                d,
                time=time,
                position=d.position[index],
                quaternion=d.quaternion[index],
                continuous={name: values[index] for name, values in d.continuous.items()},
                discrete={name: values[index] for name, values in d.discrete.items()},
            )
        )
    assert _gap(_tube(demonstrations, NEW["reach"]), _tube(doubled, NEW["reach"])) < 5e-4


@pytest.mark.filterwarnings("ignore:the end of 'reach'")
def test_three_demonstrations_of_an_end_that_one_frame_holds_are_not_pulled_away_by_the_others() -> None:
    missed = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        demonstrations = [taught("reach", rng, noise=0.006) for _ in range(3)]
        new = taught("reach", rng, noise=0.0)
        missed.append(np.linalg.norm(_tube(demonstrations, new).position[-1] - new.position[-1]))
    assert np.sqrt(np.mean(np.square(missed))) < 1.05 * 0.006


@settings(max_examples=15, deadline=None)
@given(
    count=st.integers(2, 7),
    samples=st.integers(2, 40),
    planar=st.booleans(),
    turning=st.booleans(),
    seed=st.integers(0, 100),
)
def test_covariances_are_positive_definite(count: int, samples: int, planar: bool, turning: bool, seed: int) -> None:
    rng = np.random.default_rng(seed)
    demonstrations = []
    for d in lesson("reach", seed, count, max(samples, 3)):
        position = d.position + rng.normal(0.0, 0.001, d.position.shape)
        position[:, 2] *= 0.0 if planar else 1.0
        demonstrations.append(replace(d, position=position, quaternion=d.quaternion if turning else None))
    tube = _tube(demonstrations, demonstrations[0])
    np.testing.assert_allclose(tube.covariance, tube.covariance.swapaxes(1, 2))
    assert np.linalg.eigvalsh(tube.covariance).min() > 0.0


def test_two_demonstrations_of_two_samples_make_a_tube() -> None:
    demonstrations = [d.segment(0, 2) for d in lesson("reach", count=2, samples=3)]
    assert np.isfinite(_tube(demonstrations, NEW["reach"]).position).all()


def test_identical_demonstrations_give_themselves() -> None:
    demonstration = lesson("reach")[0]
    tube = _tube([demonstration] * 5, demonstration)
    distance = np.linalg.norm(tube.position[:, None] - demonstration.position[None], axis=-1).min(axis=1)
    assert distance.max() < 0.003
    np.testing.assert_allclose(tube.position[[0, -1]], demonstration.position[[0, -1]], atol=1e-3)


def test_a_tool_that_never_moved_makes_a_tube() -> None:
    still = [replace(d, position=np.zeros((len(d), 3)), quaternion=None) for d in lesson("reach")]
    tube = _tube(still, still[0])
    assert np.abs(tube.position).max() < 1e-9


def test_a_hundred_objects_change_the_path_by_less_than_a_centimeter() -> None:
    demonstrations = lesson("reach")
    many = with_objects([*demonstrations, NEW["reach"]], 100)
    assert _gap(_tube(demonstrations, NEW["reach"]), _tube(many[:5], many[5])) < 0.01


def test_stirring_keeps_its_circles() -> None:
    demonstrations = stirring()
    new = stirring(seed=7)[0]
    tube = _tube(demonstrations, new)
    center = 0.5 * (tube.position[10:-10].min(axis=0) + tube.position[10:-10].max(axis=0))
    radius = np.linalg.norm(tube.position - center, axis=1)
    assert 0.045 <= radius.min() <= radius.max() <= 0.055
    turn = np.unwrap(np.arctan2(*(tube.position - center).T[1::-1]))
    assert abs(turn[-1] - turn[0]) / (2 * np.pi) == pytest.approx(5.0, abs=0.2)


def _straight(rng: np.random.Generator) -> Demonstration:
    """From anywhere straight to above a can."""
    start, can = rng.uniform([0.3, -0.4, 0.2], [0.6, 0.0, 0.4]), rng.uniform([0.4, 0.2, 0.0], [0.8, 0.5, 0.1])
    s = np.linspace(0.0, 1.0, 80)
    u = (10 * s**3 - 15 * s**4 + 6 * s**5)[:, None]
    end = can + np.array([0.0, 0.0, 0.1]) + rng.normal(0.0, 0.002, 3)
    return Demonstration(
        "reach", 2.0 * s, start + u * (end - start), objects={"can": np.append(can, [0.0, 0.0, 0.0, 1.0])}
    )


@pytest.mark.parametrize("count", [2, 3, 4])
@pytest.mark.parametrize("seed", range(3))
def test_two_to_four_straight_demonstrations_make_a_straight_tube(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    demonstrations, new = [_straight(rng) for _ in range(count)], _straight(rng)
    path = _tube(demonstrations, new).position
    along = (path[-1] - path[0]) / np.linalg.norm(path[-1] - path[0])
    offset = path - path[0]
    assert np.linalg.norm(offset - np.outer(offset @ along, along), axis=1).max() < 0.01


def test_the_spread_of_a_relevant_end_is_in_the_covariance() -> None:
    demonstrations = [taught("reach", np.random.default_rng(seed), noise=0.008) for seed in range(5)]
    tube = _tube(demonstrations, NEW["reach"])
    assert 0.005 < np.sqrt(np.trace(tube.covariance[-1, :3, :3]) / 3.0) < 0.016


def test_two_frames_at_one_end_are_fused_and_a_contradiction_is_reported_with_its_distance() -> None:
    motion = learn_motion(lesson("reach"), relevant={"end": ["bottle", "mat"]})
    new = NEW["reach"]
    far = Scene({"bottle": new.scene["bottle"], "mat": Pose(new.scene["mat"].apply([0.0, 3.0, 0.0]))})
    with pytest.warns(RuntimeWarning, match=r"contradict one another .* by [0-9.]+ m"):
        motion.flow_tube(far, new.start)


def test_a_frame_that_never_moved_is_heard_until_it_contradicts() -> None:
    post = np.array([0.42, -0.53, 1.12, 0.0, 0.0, 0.0, 1.0])
    motion = learn_motion([replace(d, objects={"post": post}) for d in lesson("go_home")])
    assert motion.variables.end.position.rivals == ("absolute",)
    moved_post = Pose([0.72, -0.53, 1.12])
    with pytest.warns(RuntimeWarning, match="contradict"):
        tube = motion.flow_tube(Scene({"post": moved_post}), NEW["go_home"].start)
    np.testing.assert_allclose(tube.position[-1], [0.72, -0.5, 1.12], atol=0.01)


def test_a_relevant_start_wins_over_the_tool_and_the_difference_stays() -> None:
    backwards = []
    for d in lesson("put_on_table"):
        assert d.quaternion is not None
        backwards.append(replace(d, position=d.position[::-1], quaternion=d.quaternion[::-1]))
    motion = learn_motion(backwards)
    assert motion.variables.start.position.frame == "mat"
    new = NEW["put_on_table"]
    tube = motion.flow_tube(new.scene, new.start)
    np.testing.assert_allclose(tube.position[0], new.position[-1], atol=0.01)
    assert motion.flow_tube(new.scene).position[0] == pytest.approx(tube.position[0])


def test_signals_and_aligned_demonstrations_are_part_of_the_tube() -> None:
    tube = _tube(lesson("reach"), NEW["reach"])
    assert tube.continuous["width"][[0, -1]] == pytest.approx([0.08, 0.03], abs=1e-3)
    assert (tube.continuous_deviation["width"] > 0.0).all()
    np.testing.assert_allclose(tube.discrete["closed"].sum(axis=1), 1.0)
    assert tube.discrete["closed"][[0, -1], 1] == pytest.approx([1 / 7, 6 / 7])
    assert tube.aligned is not None
    assert tube.aligned.position.shape == (5, len(tube), 3)
    assert (np.diff(tube.aligned.time, axis=1) >= 0.0).all()
    assert tube.count == 5


@pytest.mark.data
def test_left_out_placements_are_predicted_with_honest_uncertainty(recordings) -> None:  # type: ignore[no-untyped-def]
    demonstrations = convert_recordings(recordings / "reach_target.npz")
    inside = []
    for index, new in enumerate(demonstrations):
        others = [d for k, d in enumerate(demonstrations) if k != index]
        for first in range(0, 8, 2):
            tube = _tube([others[(first + k) % 8] for k in range(5)], new)
            share = (new.time - new.time[0]) / new.duration
            mean = np.array([np.interp(share, tube.time / tube.duration, column) for column in tube.position.T[:2]])
            rows = np.array(
                [
                    [np.interp(share, tube.time / tube.duration, tube.covariance[:, a, b]) for b in (0, 1)]
                    for a in (0, 1)
                ]
            )
            off = new.position[:, :2] - mean.T
            squares = np.einsum("ni,nij,nj->n", off, np.linalg.inv(rows.transpose(2, 0, 1)), off)
            inside.append([np.mean(squares <= limit) for limit in chi2.isf(2.0 * norm.sf([1, 2, 3]), 2)])
    one, two, three = np.mean(inside, axis=0)
    assert 0.65 <= one <= 0.76
    assert 0.90 <= two <= 0.97
    assert three >= 0.96


def test_a_constant_axis_stays_constant() -> None:
    flat = [replace(d, position=d.position * [1.0, 1.0, 0.0]) for d in lesson("go_home")]
    tube = _tube(flat, flat[0])
    assert np.abs(tube.position[:, 2]).max() < 1e-9
    assert (tube.covariance[:, 2, 2] > 0.0).all()


def _bottle_tube(label: str, seed: int) -> tuple[FlowTube, Demonstration]:
    rng = np.random.default_rng([seed, LABELS.index(label)])
    *shown, new = [perform(label, rng) for _ in range(6)]
    return learn_motion(shown).flow_tube(new.scene, new.start), new


@pytest.mark.parametrize("seed", range(4))
def test_stirring_with_the_bottle_in_hand_keeps_five_circles_over_the_cup(seed: int) -> None:
    tube, new = _bottle_tube("stir", seed)
    inner = tube.position[10:-10]
    center = 0.5 * (inner.min(axis=0) + inner.max(axis=0))
    radius = np.linalg.norm((tube.position - center)[:, :2], axis=1)
    assert 0.045 <= radius.min() <= radius.max() <= 0.055
    turn = np.unwrap(np.arctan2(*(tube.position - center).T[1::-1]))
    assert (turn[-1] - turn[0]) / (2 * np.pi) == pytest.approx(5.0, abs=0.2)
    cup = new.scene["cup"].position
    assert np.linalg.norm((center - cup - [-0.04, 0.0, 0.24])[:2]) < 0.01


@pytest.mark.parametrize("seed", range(4))
def test_shaking_keeps_four_fifths_of_its_amplitude(seed: int) -> None:
    tube, _ = _bottle_tube("shake", seed)
    height = tube.position[:, 2] - tube.position[0, 2]
    assert height.max() > 0.8 * 0.06
    assert height.min() < -0.8 * 0.06


def test_pouring_back_begins_over_the_cup_wherever_the_tool_is() -> None:
    rng = np.random.default_rng([0, LABELS.index("pour_done")])
    *shown, new = [perform("pour_done", rng) for _ in range(6)]
    elsewhere = Pose(new.start.apply([0.1, -0.1, 0.1]), new.start.quaternion)
    tube = learn_motion(shown).flow_tube(new.scene, elsewhere)
    np.testing.assert_allclose(tube.position[0], new.position[0], atol=0.01)


def test_idle_ends_widen_timing_and_covariance_but_only_where_the_tool_moves() -> None:
    demonstrations = lesson("reach")
    idle = [_idle(d, 15, 15) for d in demonstrations]
    one, other = _tube(demonstrations, NEW["reach"]), _tube(idle, NEW["reach"])
    assert one.time_deviation is not None
    assert other.time_deviation is not None
    spread = (
        np.trace(one.covariance[:, :3, :3], axis1=1, axis2=2),
        np.trace(other.covariance[:, :3, :3], axis1=1, axis2=2),
    )
    assert other.time_deviation[0] > one.time_deviation[0]
    assert spread[1][30] > 1.1 * spread[0][30]
    assert spread[1][-1] < 1.5 * spread[0][-1]
