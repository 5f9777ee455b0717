r"""Gravity compensation: the arm floats, a little damped; what teaching uses and what every fault falls back to.

.. math:: \tau = g(q) - \tau_{cb}(q) - D v - \tau_{wall}(q, v),

clipped at the torque limits. It is passive: it adds no energy that it did not take. Near a joint's soft limit
a wall, a spring and damper that begins a margin before the limit, turns the arm back under the hand.
"""

from __future__ import annotations

import numpy as np

from pft_exec.control.command import Command
from pft_exec.geometry import Array
from pft_exec.model import Arm

TEACH_DAMPING = 0.5
"""N m s/rad; keeps the elbow from swinging while the hand leads (swivel drift 0.04 rad instead of 0.48; measured)."""
WALL_MARGIN = 0.05
"""rad before the soft limit at which the wall begins."""
WALL_SHARE = 0.5
"""Share of a joint's torque that the wall pushes with at the limit itself."""


class GravityCompensation:
    """Let an arm float.

    Parameters
    ----------
    arm : Arm
    damping : float, N m s/rad
        Of every joint; scaled down where a joint's torque limit is below 10 N m.
    """

    def __init__(self, arm: Arm, damping: float = TEACH_DAMPING) -> None:
        self.arm = arm
        self.damping = np.full(len(arm.joint_names), damping)
        self._last = np.zeros(len(arm.joint_names))
        self._seen = False

    def update(self, time: float, q: Array, v: Array, status: str = "gravity compensation") -> Command:
        """Torque for one control period.

        Parameters
        ----------
        time : float, s
        q, v : (n,), rad, rad/s
            Measured. Where one is not finite, the last good configuration holds and there is no damping.
        status : str
            Passed on to the command.
        """
        del time
        if np.isfinite(q).all():
            self._last = np.array(q, dtype=float)
        else:
            status, v = f"{status}; configuration not finite", np.zeros_like(self._last)
        speed = v if np.isfinite(v).all() else np.zeros_like(self._last)
        return self._command(self._last, speed, status)

    def torque(self, q: Array, v: Array) -> Array:
        """Torque (n,), N m, before anything is clipped away, at a finite state."""
        floating: Array = self.arm.gravity(q) - self.arm.counterbalance(q) - self.damping * v - self._wall(q, v)
        return floating

    def _wall(self, q: Array, v: Array) -> Array:
        """Torque (n,), N m, of the walls before the soft limits, away from the middle."""
        limits = self.arm.limits
        above = np.maximum(q - (limits.upper - WALL_MARGIN), 0.0)
        below = np.maximum(limits.lower + WALL_MARGIN - q, 0.0)
        stiffness = WALL_SHARE * limits.torque / WALL_MARGIN
        outward = (above > 0.0) * np.maximum(v, 0.0) + (below > 0.0) * np.minimum(v, 0.0)
        wall: Array = stiffness * (above - below) + 4.0 * self.damping * outward
        return wall

    def _command(self, q: Array, v: Array, status: str) -> Command:
        limit = self.arm.limits.torque
        torque = self.torque(q, v)
        pose = self.arm.forward(q)
        still = np.zeros_like(q)
        return Command(
            torque=np.clip(torque, -limit, limit),
            acceleration=still,
            configuration=q,
            velocity=v,
            reference_acceleration=still,
            position=pose.position,
            quaternion=pose.quaternion,
            phase=0.0,
            error=np.zeros(6),
            torque_active=np.abs(torque) >= limit,
            bound_active=np.zeros(len(q), dtype=bool),
            status=status,
            fallback=False,
        )
