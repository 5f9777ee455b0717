from dataclasses import replace

import numpy as np

from pft_exec.recognition.coupling import pooled_correlation
from pft_exec.recognition.emission import coupled
from pft_exec.recognition.evidence import gather_evidence, measure_scales
from pft_exec.recognition.settings import DEFAULT_SETTINGS
from tests.recognition.tubes import random_covariances, star


def _lower(rows):
    factor = np.zeros((rows.shape[1], 3, 3))
    factor[:, [0, 1, 1, 2, 2, 2], [0, 0, 1, 0, 1, 2]] = rows.T
    return factor


def test_position_and_direction_given_it_have_the_density_of_both():
    """Squared distances and determinants equal those of the whole 6 x 6 covariance, to 1e-9."""
    rng = np.random.default_rng(0)
    whole = random_covariances(rng, 40, 6)
    covariance = np.stack([whole[:, :3, :3], whole[:, 3:, 3:], random_covariances(rng, 40, 3)])
    white, log_determinant, gain = coupled(covariance, whole[:, 3:, :3], np.ones((3, 3), dtype=bool))
    place, heading = rng.normal(size=(2, 40, 3))
    given = heading - np.einsum("ijn,nj->ni", gain.reshape(3, 3, -1), place)
    parts = [np.einsum("nij,nj->ni", _lower(rows), r) for rows, r in ((white[:6], place), (white[6:12], given))]
    both = np.concatenate([place, heading], axis=1)
    expected = np.einsum("ni,nij,nj->n", both, np.linalg.inv(whole), both)
    np.testing.assert_allclose(sum((part**2).sum(axis=1) for part in parts), expected, rtol=1e-9)
    np.testing.assert_allclose(log_determinant[:2].sum(axis=0), np.linalg.slogdet(whole)[1], rtol=1e-9)


def test_an_axis_that_does_not_count_says_nothing_of_the_others():
    """Its rows of the whitening and of the regression are zero."""
    rng = np.random.default_rng(1)
    kept = np.array([[True, True, False]] * 3)
    whole = random_covariances(rng, 10, 6)
    covariance = np.where(kept[:, None, :, None] & kept[:, None, None, :], whole[:, :3, :3], np.eye(3))
    _, _, gain = coupled(covariance, 0.1 * whole[:, 3:, :3], kept)
    rows = gain.reshape(3, 3, -1)
    assert np.abs(rows[2]).max() == 0.0
    assert np.abs(rows[:, 2]).max() == 0.0
    assert np.abs(rows[:2, :2]).max() > 0.0


def _correlation(tubes):
    scales = measure_scales(tubes, ())
    return pooled_correlation([gather_evidence(tube, scales, DEFAULT_SETTINGS) for tube in tubes])


def test_a_bow_repeats_itself_in_the_direction_first_one_way_then_the_other():
    """Demonstrations that bow: they head away from the mean in the first half and back to it in the second."""
    correlation = _correlation(star(deviation=0.01))
    assert correlation[10:40].min() > 0.3
    assert correlation[60:90].max() < -0.3


def test_demonstrations_that_lie_side_by_side_head_the_same_way():
    """A constant offset says nothing of the direction: no correlation."""
    tubes = []
    for tube in star(deviation=1e-6):
        offset = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])[:, None, None] * np.array([0.0, 0.0, 0.01])
        tubes.append(replace(tube, aligned=replace(tube.aligned, position=tube.aligned.position + offset)))
    assert np.abs(_correlation(tubes)).max() < 0.3
