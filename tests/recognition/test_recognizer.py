import numpy as np
import pytest

from pft_exec.exceptions import RecognitionError, UnknownMethodError, UnknownMotionError
from pft_exec.recognition import METHODS, OnlineRecognizer, PhaseSettings
from tests.recognition.tubes import line, star, stream

both = pytest.mark.parametrize("method", METHODS)


@both
def test_a_belief_is_complete(method):
    """Probabilities sum to 1, phases lie in [0, 1], times are not negative, all labels are there, in order."""
    tubes = star()
    for belief in stream(OnlineRecognizer(tubes, method), tubes[0], 50.0):
        assert sum(belief.probability.values()) == pytest.approx(1.0)
        assert list(belief.probability) == ["0", "1", "2", "3"]
        assert all(0.0 <= s <= 1.0 for s in belief.phase.values())
        assert all(t >= 0.0 for t in belief.time_to_completion.values())
        assert 0.0 <= belief.unknown <= 1.0
        assert belief.probability[belief.label] == max(belief.probability.values())
        assert set(belief.log_likelihood) == set(belief.probability)
    assert belief.time == pytest.approx(2.0)
    assert belief.label == "0"


@both
@pytest.mark.parametrize(
    ("time", "position", "flag"),
    [
        (0.5, [0.0, 0.0, 0.0], "repeated"),
        (0.4, [0.0, 0.0, 0.0], "late"),
        (0.6, [np.nan, 0.0, 0.0], "not finite"),
        (np.inf, [0.0, 0.0, 0.0], "not finite"),
    ],
)
def test_a_sample_that_cannot_be_used_is_left_out_and_flagged(method, time, position, flag):
    """The belief stays as it was, and what comes later goes on as if it had not been there."""
    tubes = star()
    recognizer, clean = OnlineRecognizer(tubes, method), OnlineRecognizer(tubes, method)
    for r in (recognizer, clean):
        before = stream(r, tubes[0], until=0.25)[-1]
    flagged = recognizer.update(time, position)
    assert flagged.flagged == flag
    assert dict(flagged.probability) == dict(before.probability)
    after, expected = (r.update(0.52, tubes[0].at(0.26).position) for r in (recognizer, clean))
    assert after.flagged == ""
    assert dict(after.log_likelihood) == dict(expected.log_likelihood)


def test_bad_quaternions_and_signals_are_flagged():
    recognizer = OnlineRecognizer(star(turn=[0.0, 0.0, 1.0]))
    assert recognizer.update(0.0, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0, np.nan]).flagged == "not finite"
    assert recognizer.update(0.0, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]).flagged == "not finite"
    assert recognizer.update(0.0, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], {"gripper": np.nan}).flagged == "not finite"
    assert recognizer.update(0.0, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]).flagged == ""


def test_wrong_shapes_raise():
    recognizer = OnlineRecognizer(star())
    with pytest.raises(RecognitionError, match=r"position must have shape \(3,\); got \(2,\)"):
        recognizer.update(0.0, [0.0, 0.0])
    with pytest.raises(RecognitionError, match=r"quaternion must have shape \(4,\); got \(3,\)"):
        recognizer.update(0.0, [0.0, 0.0, 0.0], [0.0, 0.0, 1.0])


def test_an_unknown_method_names_the_nearest():
    with pytest.raises(UnknownMethodError, match="Did you mean 'phase'"):
        OnlineRecognizer(star(), method="phases")


def test_no_tubes_raise():
    with pytest.raises(RecognitionError, match="at least one flow tube"):
        OnlineRecognizer([])


def test_tubes_with_and_without_orientation_do_not_mix():
    with pytest.raises(RecognitionError, match="flat have none"):
        OnlineRecognizer([line("flat", [1, 0, 0]), line("full", [0, 1, 0], turn=[0, 0, 1])])


def test_two_tubes_of_one_label_raise():
    with pytest.raises(RecognitionError, match="label of its own"):
        OnlineRecognizer([line("a", [1, 0, 0]), line("a", [0, 1, 0])])


@both
def test_the_prior_tips_the_balance(method):
    """Before anything is seen belief is the prior; a label it does not name never comes."""
    tubes = star(2)
    belief = OnlineRecognizer(tubes, method, prior={"0": 3.0, "1": 1.0}).update(0.0, [0.0, 0.0, 0.0])
    assert belief.probability["0"] == pytest.approx(0.75, abs=0.02)
    never = stream(OnlineRecognizer(tubes, method, prior={"0": 1.0}), tubes[1])[-1]
    assert never.label == "0"


def test_a_prior_that_is_none_raises():
    with pytest.raises(UnknownMotionError, match="stirr"):
        OnlineRecognizer(star(), prior={"stirr": 1.0})
    for weights in ({"0": -1.0}, {"0": 0.0}, {"0": np.nan}):
        with pytest.raises(RecognitionError, match="prior"):
            OnlineRecognizer(star(), prior=weights)


