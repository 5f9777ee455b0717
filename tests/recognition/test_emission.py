import numpy as np

from pft_exec.recognition.emission import whitened
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
