"""Every method of recognition, by one suite: causal, normalized, deterministic, and better than chance."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.evaluation.baselines.hmm import TiedMixtureHMM, learn_hmm
from pft_exec.evaluation.baselines.nearest_neighbor import learn_nearest_neighbor, open_end_costs, warped_distance
from pft_exec.evaluation.baselines.promp import learn_promp
from pft_exec.evaluation.benchmarks import synthetic_demonstrations
from pft_exec.evaluation.methods import METHODS, OPTIONAL_METHODS, learn_tubes, method_named
from pft_exec.evaluation.trace import moving_axes
from pft_exec.exceptions import UnknownMethodError
from pft_exec.learning import learn_library

ALL = (*METHODS, *OPTIONAL_METHODS)


def arcs(label: str, bend: float, count: int, seed: int) -> list[Demonstration]:
    """Planar arcs from the origin to (1, 0), bent to one side, a little different each time."""
    rng = np.random.default_rng(seed)
    made = []
    for _ in range(count):
        s = np.linspace(0.0, 1.0, 40)
        height = (bend + 0.05 * rng.standard_normal()) * np.sin(np.pi * s)
        position = np.stack([s, height, 0.0 * s], axis=1) + 0.01 * rng.standard_normal(3) * [1.0, 1.0, 0.0]
        made.append(Demonstration(label, 0.05 * np.arange(40), position))
    return made


@pytest.fixture(scope="module")
def train() -> list[Demonstration]:
    return [*arcs("over", 0.4, 5, 1), *arcs("under", -0.4, 5, 2), *arcs("straight", 0.0, 5, 3)]


@pytest.fixture(scope="module")
def tests() -> list[Demonstration]:
    return [*arcs("over", 0.4, 2, 4), *arcs("under", -0.4, 2, 5), *arcs("straight", 0.0, 2, 6)]


@pytest.mark.parametrize("name", ALL)
def test_recognizes_what_is_plain(name: str, train: list[Demonstration], tests: list[Demonstration]) -> None:
    classifier = method_named(name)(train)
    for test in tests:
        trace = classifier.recognize(test)
        assert trace.leading[-1] == test.label
        assert trace.labels == ("over", "under", "straight")
        assert trace.probability.shape == trace.log_likelihood.shape == (len(test), 3)
        assert np.isfinite(trace.unknown).all()
        np.testing.assert_allclose(trace.probability.sum(axis=1), 1.0, atol=1e-9)


@pytest.mark.parametrize("name", ALL)
def test_never_looks_ahead(name: str, train: list[Demonstration], tests: list[Demonstration]) -> None:
    """The answers along a recording that was cut short are those along the whole."""
    classifier = method_named(name)(train)
    whole, part = classifier.recognize(tests[0]), classifier.recognize(tests[0].segment(0, 15))
    np.testing.assert_allclose(part.probability, whole.probability[:15], atol=1e-9)
    np.testing.assert_allclose(part.unknown, whole.unknown[:15], rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("name", ALL)
def test_does_not_look_at_the_label(name: str, train: list[Demonstration], tests: list[Demonstration]) -> None:
    classifier = method_named(name)(train)
    hidden = classifier.recognize(replace(tests[0], label="hidden"))
    np.testing.assert_array_equal(hidden.probability, classifier.recognize(tests[0]).probability)


@pytest.mark.parametrize("name", ["HMM, left to right", "HMM, ergodic", "ProMP", "DTW neighbor"])
def test_learns_the_same_from_the_same(name: str, train: list[Demonstration], tests: list[Demonstration]) -> None:
    first, again = (method_named(name)(train).recognize(tests[0]).probability for _ in range(2))
    np.testing.assert_array_equal(first, again)


def test_an_unknown_method_is_refused_by_name() -> None:
    with pytest.raises(UnknownMethodError, match=r"no method of recognition is named 'DTW neighbour'\. Did you mean"):
        method_named("DTW neighbour")


def test_axes_that_stand_still_are_left_out() -> None:
    assert moving_axes(arcs("over", 0.4, 2, 1)) == [0, 1]
    still = Demonstration("hold", [0.0, 1.0], np.zeros((2, 3)))
    assert moving_axes([still]) == [0]


def brute_force(model: TiedMixtureHMM, points: np.ndarray) -> float:
    """Log density of the points, by summing over every sequence of states."""
    components = np.stack(
        [
            multivariate_normal(mean, covariance).pdf(points)
            for mean, covariance in zip(model.means_, model.covars_, strict=True)
        ],
        axis=-1,
    ).reshape(len(points), -1)
    emissions = components @ model.weights_.T
    total = 0.0
    for states in product(range(model.n_components), repeat=len(points)):
        term = model.startprob_[states[0]] * emissions[0, states[0]]
        for t in range(1, len(points)):
            term *= model.transmat_[states[t - 1], states[t]] * emissions[t, states[t]]
        total += term
    return float(np.log(total))


@pytest.mark.parametrize("topology", ["left_to_right", "ergodic"])
def test_hmm_prefixes_have_the_likelihood_of_all_state_sequences(topology: str) -> None:
    sequences = [item.position[:, :2] for item in arcs("over", 0.4, 5, 1)]
    model = TiedMixtureHMM(topology=topology).learn(sequences)
    points = arcs("over", 0.4, 1, 9)[0].position[::7, :2]
    expected = [brute_force(model, points[: t + 1]) for t in range(len(points))]
    np.testing.assert_allclose(model.prefix_log_likelihood(points), expected, rtol=1e-9)


@pytest.mark.parametrize("topology", ["left_to_right", "ergodic"])
def test_hmm_learning_raises_the_likelihood(topology: str) -> None:
    """EM never loses more than the floor of the covariances takes."""
    sequences = [item.position[:, :2] for item in arcs("over", 0.4, 5, 1)]
    history = list(TiedMixtureHMM(topology=topology).learn(sequences).monitor_.history)
    assert history[-1] > history[0]
    assert (np.diff(history) > -0.02 * abs(history[-1] - history[0])).all()


def test_hmm_states_share_their_gaussians_and_have_their_own_weights() -> None:
    model = TiedMixtureHMM().learn([item.position[:, :2] for item in arcs("over", 0.4, 5, 1)])
    assert model.means_.shape == (6, 2)
    assert model.weights_.shape == (3, 6)
    np.testing.assert_allclose(model.weights_.sum(axis=1), 1.0)
    assert np.ptp(model.weights_, axis=0).max() > 0.1


def test_hmm_left_to_right_never_goes_back() -> None:
    model = TiedMixtureHMM().learn([item.position[:, :2] for item in arcs("over", 0.4, 5, 1)])
    np.testing.assert_array_equal(np.tril(model.transmat_, -1), 0.0)
    np.testing.assert_array_equal(model.startprob_, [1.0, 0.0, 0.0])


def test_hmm_information_criterion_chooses_a_number_of_states(train: list[Demonstration]) -> None:
    classifier = learn_hmm(train, states=None)
    sequences = [item.position[:, :2] for item in train[:5]]
    stacked, lengths = np.concatenate(sequences), [len(s) for s in sequences]
    three = TiedMixtureHMM().learn(sequences)
    assert classifier.models["over"].bic(stacked, lengths) <= three.bic(stacked, lengths)


def naive_open_end(reference: np.ndarray, points: np.ndarray) -> list[float]:
    distance = np.sum((points[:, None] - reference[None]) ** 2, axis=2)
    cost = np.full((len(points) + 1, len(reference) + 1), np.inf)
    cost[0, 0] = 0.0
    for i, j in product(range(len(points)), range(len(reference))):
        cost[i + 1, j + 1] = distance[i, j] + min(cost[i, j], cost[i, j + 1], cost[i + 1, j])
    return list(cost[1:, 1:].min(axis=1))


def test_open_end_costs_are_those_of_the_full_matrix() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        reference, points = rng.normal(size=(rng.integers(1, 20), 3)), rng.normal(size=(rng.integers(1, 20), 3))
        np.testing.assert_allclose(open_end_costs(reference, points), naive_open_end(reference, points), rtol=1e-12)


def test_warped_distance_ignores_pace_and_measures_offsets() -> None:
    s = np.linspace(0.0, 1.0, 300)
    slow = np.stack([s**2, 0.0 * s], axis=1)
    assert warped_distance(np.stack([s, 0.0 * s], axis=1), slow) < 0.004
    assert warped_distance(slow, slow + np.array([0.0, 0.3])) == pytest.approx(0.3, abs=1e-12)


def test_neighbor_with_direction_tells_there_from_back() -> None:
    """Where only the direction differs, position alone cannot tell, and direction can, early on."""
    there = [replace(item, label="there") for item in arcs("x", 0.0, 4, 1)]
    back = [replace(item, label="back", position=item.position[::-1].copy()) for item in arcs("x", 0.0, 4, 2)]
    loop = [
        replace(item, position=np.concatenate([item.position[20:], item.position[20::-1][:20]]))
        for item in (*there, *back)
    ]
    test = replace(there[0], position=there[0].position[15:].repeat(2, axis=0)[:40])
    trace = learn_nearest_neighbor([*there[1:], *back, *loop[:0]], direction=True).recognize(test)
    assert trace.leading[5] == "there"


def test_promp_prefixes_have_the_likelihood_of_their_gaussian(train: list[Demonstration]) -> None:
    classifier = learn_promp(train)
    test = train[0].segment(0, 12)
    scores = []
    for pace in range(7):
        mean, factor = classifier._gaussian("over", pace, test.time)
        density = multivariate_normal(mean.ravel(), factor @ factor.T)
        scores.append(density.logpdf(test.position[:, :2].ravel()))
    expected = np.logaddexp.reduce(scores) - np.log(7.0)
    assert classifier.recognize(test).log_likelihood[-1, 0] == pytest.approx(expected, rel=1e-9)


def test_promp_bears_uneven_sampling(train: list[Demonstration]) -> None:
    uneven = replace(train[0], time=np.sort(np.random.default_rng(1).uniform(0.0, 2.0, 40)))
    assert learn_promp(train).recognize(uneven).leading[-1] == "over"


def test_a_library_without_a_motion_is_what_learning_the_others_alone_gives() -> None:
    """Motions that were learned before are taken again only where nothing else would come out."""
    demonstrations = synthetic_demonstrations(3, 0, 3, 40, pose=False)
    whole = learn_tubes(demonstrations, "robust", "phase").library
    part = learn_tubes(demonstrations[3:], "robust", "phase").library
    fresh = learn_library([replace(item) for item in demonstrations[3:]])
    assert part.labels == fresh.labels == whole.labels[1:]
    assert part["motion 1"] is whole["motion 1"]
    start = demonstrations[4].start
    for label in fresh:
        first, second = (library[label].flow_tube(Scene(), start) for library in (part, fresh))
        np.testing.assert_array_equal(first.position, second.position)
        np.testing.assert_array_equal(first.covariance, second.covariance)


@pytest.mark.parametrize("method", ["robust, phase", "dong2012"])
def test_recordings_that_share_their_start_share_tubes_and_change_no_answer(method: str) -> None:
    demonstrations = synthetic_demonstrations(3, 1, 3, 40, pose=False)
    moved = [replace(item, position=item.position - item.position[0]) for item in demonstrations]
    classifier = method_named(method)(moved)
    classifier.recognize(moved[0])
    again, alone = classifier.recognize(moved[4]), method_named(method)(moved).recognize(moved[4])
    np.testing.assert_array_equal(again.probability, alone.probability)
    np.testing.assert_array_equal(again.unknown, alone.unknown)
    other = classifier.recognize(demonstrations[4])
    assert not np.array_equal(other.log_likelihood, again.log_likelihood)
