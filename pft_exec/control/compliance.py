r"""Compliance from the tube: stiff where the demonstrations agree, soft where they differ.

The tool's error obeys a double integrator, :math:`\ddot e = u`, with e = (position in base axes, rotation vector of
``reference^-1 * tool`` in the tool frame). The gains are those of the finite-horizon linear-quadratic tracker

.. math:: \min \int e^T \Sigma(t)^{-1} e + r\, u^T u \; dt, \qquad u = -K_p(t)\, e - K_d(t)\, \dot e,

whose state weight is the tube's precision, full 6 x 6, computed backwards along the tube once. In the steady state a
standard deviation sigma gives the stiffness :math:`K_p = 1 / (\sigma \sqrt r)` at critical-like damping 0.71. Rotation
counts as the arc on a lever of 1/8 m. The tube's deviations are held between a floor and a ceiling: below the floor
they are noise, above the ceiling the arm would not come back.

The same precision, normalized, weighs the tracking objective: it decides who gives way when limits conflict with
tracking, while the gains make the compliance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.linalg import solve_discrete_are

from pft_exec.exceptions import ControlError
from pft_exec.geometry import Array, read_only
from pft_exec.learning.flow_tube import FlowTube

LEVER = 0.125
"""m; a rotation counts as the arc it makes on this lever."""
FLOOR = (0.003, 0.02)
"""m, rad: smaller deviations of a tube count as this (measured: 2.5 to 3 mm work, below is noise)."""
CEILING = 0.05
"""m; larger deviations count as this. Rotation has the same ratio to its floor."""
STIFFNESS_RANGE = (30.0, 900.0)
"""1/s^2; what arm and friction bear: below, 20 % of friction error is centimetres; above, encoder noise is heard."""
WEIGHT_RATIO = 1.0 / 400.0
"""Smallest weight of a direction in the tracking objective beside the largest."""
UNTAUGHT_ROTATION = 0.1
"""rad; deviation of the orientation along tubes that have none."""
_STEP = 0.005
"""s; step of the backward recursion."""
_LEVERS = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])


@dataclass(frozen=True, eq=False)
class Compliance:
    """Gains and weights of the tool's error along a motion of N steps, evenly in phase.

    The error is (position, base axes, m; rotation vector in the reference tool frame, rad).

    Parameters
    ----------
    time : (N,), s
    gain : (N, 6, 12), 1/s^2 and 1/s
        Acceleration per error, then per error velocity.
    weight : (N, 6, 6), dimensionless on a 1/8 m lever
        Of the tool's acceleration error, linear in base axes, angular in the tool frame.
    deviation : (N, 3, 3), m
        By which the tube leaves room to step aside with the tool as it is turned: the symmetric root of the position's
        covariance at given orientation, base axes. Zero where there is no room.
    """

    time: Array
    gain: Array
    weight: Array
    deviation: Array

    def __post_init__(self) -> None:
        for name in ("time", "gain", "weight", "deviation"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def stiffness(self) -> Array:
        """(N, 6, 6), 1/s^2: acceleration per error."""
        return self.gain[:, :, :6]

    @property
    def damping(self) -> Array:
        """(N, 6, 6), 1/s: acceleration per error velocity."""
        return self.gain[:, :, 6:]

    def at(self, phase: float) -> tuple[Array, Array]:
        """Gain (6, 12) and weight (6, 6) at a phase, held beyond either end."""
        place = min(max(phase, 0.0), 1.0) * (len(self.time) - 1)
        index = min(int(place), len(self.time) - 2)
        ratio = place - index
        gain = self.gain[index] + ratio * (self.gain[index + 1] - self.gain[index])
        return gain, self.weight[index] + ratio * (self.weight[index + 1] - self.weight[index])


def compute_compliance(
    tube: FlowTube,
    softness: float = 0.1,
    *,
    ceiling: float = CEILING,
    stiffness_range: tuple[float, float] = STIFFNESS_RANGE,
) -> Compliance:
    r"""Gains and weights from a tube's covariance.

    Parameters
    ----------
    tube : N steps, any frame; the gains hold in the same
    softness : float, s^4/m^2
        Control weight r: 0.1 is firm, 0.3 soft, 1 very soft; stiffness goes with its inverse square root.
    ceiling : float, m
    stiffness_range : (float, float), 1/s^2

    Returns
    -------
    Compliance

    Raises
    ------
    ControlError
        If a setting is not positive, or the range is empty.

    Notes
    -----
    Derivation ours: a linear-quadratic tracker along the tube, as minimal-intervention controllers do
    [Calinon2014]_. The recursion starts from the algebraic solution at the end of the tube, where the arm stays.
    """
    lowest, highest = _deviation_range(softness, ceiling, stiffness_range)
    covariance = _bounded(_scaled_covariance(tube), lowest, highest)
    precision: Array = np.linalg.inv(covariance).astype(float)
    gain = _tracker_gains(tube.time, precision, softness)
    gain = gain / _LEVERS[:, None] * np.tile(_LEVERS, 2)
    weight = _tracking_weight(precision) * np.outer(_LEVERS, _LEVERS)
    return Compliance(tube.time, gain, weight, _room(precision))


def constant_compliance(stiffness: float, damping_ratio: float = 1.0) -> Compliance:
    """The same stiffness, 1/s^2, in all directions at all times: for joint motions, and to compare a tube's with.

    Raises
    ------
    ControlError
        If the stiffness is not positive.
    """
    if not stiffness > 0.0:
        raise ControlError(f"stiffness must be positive (1/s^2); got {stiffness}.")
    damping = 2.0 * damping_ratio * np.sqrt(stiffness)
    gain = np.hstack([stiffness * np.eye(6), damping * np.eye(6)])
    weight = np.diag(_LEVERS**2)
    return Compliance(np.array([0.0, 1.0]), np.stack([gain, gain]), np.stack([weight, weight]), np.zeros((2, 3, 3)))


def operational_stiffness(inertia: Array, stiffness: Array) -> Array:
    """Stiffness (..., 6, 6), N/m and N m/rad, of a tool with operational-space inertia (..., 6, 6), kg and kg m^2."""
    product: Array = inertia @ stiffness
    return product


def _deviation_range(softness: float, ceiling: float, stiffness_range: tuple[float, float]) -> tuple[float, float]:
    """Deviations, m, that count: the floor and ceiling of the tube and of the stiffness, 1 / (sigma sqrt(r))."""
    low, high = stiffness_range
    if not (softness > 0.0 and ceiling > 0.0 and 0.0 < low < high):
        raise ControlError(
            f"softness (s^4/m^2), ceiling (m) and stiffness range (1/s^2, low to high) must be positive; "
            f"got {softness}, {ceiling}, {stiffness_range}."
        )
    lowest = max(FLOOR[0], 1.0 / (high * np.sqrt(softness)))
    return lowest, max(lowest, min(ceiling, 1.0 / (low * np.sqrt(softness))))


def _scaled_covariance(tube: FlowTube) -> Array:
    """Covariance (N, 6, 6), m^2, with rotation on its lever."""
    covariance = np.zeros((len(tube), 6, 6))
    size = tube.covariance.shape[-1]
    covariance[:, range(3, 6), range(3, 6)] = UNTAUGHT_ROTATION**2
    covariance[:, :size, :size] = tube.covariance
    return covariance * np.outer(_LEVERS, _LEVERS)


def _bounded(covariance: Array, lowest: float, highest: float) -> Array:
    """Covariance (N, 6, 6) whose deviations lie between the floor and the ceiling; axes keep their directions."""
    floors = np.array([lowest] * 3 + [lowest * FLOOR[1] * LEVER / FLOOR[0]] * 3)
    values, vectors = np.linalg.eigh(covariance / np.outer(floors, floors))
    values = np.clip(values, 1.0, (highest / lowest) ** 2)
    bounded: Array = (vectors * values[:, None, :]) @ vectors.transpose(0, 2, 1) * np.outer(floors, floors)
    return bounded


def _tracking_weight(precision: Array) -> Array:
    """Weights (N, 6, 6) with largest eigenvalue 1 and a floor to their ratio."""
    values, vectors = np.linalg.eigh(precision)
    values = np.maximum(values / values[:, -1:], WEIGHT_RATIO)
    weight: Array = (vectors * values[:, None, :]) @ vectors.transpose(0, 2, 1)
    return weight


def _room(precision: Array) -> Array:
    """Deviations (N, 3, 3), m, of the position at given orientation: the inverse root of its part of the precision."""
    values, vectors = np.linalg.eigh(precision[:, :3, :3])
    room: Array = (vectors / np.sqrt(values)[:, None, :]) @ vectors.transpose(0, 2, 1)
    return room


def _tracker_gains(time: Array, precision: Array, softness: float) -> Array:
    """Gains (N, 6, 12) at `time` (N,) of the tracker with state weight (N, 6, 6), backwards on an even grid."""
    count = max(1, int(np.ceil((time[-1] - time[0]) / _STEP)))
    grid = np.linspace(time[0], time[-1], count + 1)
    transition, control = double_integrator(max((grid[-1] - grid[0]) / count, 0.1 * _STEP))
    weights = np.ascontiguousarray(_interpolate(grid, time, precision))
    state_weight = np.zeros((12, 12))
    state_weight[:6, :6] = weights[-1]
    effort = np.diag(np.full(6, softness)).astype(float)
    value = np.ascontiguousarray(solve_discrete_are(transition, control, state_weight, effort))
    return _interpolate(time, grid, _recursion(transition, control, effort, value, weights))


@njit(cache=True)
def _recursion(transition: Array, control: Array, effort: Array, value: Array, weights: Array) -> Array:
    """Gains (N, 6, 12) for position weights (N, 6, 6), backwards from the value matrix (12, 12) after the last."""
    gains = np.empty((len(weights), 6, 12))
    for k in range(len(weights) - 1, -1, -1):
        gains[k], value = riccati_step(transition, control, effort, value)
        value[:6, :6] += weights[k]
    return gains


def double_integrator(step: float) -> tuple[Array, Array]:
    """Transition (12, 12) and control (12, 6) matrices of a 6-D double integrator over one step, s, of held input."""
    transition = np.eye(12)
    transition[:6, 6:] = step * np.eye(6)
    return transition, np.vstack([0.5 * step**2 * np.eye(6), step * np.eye(6)])


@njit(cache=True)
def riccati_step(transition: Array, control: Array, effort: Array, value: Array) -> tuple[Array, Array]:
    """Gain (6, 12) of one backward step, and the value matrix (12, 12) before it, state weight not yet added."""
    projected = np.ascontiguousarray(control.T) @ value
    gain: Array = np.linalg.solve(effort + projected @ control, projected @ transition).astype(np.float64)
    before = np.ascontiguousarray(transition.T) @ value @ (transition - control @ gain)
    return gain, 0.5 * (before + before.T)


def _interpolate(at: Array, time: Array, values: Array) -> Array:
    """Values (N, ...) at `time` (N,), linearly at times `at` (M,) within them."""
    index = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
    width = time[index + 1] - time[index]
    ratio = np.where(width > 0.0, (at - time[index]) / np.where(width > 0.0, width, 1.0), 0.0)[:, None, None]
    between: Array = (1.0 - ratio) * values[index] + ratio * values[index + 1]
    return between
