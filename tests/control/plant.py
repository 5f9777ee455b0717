"""A plant for tests: an arm's dynamics with dry friction, integrated without a simulator."""

from __future__ import annotations

import numpy as np
from numba import njit

from pft_exec.learning.flow_tube import FlowTube


class Plant:
    """An arm at a state (q, v); `friction` scales the model's joint friction, `payload` is a mass (kg) at the tool."""

    def __init__(self, arm, q, v=None, *, friction=1.0, payload=0.0, step=0.001):
        self.arm = arm.with_payload(payload) if payload else arm
        self.q = np.array(q, dtype=float)
        self.v = np.zeros_like(self.q) if v is None else np.array(v, dtype=float)
        self.coulomb, self.viscous = friction * arm.friction.coulomb, friction * arm.friction.viscous
        self.step_time = step

    def step(self, torque, force=(0.0, 0.0, 0.0)):
        """One step under a motor torque (n,), N m, and a force (3,), N, at the tool in the base frame."""
        dynamics = self.arm.dynamics(self.q, self.v)
        applied = torque + self.arm.counterbalance(self.q) - dynamics.bias + dynamics.jacobian[:3].T @ np.asarray(force)
        inverse = np.linalg.inv(dynamics.mass_matrix + self.step_time * np.diag(self.viscous))
        free = self.v + self.step_time * inverse @ (applied - self.viscous * self.v)
        self.v = after_dry_friction(free, inverse, self.coulomb, self.step_time)
        self.q = self.q + self.step_time * self.v


@njit(cache=True)
def after_dry_friction(v, inverse, coulomb, step):
    """Velocity after each joint's friction torque, at most its Coulomb value, has worked against it for a step."""
    dry = np.zeros_like(v)
    for _ in range(20):
        for i in range(len(v)):
            wanted = dry[i] - v[i] / (step * inverse[i, i])
            change = min(max(wanted, -coulomb[i]), coulomb[i]) - dry[i]
            dry[i] += change
            v = v + step * inverse[:, i] * change
    return v


def arch(arm, q, duration=5.0, steps=100):
    """A tube of 18 cm with an arch of 10 cm from the tool's pose at q; its y deviation is 2.5, 50, 2.5 mm."""
    s = np.linspace(0.0, 1.0, steps)
    m = 10 * s**3 - 15 * s**4 + 6 * s**5
    start = arm.forward(q)
    position = start.position + np.stack([0.0 * s, 0.18 * m, 0.10 * np.sin(np.pi * m)], axis=1)
    deviation = np.full((steps, 6), 0.005)
    deviation[:, 1] = 0.0025 + 0.0475 * np.exp(-(((s - 0.5) / 0.15) ** 2))
    deviation[:, 3:] = 0.03
    covariance = deviation[:, :, None] ** 2 * np.eye(6)
    return FlowTube("arch", s * duration, position, np.tile(start.quaternion, (steps, 1)), covariance)
