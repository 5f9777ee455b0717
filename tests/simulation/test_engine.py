"""The engine: settings survive a reset, a client of its own, errors of the library translated."""

from __future__ import annotations

import sys

import pybullet
import pytest

from pft_exec.exceptions import SimulationError
from pft_exec.simulation.engine import SOLVER_ITERATIONS, Engine, connection_arguments, simulation_errors


def test_settings_survive_a_clear() -> None:
    engine = Engine(2e-3)
    engine.clear()
    parameters = pybullet.getPhysicsEngineParameters(physicsClientId=engine.client)
    assert parameters["fixedTimeStep"] == 2e-3
    assert parameters["gravityAccelerationZ"] == -9.81
    assert parameters["numSolverIterations"] == SOLVER_ITERATIONS
    engine.close()
    assert not engine.is_open


def test_a_window_is_asked_for_only_with_gui() -> None:
    assert connection_arguments(False)[0] == pybullet.DIRECT
    kind, options = connection_arguments(True)
    assert kind == pybullet.GUI
    assert "--width" in options


def test_a_step_that_is_not_positive_is_refused() -> None:
    with pytest.raises(SimulationError, match=r"the physics step must be positive; got -0.001 s"):
        Engine(-1e-3)


def test_errors_of_the_engine_say_what_was_done() -> None:
    with pytest.raises(SimulationError, match="reading a body failed"), simulation_errors("reading a body"):
        pybullet.getNumJoints(99, physicsClientId=99)


def test_an_engine_that_does_not_start_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pybullet, "connect", lambda *_: -1)
    with pytest.raises(SimulationError, match="PyBullet could not be started"):
        Engine(1e-3)


def test_a_window_without_a_display_is_refused_before_it_ends_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(SimulationError, match="DISPLAY is not set"):
        Engine(1e-3, gui=True)
