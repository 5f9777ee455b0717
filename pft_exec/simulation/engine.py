"""The physics engine: one PyBullet client with the settings that everything here relies on.

The first link of the chain: bodies are loaded into an engine, and the `World` steps it.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pybullet

from pft_exec.exceptions import SimulationError

GRAVITY = 9.81  # m/s^2, along -z of the world
SOLVER_ITERATIONS = 50  # PyBullet's own default, stated because a reset of the simulation brings it back silently
LIQUID_ITERATIONS = 40
"""With liquid, whose many contacts cost most; measured in pouring with rigid pads: a bottle slips by 1.6 mm with 20, by
0.9 mm with 40."""


@contextmanager
def simulation_errors(doing: str) -> Iterator[None]:
    """Turn an error of PyBullet into a `SimulationError` that says what was being done."""
    try:
        yield
    except pybullet.error as error:
        raise SimulationError(f"{doing} failed: {error}.") from error


class Engine:
    """A PyBullet client: connection, gravity, physics step.

    Parameters
    ----------
    physics_step : float, s
    gui : bool
        Open PyBullet's window, in which the mouse drags links and objects; else run headless.

    Raises
    ------
    SimulationError
        If the step is not positive, a window is asked for without a display (PyBullet would end the process), or
        PyBullet cannot be started.
    """

    def __init__(self, physics_step: float, gui: bool = False) -> None:
        if not physics_step > 0.0:
            raise SimulationError(f"the physics step must be positive; got {physics_step} s.")
        if gui and sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
            raise SimulationError("a window needs a display, and DISPLAY is not set; leave gui out to run without one.")
        self.physics_step = physics_step
        self.gui = gui
        with simulation_errors("opening PyBullet's window" if gui else "starting PyBullet"):
            self.client: int = pybullet.connect(*connection_arguments(gui))
        if self.client < 0:
            raise SimulationError(f"PyBullet could not be started{' with a window' if gui else ''}.")
        self.clear()

    def clear(self, liquid: bool = False) -> None:
        """Remove every body and set gravity and solver again, which a reset loses; the solver is quicker for liquid.

        Friction as a pyramid saves a fifth of a step with liquid. The engine then knows no torsional friction: a held
        bottle moves bit for bit the same whether its coefficient is 0 or 1 m (measured).
        """
        pybullet.resetSimulation(physicsClientId=self.client)
        pybullet.setGravity(0.0, 0.0, -GRAVITY, physicsClientId=self.client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=self.physics_step,
            numSolverIterations=LIQUID_ITERATIONS if liquid else SOLVER_ITERATIONS,
            enableConeFriction=int(not liquid),
            numSubSteps=0,
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )
        if self.gui:
            pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0, physicsClientId=self.client)

    def step(self) -> None:
        """Advance by one physics step."""
        pybullet.stepSimulation(physicsClientId=self.client)

    @property
    def is_open(self) -> bool:
        """Whether the client is still connected."""
        return bool(self.client >= 0 and pybullet.isConnected(self.client))

    def close(self) -> None:
        """Disconnect; a second call does nothing."""
        if self.is_open:
            pybullet.disconnect(physicsClientId=self.client)
        self.client = -1


def connection_arguments(gui: bool) -> tuple[int, str]:
    """Arguments of ``pybullet.connect``: the kind of connection and its options."""
    return (pybullet.GUI, "--width=1280 --height=800") if gui else (pybullet.DIRECT, "")
