"""No control period waits for the collector of garbage, or for code that was not loaded."""

from __future__ import annotations

import gc

import numpy as np
import pytest

from pft_exec import World
from pft_exec.exceptions import UnknownMethodError
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.surroundings import Surroundings
from pft_exec.execution.timeliness import undisturbed, warm_up


@undisturbed()
def _asked() -> bool:
    return gc.isenabled()


def test_the_collector_rests_meanwhile_and_only_then():
    assert gc.isenabled()
    assert not _asked()
    assert gc.isenabled()
    with pytest.raises(ZeroDivisionError), undisturbed():
        _ = 1 / 0
    assert gc.isenabled()


def test_a_collector_that_rested_before_goes_on_resting():
    with undisturbed():
        assert not _asked()
        assert not gc.isenabled()


@pytest.mark.parametrize("avoid", [False, True])
def test_nothing_of_the_world_is_changed_by_warming_up(avoid):
    with World("pr2", "tabletop", seed=0) as world:
        loop = ControlLoop(world)
        if avoid:
            loop.surroundings = Surroundings(world, loop.name, ("table",))
        q, v = loop.sense()
        warm_up(loop)
        assert world.time == 0.0
        np.testing.assert_array_equal(world.state(loop.name), (q, v))


def test_a_solver_that_does_not_exist_is_refused():
    with World("pr2", "tabletop", seed=0) as world, pytest.raises(UnknownMethodError):
        warm_up(ControlLoop(world), "dapq")
