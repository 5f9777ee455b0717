import numpy as np

from pft_exec.recognition import OnlineRecognizer
from pft_exec.recognition.phase_filter import PhaseFilter
from pft_exec.recognition.speed import LEVELS, log_speed
from tests.recognition.tubes import line


def _short_and_long():
    """Two motions along one line: "stop" ends halfway along "pass", in half the time."""
    return [line("stop", [0.5, 0.0, 0.0], duration=1.0), line("pass", [1.0, 0.0, 0.0], duration=2.0, seed=1)]


def _walk(recognizer, places, start=0.0):
    return [recognizer.update(start + 0.01 * n, place) for n, place in enumerate(places)]


def _path(tube):
    return [tube.at(phase).position for phase in np.linspace(0.0, 1.0, int(100 * tube.duration))]


def test_a_hand_that_rests_where_a_motion_ends_is_evidence_for_that_motion():
    """It comes to rest where one motion ends and another only passes: the first leads, more than just before."""
    tubes = _short_and_long()
    recognizer = OnlineRecognizer(tubes)
    way = _walk(recognizer, _path(tubes[0]))
    rest = _walk(recognizer, [tubes[0].position[-1]] * 50, start=1.01)
    assert rest[-1].label == "stop"
    assert rest[-1].probability["stop"] > max(0.8, way[70].probability["stop"])


def test_passing_where_a_motion_ends_is_evidence_against_it():
    """At full speed through the end of the short motion: the long one leads."""
    tubes = _short_and_long()
    passing = _walk(OnlineRecognizer(tubes), _path(tubes[1]))
    assert passing[110].probability["pass"] > 0.5
    assert passing[-1].probability["pass"] > 0.95


def test_a_pause_leaves_nothing_behind():
    """What a rest on the way said for a motion that ends there is gone when the hand goes on."""
    tubes = _short_and_long()
    path = _path(tubes[1])
    plain, paused = OnlineRecognizer(tubes), OnlineRecognizer(tubes)
    expected = _walk(plain, path)[-1]
    _walk(paused, path[:100])
    _walk(paused, [path[100]] * 100, start=1.0)
    assert _walk(paused, path[100:], start=2.0)[-1].probability["pass"] > expected.probability["pass"] - 0.05


def test_the_speed_is_not_counted_twice():
    """Resting ten times as long: what the speed says for the motion that ends here is the same within 0.3."""
    tubes, said = _short_and_long(), []
    for count in (100, 1000):
        recognizer = OnlineRecognizer(tubes)
        _walk(recognizer, _path(tubes[0]))
        _walk(recognizer, [tubes[0].position[-1]] * count, start=1.01)
        said.append(float(recognizer._method._presence[0]))
    assert abs(said[1] - said[0]) < 0.3


def test_densities_of_speed_are_densities():
    """At each phase they are positive, and sum to little more than 1 over the levels; rest is likeliest at the end."""
    speeds = PhaseFilter(_short_and_long()).model.speeds
    total = speeds.density.sum(axis=0) * speeds.gap
    assert speeds.density.shape[0] == LEVELS
    assert (speeds.density > 0.0).all()
    assert (total < 1.2).all()
    assert speeds.density[0, 99] > 5.0 * speeds.density[0, 50]


def test_the_logarithm_of_speed_undoes_the_softening():
    """Of a displacement d over (|d| + softness), both in extents: log(d + leash)."""
    for displacement in (0.0, 0.001, 0.03):
        direction = np.array([0.6, 0.0, 0.8]) * displacement / (displacement + 0.01)
        np.testing.assert_allclose(log_speed(direction, 0.01, 0.003), np.log(displacement + 0.003), rtol=1e-6)
