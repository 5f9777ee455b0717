import numpy as np
import pytest

from pft_exec.recognition.emission import tail_freedom, whitened
from pft_exec.recognition.settings import PhaseSettings
from tests.recognition.tubes import random_covariances


def test_whitening_is_the_inverse_cholesky_factor():
    """To 1e-9 of numpy's, determinants too; an axis that does not count has rows of zeros."""
    rng = np.random.default_rng(0)
    covariance = random_covariances(rng, 150, 3).reshape(3, 50, 3, 3)
    white, log_determinant = whitened(covariance, np.array([[True, True, True], [True, True, False], [True] * 3]))
    expected = np.linalg.inv(np.linalg.cholesky(covariance))
    expected[1, :, 2] = 0.0
    rows = [expected[:, :, a, b] for a in range(3) for b in range(a + 1)]
    np.testing.assert_allclose(white, np.stack(rows, axis=1).reshape(18, -1), rtol=1e-9)
    np.testing.assert_allclose(log_determinant, np.linalg.slogdet(covariance)[1], rtol=1e-9)


@pytest.mark.parametrize(("count", "freedom"), [(0, 4.0), (2, 5.0), (5, 8.0), (30, 8.0)])
def test_many_demonstrations_do_not_make_the_tails_those_of_a_gaussian(count, freedom):
    """The freedom of the Student t grows with the demonstrations up to that of five."""
    assert tail_freedom(count, PhaseSettings()) == freedom
