"""The published method: FastDTW, Algorithm 2 and its threshold, Algorithm 3 and what it leaves open."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.exceptions import LearningError
from pft_exec.geometry import Pose
from pft_exec.learning import learn_motion
from pft_exec.learning.fast_dtw import align_fast
from pft_exec.learning.published_variables import MODES, find_published_variables
from tests.learning.taught import TRUTH, lesson, scaled, stirring, taught

NEW = {label: taught(label, np.random.default_rng(99)) for label in TRUTH}


def _exact_cost(first: np.ndarray, second: np.ndarray) -> float:
    """Reference: the plain dynamic program."""
    total = np.full((len(first) + 1, len(second) + 1), np.inf)
    total[0, 0] = 0.0
    for n, a in enumerate(first):
        for m, b in enumerate(second):
            before = min(total[n, m], total[n, m + 1], total[n + 1, m])
            total[n + 1, m + 1] = np.linalg.norm(a - b) + before
    return float(total[-1, -1])


@pytest.mark.parametrize("lengths", [(1, 1), (2, 5), (7, 3), (40, 61), (150, 97)])
def test_fast_dtw_is_a_warping_path_and_nearly_exact(lengths: tuple[int, int]) -> None:
    rng = np.random.default_rng(0)
    first, second = (np.cumsum(rng.normal(size=(n, 2)), axis=0) * 0.1 for n in lengths)
    path = align_fast(first, second)
    assert tuple(path[0]) == (0, 0)
    assert tuple(path[-1]) == (lengths[0] - 1, lengths[1] - 1)
    assert max(lengths) <= len(path) <= sum(lengths) - 1
    steps = np.diff(path, axis=0)
    assert ((steps >= 0) & (steps <= 1)).all()
    assert (steps.sum(axis=1) >= 1).all()
    cost = np.linalg.norm(first[path[:, 0]] - second[path[:, 1]], axis=1).sum()
    exact = _exact_cost(first, second)
    assert exact - 1e-9 <= cost <= 1.6 * exact + 1e-9


def test_fast_dtw_with_a_wide_radius_is_exact() -> None:
    rng = np.random.default_rng(1)
    first, second = (np.cumsum(rng.normal(size=(n, 3)), axis=0) for n in (50, 64))
    path = align_fast(first, second, radius=64)
    cost = np.linalg.norm(first[path[:, 0]] - second[path[:, 1]], axis=1).sum()
    assert cost == pytest.approx(_exact_cost(first, second))


def test_every_channel_is_tried_in_every_mode() -> None:
    found = find_published_variables(lesson("reach"), 0.1, "std")
    assert {v.mode for v in found if v.channel == "position"} == set(MODES)
    assert {v.mode for v in found if v.channel == "ray"} == {"relEffStart", "relEffEnd"}
    for channel in ("orientation", "time", "width", "closed"):
        assert {v.mode for v in found if v.channel == channel} == {"absStart", "absEnd", "relInit"}
    assert all(np.linalg.eigvalsh(v.covariance).min() > -1e-12 for v in found)


def test_the_ray_says_from_which_side_of_the_object_the_tool_stands() -> None:
    """A tool that always ends on the same side, in the object's axes, of an object turned at random."""
    rng = np.random.default_rng(0)
    found = []
    for d in lesson("reach"):
        yaw = rng.uniform(-1.5, 1.5)
        drawer = np.array([*d.objects["bottle"][:3], 0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)])
        goal = drawer[:3] + rng.uniform(0.1, 0.3) * np.array([np.cos(yaw), np.sin(yaw), 0.0])
        share = np.linspace(0.0, 1.0, len(d))[:, None]
        found.append(replace(d, position=d.position + share * (goal - d.position[-1]), objects={"drawer": drawer}))
    variables = find_published_variables(found, 0.1, "std")
    ray = {v.mode: v for v in variables if v.channel == "ray"}
    assert ray["relEffEnd"].relevant
    assert not ray["relEffStart"].relevant
    place = next(v for v in variables if v.channel == "position" and v.mode == "relEffEnd")
    assert not place.relevant


def test_a_ray_of_no_length_is_no_candidate() -> None:
    at_the_tool = [
        replace(d, objects={"glove": np.array([*d.position[0], 0.0, 0.0, 0.0, 1.0])}) for d in lesson("reach")
    ]
    assert not [v for v in find_published_variables(at_the_tool, 0.1, "std") if v.channel == "ray"]


