"""The witness: sees the plant of a run as it is, period by period, and what passes a limit by whose doing."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pft_exec.geometry import Array
from pft_exec.model import Arm
from pft_exec.simulation import World

TOLERANCE = 1e-6
"""rad by which rounding may pass a joint's hard limit, and share by which it may pass another limit."""
GIVE = 0.01
"""rad by which a hand, or a push that is stronger than the motors, may press a joint against its end stop."""


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
    """rad beyond a hard position limit, whoever's doing; negative: the least distance to it."""
    trespass: float = 0.0
    """rad beyond a hard position limit by the controller's doing: of a joint that motors press on, or beyond `GIVE`."""
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
        beyond = np.maximum(lower - q, q - upper)
        self.beyond = max(self.beyond, float(np.max(beyond)))
        if (beyond > 0.0).any():
            self.trespass = max(self.trespass, self._trespass(beyond, np.sign(q - upper), q, v, tau))
        self.is_finite &= bool(np.isfinite([*q, *v, *tau]).all())

    def _driven(self, q: Array, v: Array, torque: Array) -> float:
        """The largest share of those joints that are within their limits, or speed up without any push."""
        share = np.abs(v) / self._limits[2]
        fast = share > 1.0
        if fast.any():
            share = share[~fast | (self._own_acceleration(q, v, torque) * v > 0.0)]
        return float(np.max(share, initial=0.0))

    def _trespass(self, beyond: Array, outward: Array, q: Array, v: Array, torque: Array) -> float:
        """How far those joints are beyond their limits whose motors press on, or that gave way too far.

        What a motor does beside holding up the arm is its own; that other joints' motion throws a joint about is not.
        """
        pressing = torque + self.arm.counterbalance(q) - self.arm.dynamics(q, v).bias
        is_own = (pressing * outward > 0.0) | (beyond > GIVE)
        return float(np.max(np.where(is_own, beyond, 0.0), initial=0.0))

    def _own_acceleration(self, q: Array, v: Array, torque: Array) -> Array:
        """What motors, springs and friction alone would do to the joints, (n,), rad/s^2."""
        plant, friction = self.arm.dynamics(q, v), self.arm.friction
        rubbing = friction.viscous * v + friction.coulomb * np.sign(v)
        driving = torque + self.arm.counterbalance(q) - rubbing - plant.bias
        acceleration: Array = np.linalg.solve(plant.mass_matrix, driving).astype(float)
        return acceleration
