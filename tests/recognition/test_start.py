from dataclasses import replace

import numpy as np
import pytest

from pft_exec.recognition import OnlineRecognizer
from pft_exec.recognition.evidence import gather_evidence, measure_scales
from pft_exec.recognition.settings import DEFAULT_SETTINGS
from pft_exec.recognition.start import follow_starts
from tests.recognition.tubes import line

SHIFTS = 0.012 * np.array([-1.0, -0.5, 0.0, 0.5, 1.0])


def _offset_line(label, direction, kept, seed=0):
    """A motion whose demonstrations begin off the mean, across, and keep `kept` of it to the end."""
    tube = line(label, direction, deviation=0.003, seed=seed)
    fade = 1.0 - (1.0 - kept) * np.linspace(0.0, 1.0, len(tube))
    shift = SHIFTS[:, None, None] * fade[None, :, None] * np.array([0.0, 0.0, 1.0])
    aligned = replace(tube.aligned, position=tube.aligned.position + shift)
    covariance = tube.covariance + np.diag([0.0, 0.0, 0.012**2])
    return replace(tube, aligned=aligned, covariance=covariance)


def _evidence(tubes):
    scales = measure_scales(tubes, ())
    return follow_starts([gather_evidence(tube, scales, DEFAULT_SETTINGS) for tube in tubes], DEFAULT_SETTINGS)


@pytest.mark.parametrize("kept", [1.0, 0.0])
def test_what_the_demonstrations_kept_of_their_start_is_learned(kept):
    """The share is 1 at the start, and near what was kept at the end; what is left there is narrower."""
    evidence = _evidence([_offset_line("a", [1.0, 0.0, 0.0], kept), _offset_line("b", [0.0, 1.0, 0.0], kept, seed=1)])
    for item in evidence:
        assert item.follow[0] == pytest.approx(1.0, abs=0.01)
        assert item.follow[-1] == pytest.approx(kept, abs=0.15)
        assert np.abs(item.conditioned[:, 0]).max() < 1e-3


def test_tubes_that_begin_where_the_hand_does_follow_nothing():
    """Where all starts agree there is nothing to learn, and the scatter stays as it was."""
    tubes = [line("a", [1.0, 0.0, 0.0]), line("b", [0.0, 1.0, 0.0])]
    for item in _evidence(tubes):
        assert not item.follow.any()
        np.testing.assert_array_equal(item.conditioned, item.position)


def _mean_likelihood(tubes, offset):
    recognizer = OnlineRecognizer(tubes)
    start = recognizer.update(0.0, tubes[0].position[0] + offset).log_likelihood["a"]
    for n in range(1, 100):
        belief = recognizer.update(0.02 * n, tubes[0].at(n / 99).position + offset)
    return start, belief.log_likelihood["a"]


def test_a_constant_offset_is_paid_once():
    """Two standard deviations off all along costs little more at the end than it did at the start: 0.5 beyond it."""
    tubes = [_offset_line("a", [1.0, 0.0, 0.0], 1.0), _offset_line("b", [0.0, 1.0, 0.0], 1.0, seed=1)]
    offset = np.array([0.0, 0.0, 0.018])
    start, end = _mean_likelihood(tubes, np.zeros(3))
    start_off, end_off = _mean_likelihood(tubes, offset)
    assert start > start_off
    assert (end - end_off) - (start - start_off) < 0.5


def test_a_start_says_nothing_where_no_motion_has_one():
    """Both tubes begin where the hand does: after the first sample both are alike."""
    tubes = [line("a", [1.0, 0.0, 0.0]), line("b", [0.0, 1.0, 0.0])]
    belief = OnlineRecognizer(tubes).update(0.0, [0.0, 0.0, 0.0])
    assert belief.probability["a"] == pytest.approx(0.5, abs=0.05)


def test_starts_apart_tell_motions_apart():
    """Two motions in one direction from places twenty deviations apart: the nearer one leads from the first sample."""
    near = _offset_line("near", [1.0, 0.0, 0.0], 1.0)
    shift = np.array([0.0, 0.2, 0.0])
    aligned = replace(near.aligned, position=near.aligned.position + shift)
    far = replace(near, label="far", position=near.position + shift, aligned=aligned)
    for label, place in (("near", np.zeros(3)), ("far", shift)):
        belief = OnlineRecognizer([near, far]).update(0.0, place)
        assert belief.label == label


def test_an_offset_is_kept_when_an_object_moves():
    """New tubes lean as the old ones did: the likelihood of the next sample hardly differs."""
    tubes = [_offset_line("a", [1.0, 0.0, 0.0], 1.0), _offset_line("b", [0.0, 1.0, 0.0], 1.0, seed=1)]
    offset, kept, renewed = np.array([0.0, 0.0, 0.018]), OnlineRecognizer(tubes), OnlineRecognizer(tubes)
    for n in range(80):
        if n == 50:
            renewed.replace(tubes)
        place = tubes[0].at(n / 99).position + offset
        expected, belief = (r.update(0.02 * n, place).log_likelihood["a"] for r in (kept, renewed))
    assert belief == pytest.approx(expected, abs=1e-6)
