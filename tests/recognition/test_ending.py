"""Where a motion may end."""

import numpy as np

from pft_exec.geometry import multiply, quaternion_from_rotation_vector, rotate
from pft_exec.learning.flow_tube import AlignedDemonstrations, FlowTube
from pft_exec.recognition import OnlineRecognizer
from pft_exec.recognition.emission import Emission, whitened
from pft_exec.recognition.ending import may_end
from tests.recognition.tubes import line

STEPS = 100


def _emission(deviation, turn_deviation=0.1, freedom=8.0, rotation=None):
    """The same covariances at each step; those of position in a frame turned by `rotation`."""
    axes = np.eye(3) if rotation is None else rotate(rotation, np.eye(3)).T
    position = axes @ np.diag(np.square(deviation)) @ axes.T
    blocks = np.stack([position, np.eye(3), np.eye(3) * turn_deviation**2])
    white, determinant = whitened(np.repeat(blocks[:, None], STEPS, axis=1), np.ones((3, 3), dtype=bool))
    return Emission(white, np.zeros((9, STEPS)), determinant, freedom)


def _tube(position, quaternion=None):
    size = 3 if quaternion is None else 6
    covariance = np.tile(np.eye(size) * 1e-4, (len(position), 1, 1))
    return FlowTube("a", np.linspace(0.0, 1.0, len(position)), position, quaternion, covariance)


def _straight(length=0.4):
    return np.linspace(0.0, length, STEPS)[:, None] * np.array([1.0, 0.0, 0.0])


def test_steps_within_the_scatter_of_the_ends_may_be_an_end():
    """One deviation before the end it is usual, at ten hardly; the Student t of three axes, by hand."""
    ending = may_end(_tube(_straight()), _emission([0.02, 0.02, 0.02]))
    distance = (0.4 - _straight()[:, 0]) / 0.02
    np.testing.assert_allclose(ending, (1.0 + distance**2 / 8.0) ** -5.5, rtol=1e-9)
    assert ending[-1] == 1.0


def test_a_closed_motion_does_not_end_where_it_begins():
    angle = np.linspace(0.0, 2.0 * np.pi, STEPS)
    circle = 0.1 * np.stack([np.cos(angle), np.sin(angle), np.zeros(STEPS)], axis=1)
    ending = may_end(_tube(circle), _emission([0.01] * 3))
    assert ending[0] < 1e-6
    assert (np.diff(ending) >= 0.0).all()


def test_a_motion_that_only_turns_ends_where_it_has_turned():
    turned = quaternion_from_rotation_vector(np.linspace(0.0, 1.5, STEPS)[:, None] * np.array([0.0, 0.0, 1.0]))
    ending = may_end(_tube(np.zeros((STEPS, 3)), turned), _emission([0.01] * 3))
    assert ending[0] < 1e-6
    assert ending[-2] > 0.9


def test_a_rigid_motion_of_the_scene_changes_nothing():
    rotation = quaternion_from_rotation_vector([0.3, -0.4, 1.1])
    turned = quaternion_from_rotation_vector(np.linspace(0.0, 0.3, STEPS)[:, None] * np.array([0.0, 1.0, 0.0]))
    here = may_end(_tube(_straight(), turned), _emission([0.02, 0.05, 0.1]))
    moved = _tube(rotate(rotation, _straight()) + 0.7, multiply(rotation, turned))
    np.testing.assert_allclose(may_end(moved, _emission([0.02, 0.05, 0.1], rotation=rotation)), here, rtol=1e-9)


def test_a_quick_hand_that_stops_a_little_short_is_not_believed_to_pass():
    """One motion stops where another, along the same way, goes on; when the hand stops, the phase lags behind 1."""
    recognizer, taught, pace = OnlineRecognizer([_scattered("stops", 1.0), _scattered("passes", 1.5)]), 1.6, 2.2
    hand = _scattered("stops", 1.0)
    for time in np.arange(0.0, taught / pace + 0.05, 0.01):
        belief = recognizer.update(time, 0.75 * hand.at(min(pace * time / taught, 1.0)).position)
    assert belief.phase["stops"] < 0.9
    assert belief.probability["stops"] > 0.95


def _scattered(label, reach, deviation=0.05):
    """A motion `reach` times as long as `line`'s, whose demonstrations end apart; all begin at one place."""
    tube = line(label, np.array([reach, 0.0, 0.0]), duration=1.0 + 0.6 * reach)
    share = tube.position[:, :1] / tube.position[-1, 0]
    ends = deviation * np.random.default_rng(5).normal(size=(5, 1, 3)) * np.array([1.0, 1.0, 0.0])
    position = tube.position + share * (ends - ends.mean(axis=0))
    return FlowTube(
        label,
        tube.time,
        tube.position,
        None,
        np.tile(np.eye(3) * deviation**2, (len(tube), 1, 1)),
        tube.time_deviation,
        count=5,
        aligned=AlignedDemonstrations(position, None, tube.aligned.time),
    )
