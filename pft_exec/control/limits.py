r"""Limits of the quadratic program: torque as hard rows, the rest as bounds on the joint accelerations.

**Torque.** The plant is :math:`M \ddot q + b = \tau + \tau_{cb} - f`. With everything but the motor gathered in
:math:`h = b - \tau_{cb} + f`, where f is the friction that the feed-forward cancels, the rows are
:math:`-\tau_{max} - h \le M \ddot q \le \tau_{max} - h`. M is invertible, so these rows alone always have a solution,
whatever the state: :math:`\ddot q = M^{-1} (\tau - h)` for any torque in the box.

**Position, velocity, acceleration.** For each joint let V be the states from which it can still stop in time,

.. math:: V = \{ |v| \le v_m,\; q + v_+^2 / 2 b \le q_u,\; q - v_-^2 / 2 b \ge q_l \},

with braking deceleration b <= a_m, the acceleration limit, a speed v_m within the velocity limit (`BRAKING_SHARE` and
`SPEED_SHARE` of them), and v+, v- the parts of v towards either end.
References keep a_m themselves; the program may go beyond it, by `AUTHORITY`, to answer what was not foreseen.
`acceleration_bounds` gives the interval of accelerations that, held for one control period h, lead from V into V.

*It is never empty in V*, if the joint's range is at least 4 b h^2 and b h <= v_m. Take v >= 0 (else mirror). Consider
a = -b. (i) Upper end: constant braking keeps q + v^2 / 2b until the joint stops and then moves away from the end, so
the upper bound is at least -b. (ii) Speed: -b h <= v - b h <= v, so |v - b h| <= v_m. (iii) Lower end: if v >= b h the
joint still moves up, which only adds room. Else it ends at q' = q + v h - b h^2 / 2 with speed v' = v - b h < 0, and
needs q' - v'^2 / 2b = q + 2 v h - v^2 / 2b - b h^2 >= q_l; as v < b h, the left side is at least q - b h^2. So a = -b
is allowed unless q < q_l + b h^2; but there the upper end is at least 3 b h^2 away, where a = 0 is allowed: it moves
the joint by less than b h^2, towards the middle, at unchanged speed. (The speed bounds contain zero.) The upper bound
is the largest allowed acceleration as far as the upper end goes, the lower bound the smallest as far as the lower end
goes, and all between them are allowed too.

*Outside V* (a hand pushed the joint there, or a sensor is noisy) each bound asks for the recovery that is needed, as
far as that authority goes, and where both ends ask for the impossible, the lower bound gives way to the upper one.
The interval is never empty. Torque may forbid braking at that rate, so in the program these bounds are soft.

The braking-distance bounds follow [DelPrete2018]_; the proof and the treatment outside V are ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from pft_exec.geometry import Array
from pft_exec.model import JointLimits

BRAKING_SHARE = 0.8
"""Share of the acceleration limit that braking counts on; the rest is room for the tracking error."""
SPEED_SHARE = 0.98
"""Share of the velocity limit that the bounds allow; the rest is room for noise and torque that no model knows, which
carried a joint 0.3 % beyond a bound that stood at the limit itself (with all mismatches at once)."""
AUTHORITY = 10.0
"""Multiple of the acceleration limit that the feedback may use. A quarter of a newton metre of unforeseen friction
accelerates a wrist by the whole limit: with 1, the tool strays by centimetres and the arm stiffens under a push."""
RETURN_TIME = 0.05
"""s; a joint beyond its limit returns with this time constant: 0.01 rad are down to 0.2 mrad in 0.2 s."""
_TINY = 1e-12


@dataclass(frozen=True, eq=False)
class Constraint:
    """Rows ``lower <= G x <= upper`` on the joint accelerations; soft rows give way where no solution exists.

    Parameters
    ----------
    G : (m, n)
    lower, upper : (m,)
        lower <= upper.
    soft : bool
    """

    G: Array
    lower: Array
    upper: Array
    soft: bool = False


def torque_constraint(mass_matrix: Array, load: Array, torque: Array) -> Constraint:
    """Hard rows that keep the motor torque ``M qdd + load`` within +-`torque`, N m.

    Parameters
    ----------
    mass_matrix : (n, n), kg m^2
    load : (n,), N m
        Everything that the motor must hold besides inertia: bias, less counterbalance, plus friction feed-forward.
    torque : (n,), N m
    """
    return Constraint(mass_matrix, -torque - load, torque - load)


def acceleration_bounds(limits: JointLimits, period: float, q: Array, v: Array) -> tuple[Array, Array]:
    """Bounds (n,), (n,), rad/s^2, on accelerations that keep position, velocity and acceleration limits from here on.

    Parameters
    ----------
    limits : JointLimits
    period : float, s
        For which the acceleration is held.
    q, v : (n,), rad, rad/s
    """
    bounds = _acceleration_bounds(limits.lower, limits.upper, limits.velocity, limits.acceleration, period, q, v)
    return bounds[0], bounds[1]


@njit(cache=True)
def _acceleration_bounds(
    q_lower: Array, q_upper: Array, speed: Array, acceleration: Array, period: float, q: Array, v: Array
) -> Array:
    bounds = np.empty((2, q.size))
    for i in range(q.size):
        upper = largest_acceleration(q_upper[i] - q[i], v[i], speed[i], acceleration[i], period)
        lower = -largest_acceleration(q[i] - q_lower[i], -v[i], speed[i], acceleration[i], period)
        bounds[0, i] = min(lower, upper)
        bounds[1, i] = upper
    return bounds


@njit(cache=True)
def largest_acceleration(room: float, v: float, speed: float, acceleration: float, period: float) -> float:
    """Largest acceleration, rad/s^2, towards an end that is `room`, rad, away and approached at `v`, rad/s.

    With w the speed after the period h, the end is then room - (v + w) h / 2 away, and braking needs w^2 / 2b. Where
    the joint turns back within the period, its turning point v^2 / 2|a| must lie before the end.
    """
    brake = BRAKING_SHARE * acceleration
    half = 0.5 * brake * period
    if room < 0.0:
        bound = (room / RETURN_TIME - v) / period
    elif room >= 0.5 * period * v:
        bound = (math.sqrt(half**2 + brake * (2.0 * room - period * v)) - half - v) / period
    else:
        bound = -(v**2) / max(2.0 * room, _TINY)
    bound = min(bound, (SPEED_SHARE * speed - v) / period)
    return max(-AUTHORITY * acceleration, min(bound, AUTHORITY * acceleration))
