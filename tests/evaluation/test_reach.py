"""Generation: errors on predictions known by hand, predictors on demonstrations known in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.demonstration.synthetic import minimum_jerk
from pft_exec.evaluation.reach import (
    PHASES,
    PREDICTORS,
    Prediction,
    bending,
    compare,
    evaluate_reach,
    product_of_gaussians,
    similarity,
    straight_line,
)
from pft_exec.geometry import quaternion_from_rotation_vector


def reach(
    target: tuple[float, float], angle: float, start: tuple[float, float] = (0.0, 0.0), bow: float = 0.0
) -> Demonstration:
    """A minimum-jerk reach to a target frame, bowed to the left by a share of its length."""
    share = minimum_jerk(np.linspace(0.0, 1.0, PHASES))[:, None]
    way = np.array(target) - start
    path = np.array(start) + share * way + bow * np.sin(np.pi * share) * np.array([-way[1], way[0]])
    turn = quaternion_from_rotation_vector([0.0, 0.0, angle])
    return Demonstration(
        "reach",
        np.linspace(0.0, 1.0, PHASES),
        np.concatenate([path, np.zeros((PHASES, 1))], axis=1),
        objects={
            "frame1": np.array([*start, 0.0, 0.0, 0.0, 0.0, 1.0]),
            "frame2": np.array([*target, 0.0, *turn]),
        },
    )


def test_a_perfect_prediction_has_no_error() -> None:
    truth = reach((1.0, 2.0), 0.0)
    errors = compare(Prediction(truth.position[:, :2], np.tile(0.01 * np.eye(2), (PHASES, 1, 1))), truth)
    assert (errors.rmse, errors.warped, errors.end) == (0.0, 0.0, 0.0)
    assert errors.coverage == (1.0, 1.0, 1.0)
    assert errors.log_density == pytest.approx(-np.log(2.0 * np.pi * 0.01))


def test_a_shifted_prediction_is_off_by_its_shift() -> None:
    truth = reach((3.0, 4.0), 0.0)
    errors = compare(Prediction(truth.position[:, :2] + [0.0, 0.1], np.tile(np.eye(2), (PHASES, 1, 1))), truth)
    assert errors.rmse == pytest.approx(0.1)
    assert errors.end == pytest.approx(0.1)
    assert errors.warped <= 0.1 / 5.0 + 1e-12


def test_coverage_of_samples_drawn_from_the_prediction_is_nominal() -> None:
    rng = np.random.default_rng(1)
    factor = rng.standard_normal((2, 2))
    mean = np.stack([np.linspace(0.0, 1.0, PHASES), np.zeros(PHASES)], axis=1)
    covered = []
    for _ in range(200):
        path = mean + rng.standard_normal((PHASES, 2)) @ factor.T
        truth = Demonstration("x", np.linspace(0.0, 1.0, PHASES), np.concatenate([path, np.zeros((PHASES, 1))], axis=1))
        covered.append(compare(Prediction(mean, np.tile(factor @ factor.T, (PHASES, 1, 1))), truth).coverage)
    np.testing.assert_allclose(np.mean(covered, axis=0), [0.683, 0.954, 0.997], atol=0.01)


TRAIN = [
    reach((1.0, 2.0), 0.3, bow=0.20),
    reach((-2.0, 1.0), 1.0, (0.5, 0.0), 0.25),
    reach((2.0, -1.0), -0.5, (0.0, 0.3), 0.30),
]


@pytest.mark.parametrize("predict", [straight_line, similarity, bending, product_of_gaussians])
def test_predictions_end_at_the_target(predict: object) -> None:
    truth = reach((3.0, 1.0), 0.4, (0.2, 0.1))
    prediction = predict(TRAIN, truth)  # type: ignore[operator]
    np.testing.assert_allclose(prediction.mean[-1], [3.0, 1.0], atol=0.02)
    np.testing.assert_allclose(prediction.mean[0], [0.2, 0.1], atol=0.02)
    assert (np.linalg.eigvalsh(prediction.covariance) > 0.0).all()


def test_similarity_carries_a_scaled_bow_exactly() -> None:
    truth = reach((3.0, 1.0), 0.4, (0.2, 0.1), bow=0.25)
    assert compare(similarity(TRAIN, truth), truth).rmse < 1e-3
    assert compare(straight_line(TRAIN, truth), truth).rmse > 0.3


def test_bending_keeps_the_shape_of_what_it_bends() -> None:
    """A scene equal to the one taught gives the taught path back."""
    taught = [reach((1.0, 2.0), 0.3, bow=bow) for bow in (0.2, 0.3)]
    truth = reach((1.0, 2.0), 0.3, bow=0.25)
    assert compare(bending(taught, truth), truth).rmse < 1e-9


def test_product_of_gaussians_follows_each_frame_near_its_end() -> None:
    truth = reach((3.0, 1.0), 0.4, (0.2, 0.1), bow=0.25)
    covariance = product_of_gaussians(TRAIN, truth).covariance
    widths = np.sqrt(np.linalg.det(covariance)) ** 0.5
    assert widths[0] < widths[PHASES // 2] > widths[-1]


@pytest.mark.data
@pytest.mark.slow
def test_the_product_of_gaussians_reaches_what_was_known_of_it(recordings: Path) -> None:
    """reach_target, five taught: known median 6.6 px and 3.1 % of the path."""
    result = evaluate_reach(recordings, draws=10)
    errors = result.errors["product of Gaussians"]
    assert np.median([item.rmse for item in errors]) == pytest.approx(6.6, abs=0.5)
    assert np.median([item.warped for item in errors]) == pytest.approx(0.031, abs=0.004)
    assert len(errors) == 90
    assert [row["method"] for row in result.table()][: len(PREDICTORS)] == list(PREDICTORS)
