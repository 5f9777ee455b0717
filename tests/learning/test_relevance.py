"""Relevant motion variables: what must be found, what must not, and what must be called ambiguous."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.exceptions import UnknownNameError
from pft_exec.geometry import Array, multiply
from pft_exec.learning import learn_library, learn_motion
from pft_exec.learning.decisions import find_variables
from pft_exec.learning.frames import Candidate
from pft_exec.learning.relevance import DECISIVE, weigh_frames
from pft_exec.learning.variables import NONE
from tests.learning.bottle_motions import LABELS, RELATIONS, perform
from tests.learning.taught import TRUTH, all_lessons, lesson, scaled, taught, turned, with_objects


@pytest.mark.parametrize("seed", range(8))
def test_exactly_the_true_relations_are_found_and_none_is_ambiguous(seed: int) -> None:
    library = learn_library(all_lessons(seed))
    for label, (position, orientation) in TRUTH.items():
        variables = library[label].variables
        assert variables.relations() == {
            "start": {"position": "", "orientation": ""},
            "end": {"position": position, "orientation": orientation},
        }
        assert not variables.ambiguous


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_a_change_of_units_changes_no_decision(factor: float) -> None:
    for label in TRUTH:
        demonstrations = lesson(label)
        one = learn_motion(demonstrations).variables
        other = learn_motion([scaled(d, factor) for d in demonstrations]).variables
        assert one.relations() == other.relations()
        np.testing.assert_allclose(other.end.position.spread, factor * one.end.position.spread, rtol=1e-6)


def test_the_order_of_demonstrations_changes_no_decision() -> None:
    demonstrations = lesson("reach")
    one, other = learn_motion(demonstrations).variables, learn_motion(demonstrations[::-1]).variables
    assert one.relations() == other.relations()
    np.testing.assert_allclose(one.end.position.spread, other.end.position.spread)


def test_the_offset_of_a_bottle_that_is_turned_at_random_keeps_the_axes_of_the_world() -> None:
    decision = learn_motion(lesson("reach")).variables.end.position
    assert decision.axes == "world"
    np.testing.assert_allclose(decision.offset, [-0.0435, -0.1118, 0.02], atol=0.006)


def test_an_offset_in_the_axes_of_an_object_is_found() -> None:
    rng = np.random.default_rng(3)
    found = []
    for d in lesson("reach"):
        yaw = rng.uniform(-1.0, 1.0)
        drawer = np.array([*d.objects["bottle"][:3], 0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)])
        goal = drawer[:3] + 0.15 * np.array([np.cos(yaw), np.sin(yaw), 0.0])
        share = np.linspace(0.0, 1.0, len(d))[:, None]
        position = d.position + share * (goal - d.position[-1] + rng.normal(0.0, 0.003, 3))
        found.append(replace(d, position=position, objects={"drawer": drawer}))
    decision = learn_motion(found).variables.end.position
    assert (decision.frame, decision.axes) == ("drawer", "object")


@pytest.mark.parametrize("degrees", [0.0, 2.0])
def test_axes_that_the_demonstrations_do_not_tell_apart_are_ambiguous_and_the_offset_turns(degrees: float) -> None:
    rng = np.random.default_rng(5)
    demonstrations = []
    for d in (taught("reach", rng, noise=0.006) for _ in range(5)):
        yaw = np.radians(rng.uniform(-degrees, degrees))
        bottle = np.array([*d.objects["bottle"][:3], 0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)])
        demonstrations.append(replace(d, objects={**d.objects, "bottle": bottle}))
    decision = learn_motion(demonstrations).variables.end.position
    assert (decision.frame, decision.axes, decision.ambiguous) == ("bottle", "object", True)
    assert "whether the offset turns with it is not shown" in decision.reason


def _always_there(distance: float) -> list[Demonstration]:
    """`go_home` with a post that never moves, `distance` m beside the place where the motion ends."""
    post = np.array([0.42, -0.5 + distance, 1.12, 0.0, 0.0, 0.0, 1.0])
    return [replace(d, objects={"post": post}) for d in lesson("go_home")]


def test_an_object_that_never_moved_is_ambiguous_and_counts_where_the_tool_came_close() -> None:
    near = learn_motion(_always_there(0.03)).variables.end.position
    assert near.frame == "post"
    assert near.ambiguous
    assert "absolute" in near.reason


def test_an_object_that_never_moved_far_from_the_end_is_ambiguous_and_the_place_counts() -> None:
    far = learn_motion(_always_there(0.6)).variables.end.position
    assert far.frame == "absolute"
    assert far.ambiguous
    assert "post" in far.reason


def test_an_object_that_turned_with_the_tool_by_chance_and_holds_no_place_is_hardly_a_rival() -> None:
    undecided = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        demonstrations = []
        for d in (taught("go_home", rng) for _ in range(3)):
            box = np.array([*rng.uniform(0.2, 0.9, 2), 0.7, *turned(rng.uniform(-0.05, 0.05))])
            assert d.quaternion is not None
            shaky = multiply(turned(rng.normal(0.0, 0.03)), d.quaternion)
            demonstrations.append(replace(d, quaternion=shaky, objects={"box": box}))
        orientation = find_variables(demonstrations, {}).end.orientation
        assert orientation is not None
        undecided.append(orientation.ambiguous or orientation.frame != "absolute")
    assert np.mean(undecided) < 0.25


def test_directions_are_decided_apart_where_no_single_frame_explains_all() -> None:
    rng = np.random.default_rng(0)
    found = []
    for d in lesson("reach"):
        shelf = d.objects["bottle"] + np.array([0.0, 0.0, rng.uniform(-0.15, 0.15), 0, 0, 0, 0])
        found.append(replace(d, objects={"bottle": shelf}))
    decision = learn_motion(found).variables.end.position
    assert decision.directions == ("bottle", "bottle", "absolute")
    assert decision.frame == "bottle"
    assert not decision.ambiguous


def test_a_hundred_objects_do_not_hide_the_one_that_matters() -> None:
    variables = learn_motion(with_objects(lesson("reach"), 100)).variables
    assert variables.end.position.frame == "bottle"
    assert variables.start.position.frame == ""


def test_an_object_in_the_hand_from_the_first_sample_is_reported_and_explains_neither_end() -> None:
    found = []
    for d in lesson("put_on_table"):
        assert d.quaternion is not None
        box = np.hstack([d.position - [0.0, 0.0, 0.05], np.tile([0.0, 0.0, 0.0, 1.0], (len(d), 1))])
        found.append(replace(d, quaternion=None, objects={"box": box, "mat": d.objects["mat"]}))
    variables = learn_motion(found).variables
    assert variables.carried == ("box",)
    assert variables.end.position.frame == "mat"
    assert variables.start.position.frame == ""
    assert "box" not in variables.start.position.candidates


def test_an_object_that_is_gripped_on_the_way_counts_where_it_stood() -> None:
    found = []
    for d in lesson("reach"):
        assert d.quaternion is not None
        rise = np.linspace(0.0, 1.0, 60)[:, None] ** 2 * [0.0, 0.0, 0.15]
        position = np.vstack([d.position, d.position[-1] + rise])
        held = np.broadcast_to(d.objects["bottle"], (len(position), 7)).copy()
        held[-60:, :3] += rise
        time = np.linspace(0.0, 3.0, len(position))
        found.append(
            replace(
                d, time=time, position=position, quaternion=None, objects={"bottle": held}, continuous={}, discrete={}
            )
        )
    variables = learn_motion(found).variables
    assert variables.carried == ("bottle",)
    assert variables.end.position.frame == "bottle"


def test_a_held_object_may_still_be_named_by_the_user() -> None:
    found = []
    for d in lesson("reach"):
        assert d.quaternion is not None
        found.append(replace(d, objects=dict(d.objects) | {"box": np.hstack([d.position, d.quaternion])}))
    assert learn_motion(found, relevant={"start": ["box"]}).variables.start.position.frame == "box"


@pytest.mark.parametrize("label", LABELS)
def test_nineteen_of_twenty_pupils_learn_what_matters_in_each_bottle_motion(label: str) -> None:
    right = 0
    for seed in range(20):
        rng = np.random.default_rng([seed, LABELS.index(label)])
        variables = find_variables([perform(label, rng) for _ in range(5)], {})
        right += variables.relations() == RELATIONS[label]
    assert right >= 19


def test_each_decision_can_be_overruled() -> None:
    overrules = {"end": ["mat"], "end.orientation": ["start"], "start": ["absolute"]}
    motion = learn_motion(lesson("reach"), relevant=overrules)
    assert motion.variables.relations() == {
        "start": {"position": "absolute", "orientation": ""},
        "end": {"position": "mat", "orientation": "start"},
    }
    assert motion.variables.end.position.overruled
    assert learn_motion(lesson("reach"), relevant={"end": []}).variables.end.position.frame == ""


@pytest.mark.parametrize(("relevant", "choice"), [({"ende": ["mat"]}, "'end'"), ({"end": ["matt"]}, "'mat'")])
def test_an_unknown_end_or_frame_is_refused_with_the_nearest_choice(
    relevant: dict[str, list[str]], choice: str
) -> None:
    with pytest.raises(UnknownNameError, match=f"Did you mean {choice}"):
        learn_motion(lesson("reach"), relevant=relevant)


def test_a_start_cannot_be_relative_to_itself() -> None:
    with pytest.raises(UnknownNameError, match="start"):
        learn_motion(lesson("reach"), relevant={"start": ["start"]})


def test_decisions_read_as_sentences_with_their_numbers() -> None:
    text = learn_motion(lesson("reach")).describe()
    line = next(row for row in text.splitlines() if "bottle (spread" in row)
    assert line.startswith("`reach` ends 0.12 m ")
    assert "absolute" in line
    assert "mm" in line


def test_decisions_are_plain_data() -> None:
    plain = learn_motion(lesson("reach")).variables.to_dict()
    assert json.loads(json.dumps(plain))["end"]["position"]["frame"] == "bottle"
    assert plain["discrete"] == {"closed": {"start": 0, "end": 1}}
    assert plain["continuous"]["width"]["end"] == pytest.approx(0.03)


def test_an_object_that_stands_by_chance_as_the_start_does_seldom_holds_it_though_all_stand_at_one_height() -> None:
    """Five starts and three objects, each drawn in a box of 0.12 m on a table: heights that agree prove nothing."""
    rng, doubted = np.random.default_rng(4), 0
    for _ in range(1500):
        starts, *objects = (rng.uniform(-0.06, 0.06, (5, 3)) * [1.0, 1.0, 0.005] for _ in range(4))
        seen = [("absolute", starts), *((f"object {k}", starts - each) for k, each in enumerate(objects))]
        begun = [_candidate(name, place) for name, place in seen]
        ended = [_candidate("start", rng.normal(0.0, 0.001, (5, 3))), *begun]
        doubted += weigh_frames([begun, ended], extent=0.3)[0].by_name()[NONE] < DECISIVE
    assert doubted <= 6  # 13 where the height counts as a third proof


def _candidate(name: str, places: Array) -> Candidate:
    return Candidate(name, "world", places.mean(axis=0), places - places.mean(axis=0))


def test_an_end_on_an_object_is_said_to_be_there_and_not_at_no_distance() -> None:
    lessons = [
        replace(d, objects=d.objects | {"bottle": np.concatenate([d.end.position, [0.0, 0.0, 0.0, 1.0]])})
        for d in lesson("reach")
    ]
    assert "`reach` ends at bottle (spread" in learn_motion(lessons).describe()


def _lost_in(demonstrations: list[Demonstration], name: str, *places: int) -> list[Demonstration]:
    """The demonstrations, an object missing in some of them."""
    kept = [{n: pose for n, pose in d.objects.items() if n != name} for d in demonstrations]
    return [replace(d, objects=kept[i]) if i in places else d for i, d in enumerate(demonstrations)]


@pytest.mark.parametrize("seed", range(3))
def test_an_object_lost_in_one_demonstration_still_holds_the_end_that_the_others_show(seed: int) -> None:
    rng = np.random.default_rng(seed)
    demonstrations = []
    for d in lesson("reach", seed):
        beside = d.objects["bottle"] + np.append(rng.uniform(-0.08, 0.08, 2), np.zeros(5))
        demonstrations.append(replace(d, objects={**d.objects, "jar": beside}))
    with pytest.warns(RuntimeWarning, match="is about bottle, which demonstration 3 of 5 lacks"):
        motion = learn_motion(_lost_in(demonstrations, "bottle", 2))
    assert motion.variables.end.position.frame == "bottle"
    assert not motion.variables.end.position.ambiguous
    assert len(motion.demonstrations) == 4


def test_an_object_that_most_demonstrations_lack_or_that_does_not_matter_takes_none_of_them_away() -> None:
    for name, places in (("mat", (1,)), ("bottle", (0, 1, 2))):
        motion = learn_motion(_lost_in(lesson("reach"), name, *places))
        assert len(motion.demonstrations) == 5
