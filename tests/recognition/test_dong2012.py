import numpy as np
import pytest

from pft_exec.exceptions import RecognitionError
from pft_exec.geometry import normalize_quaternion
from pft_exec.recognition import OnlineRecognizer
from pft_exec.recognition.dong2012 import Dong2012Settings, IncrementalAlignment
from pft_exec.recognition.scores import Sample
from tests.recognition.full_matrix import score_by_full_matrix
from tests.recognition.tubes import line, random_tube, star


def _random_case(rng):
    turned = bool(rng.integers(2))
    tubes = [random_tube(rng, str(k), int(rng.integers(2, 9)), turned) for k in range(2)]
    count = int(rng.integers(1, 7))
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.001, 0.2, count - 1))])
    positions = np.cumsum(rng.normal(scale=0.1, size=(count, 3)), axis=0)
    quaternions = normalize_quaternion(rng.normal(size=(count, 4)))
    return tubes, times, positions, quaternions if turned else [None] * count


def _incremental(tubes, times, positions, quaternions, settings=None):
    alignment = IncrementalAlignment(tubes, settings)
    samples = zip(times, positions, quaternions, strict=True)
    scores = [alignment.update(Sample(t, p, q, None, None)) for t, p, q in samples]
    likelihood = np.array([score.log_likelihood for score in scores])
    return likelihood, np.array([score.phase for score in scores])


@pytest.mark.parametrize("seed", range(10))
def test_one_column_equals_the_full_matrices(seed):
    """To 1e-9, on 1000 random cases in all: after every sample, for every tube."""
    rng = np.random.default_rng(seed)
    for _ in range(100):
        tubes, times, positions, quaternions = _random_case(rng)
        likelihood, phase = _incremental(tubes, times, positions, quaternions)
        total = sum(tube.count for tube in tubes)
        for place, tube in enumerate(tubes):
            scores, matches = score_by_full_matrix(tube, tube.count / total, positions, quaternions, times)
            np.testing.assert_allclose(likelihood[:, place], scores, rtol=0, atol=1e-9 * max(1.0, np.abs(scores).max()))
            np.testing.assert_allclose(phase[:, place], matches / (len(tube) - 1))


def test_ties_go_to_diagonal_then_tube_then_time():
    """On a grid of whole numbers costs tie all the time, and the two agree on the path."""
    rng = np.random.default_rng(5)
    for _ in range(100):
        tube = random_tube(rng, "a", 6, turned=False)
        grid = rng.integers(0, 2, size=(6, 3)).astype(float)
        tube = type(tube)("a", np.arange(6.0), grid, None, tube.covariance, np.full(6, 50.0), count=1)
        positions = rng.integers(0, 2, size=(5, 3)).astype(float)
        likelihood, _ = _incremental([tube], np.arange(5.0), positions, [None] * 5)
        expected, _ = score_by_full_matrix(tube, 1.0, positions, [None] * 5, np.arange(5.0))
        np.testing.assert_allclose(likelihood[:, 0], expected, atol=1e-9)


def test_the_time_floor_decides_how_late_a_match_may_be():
    """A hand that is late but exactly on the path is matched there only by a wide time density."""
    tube = line("a", [1.0, 0.0, 0.0], aligned=0)
    tube = type(tube)("a", tube.time, tube.position, None, tube.covariance)
    times, positions = np.array([0.0, 1.0]), tube.position[[0, 25]] + [0.0, 0.001, 0.0]
    _, narrow = _incremental([tube], times, positions, [None] * 2, Dong2012Settings(time_floor=0.01))
    _, wide = _incremental([tube], times, positions, [None] * 2, Dong2012Settings(time_floor=10.0))
    assert narrow[-1, 0] == pytest.approx(0.5, abs=0.05)
    assert wide[-1, 0] == pytest.approx(25 / 99, abs=0.02)


def test_the_prior_grows_with_the_share_of_the_tube_seen():
    """Before the first sample: log(count / all * 1 / N)."""
    tubes = [line("a", [1.0, 0.0, 0.0]), line("b", [0.0, 1.0, 0.0], steps=50)]
    scores = IncrementalAlignment(tubes).scores()
    np.testing.assert_allclose(scores.log_likelihood, np.log([0.5 / 100, 0.5 / 50]))


def test_state_does_not_grow():
    """Memory after 10 and after 2000 samples is the same."""
    alignment = IncrementalAlignment(star())
    sizes = []
    for t in range(2000):
        alignment.update(Sample(0.001 * t, np.array([1e-4 * t, 0.0, 0.0]), None, None, None))
        if t in (10, 1999):
            sizes.append(sum(v.nbytes for v in vars(alignment).values() if isinstance(v, np.ndarray)))
    assert sizes[0] == sizes[1]


def test_replacing_tubes_keeps_the_alignment():
    """The same tubes again change nothing; moved tubes of another length keep the phase."""
    tubes = star()
    alignment = IncrementalAlignment(tubes)
    for n in range(40):
        before = alignment.update(Sample(float(tubes[0].time[n]), tubes[0].position[n], None, None, None))
    alignment.replace(tubes)
    np.testing.assert_allclose(alignment.scores().log_likelihood, before.log_likelihood)
    alignment.replace(star(steps=50))
    np.testing.assert_allclose(alignment.scores().phase, before.phase, atol=0.02)


def test_a_sample_without_orientation_is_refused_where_tubes_have_one():
    recognizer = OnlineRecognizer(star(turn=[0.0, 0.0, 1.0]), method="dong2012")
    with pytest.raises(RecognitionError, match="quaternion"):
        recognizer.update(0.0, [0.0, 0.0, 0.0])