@both
def test_replacing_tubes_keeps_phase_and_belief(method):
    """An object moved: the same tubes elsewhere, also with another number of steps."""
    tubes, recognizer = star(), OnlineRecognizer(star(), method)
    before = stream(recognizer, tubes[0], until=0.5)[-1]
    recognizer.replace(star(steps=80))
    after = recognizer.update(1.01, tubes[0].at(0.505).position)
    assert after.phase["0"] == pytest.approx(before.phase["0"], abs=0.04)
    assert after.label == "0"
    assert after.probability["0"] > 0.9


@both
def test_a_recognizer_that_restarts_is_as_new(method):
    """After another motion, every number is what a new recognizer says, also at an earlier time of the clock."""
    tubes = star(turn=[0.0, 0.0, 1.0])
    used, new = (OnlineRecognizer(tubes, method, prior={"0": 2.0, "1": 1.0, "2": 1.0, "3": 1.0}) for _ in range(2))
    stream(used, tubes[1], start=100.0)
    used.restart()
    for first, second in zip(stream(used, tubes[0]), stream(new, tubes[0]), strict=True):
        assert dict(first.log_likelihood) == dict(second.log_likelihood)
        assert dict(first.time_to_completion) == dict(second.time_to_completion)
        assert first.unknown == second.unknown
        assert first.time == second.time


def test_replacing_by_other_tubes_raises():
    recognizer = OnlineRecognizer(star())
    with pytest.raises(RecognitionError, match="must have the labels"):
        recognizer.replace(star(3))
    with pytest.raises(RecognitionError, match="orientation"):
        recognizer.replace(star(turn=[0.0, 0.0, 1.0]))


@both
def test_one_tube_is_enough(method):
    tube = line("only", [1.0, 0.0, 0.0])
    belief = stream(OnlineRecognizer({"only": tube}, method), tube)[-1]
    assert belief.probability["only"] == pytest.approx(1.0)


def _signal_tubes():
    """Two motions along one path: in the first the gripper closes, in the second it stays open."""
    closing = np.linspace(0.08, 0.0, 100)
    tubes = []
    for label, width in (("grasp", closing), ("touch", np.full(100, 0.08))):
        closed = (width < 0.04).astype(float)[:, None]
        tubes.append(
            line(
                label,
                [1.0, 0.0, 0.0],
                continuous={"gripper": width},
                continuous_deviation={"gripper": np.full(100, 0.002)},
                discrete={"held": np.hstack([0.9 - 0.8 * closed, 0.1 + 0.8 * closed])},
                discrete_values={"held": np.array([0, 1])},
            )
        )
    return tubes


@pytest.mark.parametrize("kind", ["continuous", "discrete"])
def test_signals_tell_motions_apart(kind):
    """A continuous and a discrete signal, each alone; without them neither is sure."""
    tubes = _signal_tubes()
    for label, share in (("grasp", 1.0), ("touch", 0.0)):
        recognizer, blind = OnlineRecognizer(tubes), OnlineRecognizer(tubes)
        for n in range(100):
            place = tubes[0].at(n / 99).position
            width = 0.08 * (1.0 - share * n / 99)
            said = (
                {"continuous": {"gripper": width}}
                if kind == "continuous"
                else {"discrete": {"held": int(width < 0.04)}}
            )
            belief = recognizer.update(0.02 * n, place, **said)
            other = blind.update(0.02 * n, place)
        assert belief.probability[label] > 0.8
        assert other.probability[label] < 0.95


def test_unknown_values_of_signals_are_no_error():
    recognizer = OnlineRecognizer(_signal_tubes())
    belief = recognizer.update(0.0, [0.0, 0.0, 0.0], None, {"other": 1.0}, {"held": 7, "color": 2})
    assert sum(belief.probability.values()) == pytest.approx(1.0)


def test_settings_are_taken_by_their_own_method_alone():
    """A researcher's constants reach the filter; the published method has others."""
    settings = PhaseSettings(evidence=1.0)
    tubes = star(2)
    modest = stream(OnlineRecognizer(tubes, settings=settings), tubes[0], until=0.3)[-1]
    usual = stream(OnlineRecognizer(tubes), tubes[0], until=0.3)[-1]
    assert modest.probability["0"] < usual.probability["0"]
    with pytest.raises(RecognitionError, match="settings are those of method 'phase'"):
        OnlineRecognizer(tubes, "dong2012", settings=settings)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [((1.0, "here"), "numbers"), ((1.0, None), "shape"), (([1.0], np.zeros(3)), "time")],
)
def test_what_is_no_number_raises(arguments, words):
    with pytest.raises(RecognitionError, match=words):
        OnlineRecognizer(star(2)).update(*arguments)


@pytest.mark.parametrize("tubes", [None, star(1)[0], [1.0]])
def test_what_is_no_flow_tube_raises(tubes):
    with pytest.raises(RecognitionError, match="flow tubes"):
        OnlineRecognizer(tubes)


@pytest.mark.parametrize("method", ["dong2012", "phase"])
def test_a_number_that_no_sensor_means_is_flagged(method):
    recognizer = OnlineRecognizer(star(2), method=method)
    before = recognizer.update(0.0, np.zeros(3))
    belief = recognizer.update(0.1, [1e300, 0.0, 0.0])
    assert belief.flagged == "not finite"
    assert dict(belief.log_likelihood) == dict(before.log_likelihood)
