import numpy as np

from pft_exec.recognition.elementary import exponentiate, take_logarithm


def test_exponentials_are_those_of_numpy():
    """To 2 units in the last place, from 0 down to where it hardly differs from nothing; below that, at most that."""
    rng = np.random.default_rng(0)
    values = np.concatenate([[0.0, -1e-300, -700.0], -rng.exponential(size=5000), -rng.uniform(0.0, 700.0, 5000)])
    result = values.copy()
    exponentiate(result, np.empty_like(result))
    np.testing.assert_allclose(result, np.exp(values), rtol=2 * np.finfo(float).eps)
    beyond = np.array([-701.0, -1e9, -1e300])
    exponentiate(beyond, np.empty(3))
    assert (beyond <= np.exp(-699.9)).all()


def test_logarithms_are_those_of_numpy():
    """To 2 units in the last place, for all magnitudes and close to 1."""
    rng = np.random.default_rng(1)
    wide, close = 10.0 ** rng.uniform(-300.0, 300.0, 5000), 1.0 + 10.0 ** rng.uniform(-16.0, 0.0, 5000)
    values = np.concatenate([[1.0, 2.0, 0.5], wide, close])
    result = values.copy()
    take_logarithm(result, np.empty_like(result))
    np.testing.assert_allclose(result, np.log(values), rtol=2 * np.finfo(float).eps, atol=1e-300)


def test_no_caller_relaxes_their_arithmetic():
    """Compiled first from a caller with fastmath, an exponential of 0 was 0.71."""
    assert exponentiate.targetoptions["fastmath"] is False
    assert take_logarithm.targetoptions["fastmath"] is False
