r"""Disturbance: what sensors, motors and load of the real arm do that its model does not say.

A `Mismatch` says how far plant and model differ; `Disturbance` is one robot's state of it: the noise of this instant,
the torques still under way. They act at two places only, where joint states come out of the engine and where torques go
in. Without a mismatch neither place does anything.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pft_exec.description import random_stream
from pft_exec.exceptions import SimulationError
from pft_exec.geometry import Array

Encoder = Callable[[Array, Array], tuple[Array, Array]]
"""From an arm's measured configuration and velocity (n,) to what its encoders report instead."""

RIPPLE_CYCLES = 22.0
"""Ripples in a radian of the joint: a motor of 7 pole pairs behind a gear of 20 (placeholder, grade C)."""


@dataclass(frozen=True)
class Mismatch:
    """How the plant differs from the model that every controller has; the default is: not at all.

    Parameters
    ----------
    friction : float
        Factor to the joints' Coulomb and viscous friction.
    payload : float, kg
        Point mass at the tool's origin that no model knows of, with its weight and its inertia.
    encoder_noise : float, rad
        Standard deviation of each measured joint position, white, drawn anew at each physics step.
    velocity_noise : float, rad/s
        The same of each measured joint velocity; a velocity filtered from such an encoder has about 30 times as much.
    torque_ripple : float
        Amplitude, as a share of the commanded torque, of a ripple that is periodic in the joint's position.
    delay : int
        Control periods after which a commanded torque acts.
    strength : float
        Share of its torque limit that each motor delivers at most.
    seed : int
        Of the noise and of the ripple's phase.

    Raises
    ------
    SimulationError
        If a value is negative or not finite, or `strength` lies outside [0, 1].
    """

    friction: float = 1.0
    payload: float = 0.0
    encoder_noise: float = 0.0
    velocity_noise: float = 0.0
    torque_ripple: float = 0.0
    delay: int = 0
    strength: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise SimulationError(f"{name} of a mismatch must be a finite number of at least 0; got {value}.")
        if self.strength > 1.0:
            raise SimulationError(f"a motor's strength is a share of its limit, at most 1; got {self.strength}.")

    @property
    def is_noisy(self) -> bool:
        """Whether measured states differ from true ones."""
        return self.encoder_noise > 0.0 or self.velocity_noise > 0.0


ORDINARY = Mismatch(friction=1.2, payload=0.5, encoder_noise=1e-4, velocity_noise=3e-3, torque_ripple=0.02, delay=1)
"""Everything that is ordinarily wrong, at once."""


class Disturbance:
    """The state of a mismatch in one robot of J joints.

    Parameters
    ----------
    mismatch : Mismatch
    joints : int
        J.
    steps_per_period : int
        Physics steps in a control period.
    """

    def __init__(self, mismatch: Mismatch, joints: int, steps_per_period: int) -> None:
        self.mismatch = mismatch
        self._steps = mismatch.delay * steps_per_period
        self._rng = random_stream(mismatch.seed, "mismatch")
        self._ripple_phase = self._rng.uniform(0.0, 2.0 * np.pi, joints)
        self._noise = np.zeros((2, joints))
        self._under_way: dict[str, deque[Array]] = {}
        self.advance()

    def advance(self) -> None:
        """Draw the noise of the next instant; once a physics step, however often it is measured."""
        if self.mismatch.is_noisy:
            noise = self._rng.standard_normal(self._noise.shape)
            self._noise = noise * [[self.mismatch.encoder_noise], [self.mismatch.velocity_noise]]

    def measured(self, columns: slice, q: Array, v: Array) -> tuple[Array, Array]:
        """What the encoders of the joints in `columns` report of their true state."""
        return q + self._noise[0, columns], v + self._noise[1, columns]

    def hold(self, arm: str, torque: Array) -> None:
        """Begin with a torque that acts until the first command arrives."""
        self._under_way[arm] = deque([torque] * self._steps)

    def delivered(self, arm: str, columns: slice, torque: Array, q: Array) -> Array:
        """Torque that the motors of an arm deliver in the coming step, (n,), N m.

        Parameters
        ----------
        arm : str
        columns : slice
            Of the arm's joints.
        torque : (n,), N m
            Commanded now.
        q : (n,), rad
            True.
        """
        if self._steps:
            line = self._under_way[arm]
            line.append(torque.copy())
            torque = line.popleft()
        if self.mismatch.torque_ripple > 0.0:
            wave = np.sin(RIPPLE_CYCLES * q + self._ripple_phase[columns])
            torque = torque * (1.0 + self.mismatch.torque_ripple * wave)
        return torque
