"""A flow tube from plain arrays: what it completes, and what it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pft_exec.exceptions import InvalidFlowTubeError
from pft_exec.learning import FlowTube
from pft_exec.recognition import OnlineRecognizer

STEPS = 20
UPRIGHT = np.tile([0.0, 0.0, 0.0, 1.0], (STEPS, 1))


def _tube(label: str = "reach", goal: tuple[float, float, float] = (1.0, 0.0, 0.0), **more: Any) -> FlowTube:
    phase = np.linspace(0.0, 1.0, STEPS)
    size = 6 if "quaternion" in more else 3
    arrays = {
        "time": phase,
        "position": np.outer(phase, goal),
        "covariance": np.tile(1e-4 * np.eye(size), (STEPS, 1, 1)),
    }
    return FlowTube(label, **(arrays | more))


def test_quaternions_are_brought_to_unit_length_and_continuous_signs() -> None:
    signs = np.where(np.arange(STEPS) % 3 == 0, -1.0, 1.0)[:, None]
    quaternion = _tube(quaternion=UPRIGHT * signs * 1.0009).quaternion
    assert quaternion is not None
    np.testing.assert_allclose(np.linalg.norm(quaternion, axis=1), 1.0, atol=1e-15)
    assert (np.sum(quaternion[1:] * quaternion[:-1], axis=1) > 0.0).all()


def test_a_signal_without_a_deviation_and_values_without_names_get_their_defaults() -> None:
    tube = _tube(continuous={"width": np.linspace(0.0, 0.1, STEPS)}, discrete={"closed": np.full((STEPS, 2), 0.5)})
    np.testing.assert_array_equal(tube.continuous_deviation["width"], np.zeros(STEPS))
    np.testing.assert_array_equal(tube.discrete_values["closed"], [0, 1])
    assert tube.at(0.5).continuous_deviation == {"width": 0.0}
    assert tube.initial_values == {"closed": 0}


@pytest.mark.parametrize("method", ["phase", "dong2012"])
def test_the_recognizer_hears_signals_of_tubes_from_plain_arrays(method: str) -> None:
    ramp = np.linspace(0.0, 1.0, STEPS)
    tubes = [_tube(label, continuous={"width": sign * ramp}) for label, sign in (("open", 1.0), ("close", -1.0))]
    recognizer = OnlineRecognizer(tubes, method=method)
    for time, position, width in zip(tubes[0].time, tubes[0].position, -ramp, strict=True):
        belief = recognizer.update(time, position, continuous={"width": width})
    assert method == "dong2012" or belief.probability["close"] > 0.9


def _skewed() -> np.ndarray:
    covariance = np.tile(np.eye(3), (STEPS, 1, 1))
    covariance[3, 0, 1] = 0.5  # the lower triangle alone is positive definite
    return covariance


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"time": "soon"}, "numbers"),
        ({"covariance": _skewed()}, "symmetric"),
        ({"quaternion": 2.0 * UPRIGHT}, "length 1"),
        ({"time_deviation": np.full(STEPS, -1.0)}, "not be negative"),
        ({"continuous": {"width": np.zeros(STEPS - 1)}}, "shape"),
        ({"continuous": {"width": np.full(STEPS, np.nan)}}, "finite"),
        (
            {"continuous": {"width": np.zeros(STEPS)}, "continuous_deviation": {"width": np.full(STEPS, -1.0)}},
            "negative",
        ),
        ({"discrete": {"closed": np.full(STEPS, 0.5)}}, "shape"),
        ({"discrete": {"closed": np.full((STEPS, 2), -0.5)}}, "negative"),
        (
            {"discrete": {"closed": np.full((STEPS, 2), 0.5)}, "discrete_values": {"closed": [0, 1, 2]}},
            "discrete_values",
        ),
    ],
)
def test_arrays_that_make_no_tube_are_refused(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(InvalidFlowTubeError, match=words):
        _tube(**fields)