@pytest.mark.parametrize("label", sorted(TRUTH))
def test_the_position_relations_of_wide_motions_are_found(label: str) -> None:
    motion = learn_motion(lesson(label), "dong2012")
    assert motion.variables.end.position.frame == TRUTH[label][0]


def test_the_printed_threshold_depends_on_the_unit_and_the_reading_does_not() -> None:
    meters, micrometers = lesson("reach"), [scaled(d, 1e6) for d in lesson("reach")]

    def relevant(demonstrations: list[Demonstration], spread: str) -> int:
        return sum(v.relevant for v in find_published_variables(demonstrations, 0.1, spread) if v.channel == "position")

    assert relevant(meters, "std") == relevant(micrometers, "std")
    assert relevant(meters, "variance") > relevant(micrometers, "variance") == 0


OPTIONS: list[dict[str, Any]] = [
    {},
    {"similar": 3},
    {"interpolation": "linear"},
    {"radius": 5},
    {"spread": "variance"},
    {"samples": None},
    {"samples": 30},
]


@pytest.mark.parametrize("options", OPTIONS)
@pytest.mark.parametrize("label", sorted(TRUTH))
def test_the_tube_begins_at_the_tool_and_ends_where_the_relation_says(label: str, options: dict[str, Any]) -> None:
    motion = learn_motion(lesson(label), "dong2012", **options)
    tube = motion.flow_tube(NEW[label].scene, NEW[label].start)
    if options.get("spread") != "variance":
        np.testing.assert_allclose(tube.position[0], NEW[label].position[0], atol=1e-9)
        assert np.linalg.norm(tube.position[-1] - NEW[label].position[-1]) < 0.015
    assert np.linalg.eigvalsh(tube.covariance).min() > 0.0
    assert tube.count == options.get("similar", 5)


def test_the_mean_may_grow_with_each_demonstration() -> None:
    rng = np.random.default_rng(0)
    uneven = [d.segment(0, int(rng.integers(60, 120))) for d in lesson("reach")]
    tube = learn_motion(uneven, "dong2012").flow_tube(NEW["reach"].scene, NEW["reach"].start)
    assert len(tube) >= max(len(d) for d in uneven)


def test_the_given_regularization_is_the_floor_of_the_covariance() -> None:
    motion = learn_motion([lesson("reach")[0]] * 3, "dong2012", regularization=0.01, turn_regularization=0.03)
    tube = motion.flow_tube(NEW["reach"].scene, NEW["reach"].start)
    np.testing.assert_allclose(
        tube.covariance, np.broadcast_to(np.diag([1e-4] * 3 + [9e-4] * 3), tube.covariance.shape), atol=1e-9
    )


def test_stirring_collapses_where_its_displacement_is_scaled_and_does_not_where_it_is_left_alone() -> None:
    """The published failure: circles scaled by a displacement that is nearly nothing."""
    demonstrations, start = stirring(), Pose(stirring()[0].position[0])
    overrules = {"end": ["absolute"], "start": ["absolute"]}

    def extent(**options: float) -> float:
        motion = learn_motion(demonstrations, "dong2012", overrules, **options)
        return float(np.ptp(motion.flow_tube(demonstrations[0].scene, start).position, axis=0)[:2].max())

    assert abs(extent(minimum_displacement=0.0) - 0.1) > 0.02
    assert extent(minimum_displacement=0.5) == pytest.approx(0.1, abs=0.01)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"spread": "sd"}, "spread must be one of std, variance"),
        ({"interpolation": "cubic"}, "interpolation must be one of"),
        ({"similar": 1}, "similar must be 'all' or a number"),
        ({"epsilon": 0.0}, "epsilon must be positive"),
    ],
)
def test_options_without_meaning_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(LearningError, match=message):
        learn_motion(lesson("reach"), "dong2012", **options)


def test_a_carried_object_is_relevant_as_printed_and_not_where_it_was_before_the_motion() -> None:
    carried = []
    for d in lesson("reach"):
        box = np.hstack([d.position, np.tile([0.0, 0.0, 0.0, 1.0], (len(d), 1))])
        carried.append(replace(d, quaternion=None, objects={"box": box, "bottle": d.objects["bottle"]}))
    assert learn_motion(carried, "dong2012").variables.end.position.frame == "box"
    assert learn_motion(carried, "dong2012", object_pose="start").variables.end.position.frame == "bottle"
