"""A sudden push: found by its impulse within milliseconds; an impact, a weak push and noise are none."""

from __future__ import annotations

import numpy as np

from pft_exec.handoff.sudden_push import IMPULSE, OUTSTANDING, SuddenPush

PERIOD, ALLOWED = 0.001, 15.0
QUIET = np.zeros((100, 3))
AXIS = np.array([0.6, 0.0, -0.8])


def found(forces, push=None):
    """Periods in which a push is seen in forces (T, 3), N."""
    push = SuddenPush(hold_time=0.002) if push is None else push
    return [k for k, force in enumerate(forces) if push.update(PERIOD * k, force, np.zeros(3), ALLOWED)]


def lasting(size, count=200):
    return np.vstack([QUIET, np.tile(size * AXIS, (count, 1))])


def noise(generator, deviation, count):
    """Forces (T, 3), N, of an arm of 2 kg at rest whose velocity is measured with a deviation, m/s."""
    velocity = deviation * generator.standard_normal((count + 1, 3))
    return 2.0 * np.diff(velocity, axis=0) / PERIOD


def test_a_push_is_found_as_soon_as_its_impulse_beyond_what_is_allowed_has_lasted():
    """21 N give 0.01 N s beyond 15 N in 2 ms, 40 N at once; either has to last for 2 ms more."""
    assert found(lasting(21.0))[0] == 100 + 3
    assert found(lasting(40.0))[0] == 100 + 2


def test_a_push_below_what_is_allowed_is_never_found():
    assert found(lasting(14.9, 2000)) == []


def test_an_impact_is_over_before_it_counts():
    impact = np.vstack([QUIET, 45.0 * AXIS[None], QUIET])
    assert np.linalg.norm(impact.sum(axis=0)) * PERIOD > 4.0 * IMPULSE
    assert found(impact) == []


def test_noise_of_the_velocities_does_not_pile_up_and_is_told_from_a_push():
    generator = np.random.default_rng(3)
    still = noise(generator, 0.004, 5000)
    push = SuddenPush(hold_time=0.002)
    assert found(still, push) == []
    assert push.outstanding(2.0 * IMPULSE * AXIS, PERIOD) < OUTSTANDING
    pushed = np.vstack([still, noise(generator, 0.004, 100) + 40.0 * AXIS])
    assert 5000 < found(pushed)[0] <= 5010


def test_after_forgetting_the_impulse_begins_at_nothing_again():
    push = SuddenPush(hold_time=0.002)
    assert found(lasting(20.0, 3), push) == []
    push.forget()
    assert found(np.tile(20.0 * AXIS, (4, 1)), push) == []
    push.forget()
    assert found(np.tile(20.0 * AXIS, (8, 1)), push) != []


def test_what_is_usual_is_no_part_of_a_push():
    push, usual = SuddenPush(hold_time=0.002), 9.0 * AXIS
    assert not any(push.update(PERIOD * k, 20.0 * AXIS, usual, ALLOWED) for k in range(500))
    assert any(push.update(PERIOD * (500 + k), 31.0 * AXIS, usual, ALLOWED) for k in range(5))


def test_a_push_across_the_heavy_direction_is_found_though_the_noise_along_it_is_large():
    """Three times the noise along x does not delay a push along z, and is no push by itself."""
    generator = np.random.default_rng(5)
    scale, push = np.array([3.0, 1.0, 1.0]), SuddenPush(hold_time=0.002)
    still = scale * noise(generator, 0.003, 20000)
    assert found(still, push) == []
    along = {}
    for axis in (0, 2):
        pushed = scale * noise(generator, 0.003, 100) + 25.0 * np.eye(3)[axis]
        along[axis] = found(np.vstack([still[:2000], pushed]), SuddenPush(hold_time=0.002))[0] - 2000
    assert 0 < along[2] <= 10
    assert along[0] >= along[2] + 5
