r"""A transition that stays near the tube, where the quickest one of ruckig would move away from it first.

Joints that each go their own quickest way do not shrink the tool's error evenly: one with little left of its limits
comes late, the others bend the tool's way in a curve, and in the narrow directions of a tube a centimetre is several
deviations. As in `pft_exec.handoff.moving_frame` the offset e from the moving target is planned, now with the jerks u
of all joints over N even pieces as unknowns, by a sequence of quadratic programs: with z(q) the tool's error in
deviations of the tube,

.. math::
    \min_{u, s \ge 0}\; \tfrac12 s^2 + s + \tfrac{\mu}{2 N} \sum_k \lVert z_k \rVert^2
        + \tfrac{\nu}{2} \sum_k \lVert u_k / j_m \rVert^2
    \quad\text{s.t.}\quad \hat z_k^T z_k \le \lVert z_0 \rVert + s,

with z linear in u about the transition before, its direction :math:`\hat z_k` as it was there, the limits of velocity,
acceleration and jerk of the sum, and an offset that rests at zero at the end. s is the rise above the distance of the
start. Formulation ours; a sequence of quadratic programs as in [Nocedal2006]_, chapter 18.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache

import daqp
import numpy as np

from pft_exec.geometry import Array
from pft_exec.handoff.moving_frame import JointState, Target, keeps_limits
from pft_exec.model import JointLimits

Deviation = Callable[[float, Array], tuple[Array, Array]]
"""From time since now, s, and configuration (n,), rad, to the tool's error from the target's in deviations of the tube
(6,), and its derivative (6, n), 1/rad."""

RISE = 0.05
"""Deviations of the tube by which a transition may rise above its start before another is looked for."""
SHARE, TIGHTER = 0.97, 0.95
"""Of each limit at the ends of the pieces, and by how much less where the sum then uses too much between them."""
SPEED_SHARE = 0.7
"""Of each velocity limit: these transitions are quick, and where the friction of a joint turns round that is not as
modeled, a light neighbour is a tenth of its limit faster than planned."""
_PIECES = 12
_FINER = 4  # looks at the target in each piece
_ROUNDS = 4
_LOOKS = 10
_NEARNESS, _SMOOTHNESS = 0.02, 1e-3  # mu, nu
_EQUALITY = 5  # DAQP's flag of a row that holds with equality
_SOLVED = 1


@dataclass(frozen=True, eq=False)
class PiecewisePlan:
    """A transition as an offset from its target, of constant jerk in even pieces.

    Parameters
    ----------
    duration : float, s
    target : callable
    offset : (N + 1, 3, n)
        Position, velocity and acceleration at the ends of the pieces, rad, rad/s, rad/s^2.
    jerk : (N, n), rad/s^3
    """

    duration: float
    target: Target
    offset: Array
    jerk: Array

    def at(self, time: float) -> JointState:
        """Absolute state at a time, s, since the start."""
        piece = self.duration / len(self.jerk)
        index = min(max(int(time / piece), 0), len(self.jerk) - 1)
        t, u = time - index * piece, self.jerk[index]
        e, v, a = self.offset[index]
        on = self.target(time)
        return on[0] + e + t * (v + t * (0.5 * a + t * u / 6.0)), on[1] + v + t * (a + 0.5 * t * u), on[2] + a + t * u


def rise(at: Callable[[float], JointState], duration: float, deviation: Deviation, looks: int = _LOOKS) -> float:
    """By how many deviations a transition moves away from the tube, at most, beyond where it starts."""
    distances = [float(np.linalg.norm(deviation(t, at(t)[0])[0])) for t in np.linspace(0.0, duration, looks)[:-1]]
    return max(distances) - distances[0]


def plan_near_tube(
    state: JointState, target: Target, limits: JointLimits, deviation: Deviation, durations: Iterable[float]
) -> PiecewisePlan | None:
    """The first transition that rises by no more than `RISE`, or else the one that rises least.

    Parameters
    ----------
    state : JointState
    target : callable
    limits : JointLimits
    deviation : callable
    durations : iterable of float, s
        That are tried, in this order.

    Returns
    -------
    PiecewisePlan or None
        None where none keeps the limits.
    """
    best, least = None, np.inf
    for duration in durations:
        plan = _planned(state, target, limits, deviation, duration)
        if plan is None:
            continue
        risen = rise(plan.at, duration, deviation, 3 * _PIECES)
        if risen < least:
            best, least = plan, risen
        if least <= RISE:
            break
    return best


def _planned(
    state: JointState, target: Target, limits: JointLimits, deviation: Deviation, duration: float
) -> PiecewisePlan | None:
    """A transition that takes a given time, from a sequence of programs that begins on the straight line."""
    times = np.linspace(0.0, duration, _PIECES * _FINER + 1)
    seen = np.array([target(float(time)) for time in times])  # (_FINER N + 1, 3, n)
    times = times[::_FINER]
    if not np.isfinite(seen).all():
        return None
    begin, share = np.array(state) - seen[0], SHARE
    program = _Program(begin, seen, limits, duration, share)
    offset = (1.0 - _smooth(times / duration))[:, None] * begin[0]
    plan, least = None, np.inf
    for _ in range(_ROUNDS):
        looks = [deviation(float(times[k]), seen[_FINER * k, 0] + offset[k]) for k in range(_PIECES)]
        jerk = program.solve(np.array([z for z, _ in looks]), np.array([dz for _, dz in looks]), offset)
        if jerk is None:
            return plan
        states = program.states(jerk)
        offset = states[:, 0]
        found = PiecewisePlan(duration, target, states, jerk)
        if not keeps_limits(found, limits, _PIECES * _FINER + 1):
            share *= TIGHTER
            program = _Program(begin, seen, limits, duration, share)
            continue
        risen = rise(found.at, duration, deviation)
        if risen < least:
            plan, least = found, risen
        if risen <= 0.5 * RISE:
            break
    return plan


def _smooth(x: Array) -> Array:
    """From 0 at x = 0 to 1 at x = 1, at rest at both."""
    step: Array = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    return step


class _Program:
    """The quadratic program of an offset from a state (3, n) to rest, beside a target's states (_FINER N + 1, 3, n)."""

    def __init__(self, begin: Array, target: Array, limits: JointLimits, duration: float, share: float) -> None:
        self._count = begin.shape[1]
        piece = duration / _PIECES
        free, forced = _integrator(_PIECES)
        powers = piece ** np.arange(3.0)
        self._free = np.einsum("kij,jn->kin", free * powers[None, None, :] / powers[None, :, None], begin)
        self._forced = forced * (piece**3 / powers)[None, :, None]  # (N + 1, 3, N)
        self._jerk_limit = limits.jerk
        own = np.diff(target[:, 2], axis=0).reshape(_PIECES, _FINER, -1) * (_FINER / piece)  # jerk
        target = target[::_FINER]
        used = (self._free + target)[1:].swapaxes(0, 1)  # (3, N, n)
        ends = target[[0, -1], 0] + np.stack([begin[0], 0.0 * begin[0]])
        lowest, highest = np.minimum(limits.lower, ends.min(axis=0)), np.maximum(limits.upper, ends.max(axis=0))
        most = np.stack([SPEED_SHARE * limits.velocity, share * limits.acceleration])
        room = np.maximum(most, np.abs(target[1:, 1:]))
        upper = [share * limits.jerk - own.max(axis=1), highest - used[0], *(room.swapaxes(0, 1) - used[1:])]
        lower = [-share * limits.jerk - own.min(axis=1), lowest - used[0], *(-room.swapaxes(0, 1) - used[1:])]
        goal = -self._free[-1]  # (3, n): at rest at zero
        self._lower, self._upper = (np.concatenate([*bounds, goal]).T.ravel() for bounds in (lower, upper))
        own_rows = np.concatenate([np.eye(_PIECES), *self._forced[1:].swapaxes(0, 1), self._forced[-1]])  # (4 N + 3, N)
        self._rows = np.hstack([np.kron(np.eye(self._count), own_rows), np.zeros((len(self._lower), 1))])
        self._sense = np.tile(np.repeat([0, _EQUALITY], [4 * _PIECES, 3]), self._count)

    def states(self, jerk: Array) -> Array:
        """Offsets, velocities and accelerations (N + 1, 3, n) that jerks (N, n) lead to."""
        moved: Array = self._free + np.einsum("kim,mn->kin", self._forced, jerk)
        return moved

    def solve(self, z: Array, dz: Array, offset: Array) -> Array | None:
        """Jerks (N, n) for deviations (N, 6), derivatives (N, 6, n) at offsets (N + 1, n); None where none do."""
        n, unknowns = self._count, self._count * _PIECES
        reach = self._forced[:-1, 0]  # (N, N)
        slopes = np.einsum("kin,km->kinm", dz, reach).reshape(_PIECES, 6, unknowns)  # joint by joint
        constant = z + np.einsum("kin,kn->ki", dz, (self._free[:-1, 0] - offset[:-1]))
        flat = slopes.reshape(-1, unknowns)
        H, c = np.zeros((unknowns + 1, unknowns + 1)), np.zeros(unknowns + 1)
        H[:-1, :-1] = _NEARNESS / _PIECES * flat.T @ flat
        H[range(unknowns), range(unknowns)] += np.repeat(_SMOOTHNESS / self._jerk_limit**2, _PIECES)
        H[-1, -1] = c[-1] = 1.0
        c[:-1] = _NEARNESS / _PIECES * flat.T @ constant.ravel()
        distance = np.linalg.norm(z, axis=1)
        direction = z / np.maximum(distance, 1e-9)[:, None]
        rising = np.hstack([np.einsum("ki,kiu->ku", direction, slopes), -np.ones((_PIECES, 1))])
        highest = distance[0] - np.sum(direction * constant, axis=1)
        G = np.vstack([self._rows, rising, np.eye(unknowns + 1)[-1:]])  # the last: s is not negative
        upper = np.concatenate([self._upper, highest, [np.inf]])
        lower = np.concatenate([self._lower, np.full(_PIECES, -np.inf), [0.0]])
        sense = np.concatenate([self._sense, np.zeros(_PIECES + 1)]).astype(np.intc)
        x, _, flag, _ = daqp.solve(H, c, G, upper, lower, sense)
        if flag != _SOLVED or not np.isfinite(x).all():
            return None
        jerk = np.asarray(x)[:-1].reshape(n, _PIECES).T
        return self._at_rest(jerk)

    def _at_rest(self, jerk: Array) -> Array:
        """The same jerks (N, n) but for what a solver's tolerance leaves of the offset at the end."""
        last = self._forced[-1]
        left = self.states(jerk)[-1]
        settled: Array = jerk - last.T @ np.linalg.solve(last @ last.T, left)
        return settled


@lru_cache
def _integrator(pieces: int) -> tuple[Array, Array]:
    """Of a triple integrator over pieces of unit length: from its first state, and from its jerks, to all states.

    Returns
    -------
    free : (pieces + 1, 3, 3)
    forced : (pieces + 1, 3, pieces)
    """
    step = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
    free, forced = np.zeros((pieces + 1, 3, 3)), np.zeros((pieces + 1, 3, pieces))
    free[0] = np.eye(3)
    for k in range(pieces):
        free[k + 1], forced[k + 1] = step @ free[k], step @ forced[k]
        forced[k + 1, :, k] += [1.0 / 6.0, 0.5, 1.0]
    return free, forced
