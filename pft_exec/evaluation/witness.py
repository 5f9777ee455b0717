"""The witness: sees the plant of a run as it is, period by period, and what passes a limit by whose doing."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pft_exec.geometry import Array
from pft_exec.model import Arm
from pft_exec.simulation import World

TOLERANCE = 1e-6
"""rad by which rounding may pass a joint's hard limit, and share by which it may pass another limit."""


@dataclass
class Witness:
    """Largest shares of limits that any joint of an arm had; no controller sees it.

    Parameters
    ----------
    name : str
        Of the arm.
    arm : Arm
        What the plant is, unknown load and friction apart.
    """

    name: str
    arm: Arm
    torque: float = 0.0
    """Share of the limit."""
    velocity: float = 0.0
    """Share of the limit, whoever's doing."""
    driven: float = 0.0
    """Share of the velocity limit by the controller's doing: a joint beyond it counts where the motors speed it up."""
    beyond: float = -np.inf
    """rad beyond a hard position limit; negative: the least distance to it."""
    is_finite: bool = True
    _limits: tuple[Array, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        limits = self.arm.limits
        self._limits = limits.hard_lower, limits.hard_upper, limits.velocity, limits.torque

    def look(self, world: World) -> None:
        """After a control period."""
        lower, upper, velocity, torque = self._limits
        (q, v), tau = world.true_state(self.name), world.torque(self.name)
        self.torque = max(self.torque, float(np.max(np.abs(tau) / torque)))
        self.velocity = max(self.velocity, float(np.max(np.abs(v) / velocity)))
        self.driven = max(self.driven, self._driven(q, v, tau))
        self.beyond = max(self.beyond, float(np.max(np.maximum(lower - q, q - upper))))
        self.is_finite &= bool(np.isfinite([*q, *v, *tau]).all())

    def _driven(self, q: Array, v: Array, torque: Array) -> float:
        """The largest share of those joints that are within their limits, or speed up without any push."""
        share = np.abs(v) / self._limits[2]
        fast = share > 1.0
        if fast.any():
            share = share[~fast | (self._own_acceleration(q, v, torque) * v > 0.0)]
        return float(np.max(share, initial=0.0))

    def _own_acceleration(self, q: Array, v: Array, torque: Array) -> Array:
        """What motors, springs and friction alone would do to the joints, (n,), rad/s^2."""
        plant, friction = self.arm.dynamics(q, v), self.arm.friction
        rubbing = friction.viscous * v + friction.coulomb * np.sign(v)
        driving = torque + self.arm.counterbalance(q) - rubbing - plant.bias
        acceleration: Array = np.linalg.solve(plant.mass_matrix, driving).astype(float)
        return acceleration
