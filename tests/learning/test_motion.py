"""Learning a motion: refusals, substitutes, mirroring, keyframes, coaching."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.demonstration import Scene
from pft_exec.exceptions import LearningError, MissingObjectError, UnknownMethodError, UnknownNameError
from pft_exec.geometry import Pose
from pft_exec.learning import METHODS, learn_motion
from tests.learning.taught import lesson, taught, turned

NEW = taught("reach", np.random.default_rng(99))


def test_one_demonstration_is_refused_and_the_message_says_how_many_are_needed() -> None:
    with pytest.raises(LearningError, match=r"at least 2 demonstrations of 'reach' \(5 are usual\); got 1"):
        learn_motion(lesson("reach", count=1))
    with pytest.raises(LearningError, match="got 0"):
        learn_motion([])


def test_what_is_no_list_of_demonstrations_is_refused_by_name() -> None:
    with pytest.raises(LearningError, match="a list of demonstrations; got a single one of 'reach'"):
        learn_motion(lesson("reach")[0])  # type: ignore[arg-type]
    with pytest.raises(LearningError, match="item 1 of the demonstrations is a str"):
        learn_motion([lesson("reach")[0], "reach.h5"])  # type: ignore[list-item]
    with pytest.raises(LearningError, match="relevant says at which end"):
        learn_motion(lesson("reach"), relevant=["mat"])  # type: ignore[arg-type]


@pytest.mark.parametrize("method", METHODS)
def test_one_relevant_frame_may_be_named_without_a_list(method: str) -> None:
    variables = learn_motion(lesson("reach"), method, relevant={"end": "mat"}).variables
    assert variables.end.position.relevant == ("mat",)


def test_the_published_method_obeys_the_first_frame_named_and_refuses_what_it_does_not_know() -> None:
    variables = learn_motion(lesson("reach"), "dong2012", relevant={"end": ["mat", "bottle"]}).variables
    assert variables.end.position.frame == "mat"
    with pytest.raises(UnknownNameError, match='method="robust"'):
        learn_motion(lesson("reach"), "dong2012", relevant={"end.orientation": ["bottle"]})


def test_an_object_that_one_demonstration_lacks_is_said_not_to_have_counted() -> None:
    first, *others = lesson("reach")
    motion = learn_motion([replace(first, objects={"bottle": first.objects["bottle"]}), *others])
    assert "not asked about mat: only 4 of 5 demonstrations have it" in motion.describe()
    coaching = motion.coach()
    assert any("have mat" in text for text in coaching.uncovered)
    assert any("record mat in every demonstration" in text for text in coaching.advice)


@pytest.mark.parametrize("method", METHODS)
def test_a_tool_that_only_turns_makes_a_tube_with_regular_covariances(method: str) -> None:
    still = [replace(d, position=np.ones((len(d), 3))) for d in lesson("reach")]
    tube = learn_motion(still, method).flow_tube(still[0].scene, still[0].start)
    assert np.linalg.eigvalsh(tube.covariance).min() > 0.0
    np.testing.assert_allclose(tube.position, 1.0, atol=1e-9)


def test_mixed_labels_are_refused() -> None:
    with pytest.raises(LearningError, match="go_home, reach"):
        learn_motion([*lesson("reach"), *lesson("go_home")])


def test_orientation_in_some_demonstrations_only_is_refused() -> None:
    first, *rest = lesson("reach")
    with pytest.raises(LearningError, match="orientation"):
        learn_motion([replace(first, quaternion=None), *rest])


def test_an_unknown_method_is_refused_with_the_nearest_choice() -> None:
    with pytest.raises(UnknownMethodError, match="Did you mean 'robust'"):
        learn_motion(lesson("reach"), method="robus")


def test_an_option_that_the_method_does_not_have_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean 'epsilon'"):
        learn_motion(lesson("reach"), method="dong2012", epsilo=0.1)
    with pytest.raises(UnknownNameError, match="option of method 'robust'"):
        learn_motion(lesson("reach"), epsilon=0.1)


@pytest.mark.parametrize("method", METHODS)
def test_a_missing_object_is_named(method: str) -> None:
    motion = learn_motion(lesson("reach"), method)
    with pytest.raises(MissingObjectError, match=r"'bottle'.*'mat'"):
        motion.flow_tube(Scene({"mat": NEW.scene["mat"]}))


@pytest.mark.parametrize("method", METHODS)
def test_an_object_that_does_not_matter_may_be_missing(method: str) -> None:
    motion = learn_motion(lesson("reach"), method)
    alone = motion.flow_tube(Scene({"bottle": NEW.scene["bottle"]}), NEW.start)
    np.testing.assert_array_equal(alone.position, motion.flow_tube(NEW.scene, NEW.start).position)


@pytest.mark.parametrize("method", METHODS)
def test_a_substitute_takes_the_place_of_the_learned_object(method: str) -> None:
    motion = learn_motion(lesson("reach"), method)
    scene = Scene({"carton": NEW.scene["bottle"]})
    tube = motion.flow_tube(scene, NEW.start, substitute={"bottle": "carton"})
    np.testing.assert_array_equal(tube.position, motion.flow_tube(NEW.scene, NEW.start).position)
    with pytest.raises(MissingObjectError, match="cartoon"):
        motion.flow_tube(scene, NEW.start, substitute={"bottle": "cartoon"})


@pytest.mark.parametrize("method", METHODS)
def test_a_substitute_for_what_was_never_taught_is_refused(method: str) -> None:
    motion = learn_motion(lesson("reach"), method)
    scene = Scene({**NEW.scene.objects, "carton": NEW.scene["bottle"]})
    with pytest.raises(UnknownNameError, match=r"no object of motion 'reach' is named 'botle'. Did you mean 'bottle'"):
        motion.flow_tube(scene, NEW.start, substitute={"botle": "carton"})
    with pytest.raises(UnknownNameError, match=r"'carton'.*Choices: 'bottle', 'mat'"):
        motion.flow_tube(scene, NEW.start, substitute={"carton": "bottle"})


def test_an_object_that_some_demonstration_has_may_be_substituted_whether_it_matters_or_not() -> None:
    first, *others = lesson("reach")
    motion = learn_motion([replace(first, objects={"bottle": first.objects["bottle"]}), *others])
    assert motion.objects == ("bottle", "mat")
    scene = Scene({**NEW.scene.objects, "tray": NEW.scene["mat"]})
    tube = motion.flow_tube(scene, NEW.start, substitute={"mat": "tray"})
    np.testing.assert_array_equal(tube.position, motion.flow_tube(NEW.scene, NEW.start).position)


@pytest.mark.parametrize("method", METHODS)
def test_a_mirrored_motion_makes_the_mirrored_tube(method: str) -> None:
    plane = Pose([0.1, 0.2, 0.3], turned(0.4))
    motion = learn_motion(lesson("put_on_table"), method)
    expected = motion.flow_tube(NEW.scene, NEW.start).mirrored(plane)
    tube = motion.mirrored(plane).flow_tube(NEW.scene.mirrored(plane), NEW.start.mirrored(plane))
    np.testing.assert_allclose(tube.position, expected.position, atol=2e-3)
    assert motion.mirrored(plane).variables.relations() == motion.variables.relations()


@pytest.mark.parametrize("method", METHODS)
def test_the_same_demonstrations_give_the_same_tube_bit_for_bit(method: str) -> None:
    one, other = learn_motion(lesson("reach"), method), learn_motion(lesson("reach"), method)
    first, second = one.flow_tube(NEW.scene, NEW.start), other.flow_tube(NEW.scene, NEW.start)
    np.testing.assert_array_equal(first.position, second.position)
    np.testing.assert_array_equal(first.covariance, second.covariance)


@pytest.mark.parametrize("method", METHODS)
def test_keyframes_split_a_motion_and_its_tube_runs_through_all_segments(method: str) -> None:
    cut = [replace(d, keyframes=(0.5 * d.duration,)) for d in lesson("reach")]
    motion = learn_motion(cut, method)
    assert [segment.label for segment in motion.segments] == ["reach/1", "reach/2"]
    assert motion.variables.end.position.frame == "bottle"
    assert "reach/2" in motion.describe()
    tube = motion.flow_tube(NEW.scene, NEW.start)
    assert tube.label == "reach"
    assert np.linalg.norm(tube.position[-1] - NEW.position[-1]) < 0.015
    assert np.linalg.norm(np.diff(tube.position, axis=0), axis=1).max() < 0.03
    assert tube.aligned is not None
    assert tube.aligned.time.shape == (5, len(tube))


def test_a_different_number_of_keyframes_is_refused() -> None:
    first, *rest = lesson("reach")
    with pytest.raises(LearningError, match="same number of keyframes; got 0, 1"):
        learn_motion([replace(first, keyframes=(0.5,)), *rest])


def test_the_coach_names_the_demonstration_that_stands_out() -> None:
    demonstrations = lesson("reach")
    swerve = np.sin(np.linspace(0.0, np.pi, len(demonstrations[3])))[:, None] * [0.0, 0.0, 0.2]
    demonstrations[3] = replace(demonstrations[3], position=demonstrations[3].position + swerve)
    coaching = learn_motion(demonstrations).coach()
    assert coaching.outlier == 3
    assert "demonstration 4 stands out" in str(coaching)


def test_the_coach_asks_for_what_was_never_varied() -> None:
    still = [replace(d, objects={"bottle": np.array([0.6, -0.2, 0.8, 0, 0, 0, 1.0])}) for d in lesson("go_home")]
    coaching = learn_motion(still, "dong2012").coach()
    assert coaching.outlier is None
    assert any("bottle always stood in the same place" in text for text in coaching.uncovered)
    assert any("put bottle elsewhere" in text for text in coaching.advice)


def test_frames_that_are_no_names_are_refused() -> None:
    with pytest.raises(LearningError, match="relevant names the frames"):
        learn_motion(lesson("reach"), relevant={"end": 1})


@pytest.mark.parametrize("name", ["absolute", "start", ""])
def test_an_object_does_not_take_the_name_of_a_frame(name: str) -> None:
    lessons = [replace(d, objects={name: d.objects["bottle"]}) for d in lesson("reach")]
    with pytest.raises(LearningError, match="rename it"):
        learn_motion(lessons)
