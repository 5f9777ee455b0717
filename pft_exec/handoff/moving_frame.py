r"""The moving frame: a transition planned as the way that is left to a target that moves on.

With the target :math:`x_t`, the offset :math:`e = x - x_t` of the joints is brought to rest at zero by one jerk-limited
ruckig trajectory, within what the target leaves of the limits. The joints then approach the target on nearly the
straight line, whatever it does meanwhile: an offset that shrinks does not grow in any direction, while a plan between
two absolute states may go round. One plan suffices where the absolute one has to search for its time of arrival.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import ruckig

from pft_exec.geometry import Array
from pft_exec.model import JointLimits

JointState = tuple[Array, Array, Array]
"""Configuration, velocity and acceleration, each (n,): rad, rad/s, rad/s^2."""
Target = Callable[[float], JointState]

LEAST_SHARE = 0.3
"""Of each limit, what the offset may have at least; where the sum is then beyond the limit, the plan is not taken."""
MARGINS = (0.96, 0.8)
"""Shares of each limit that are planned with: between the instants that are looked at, the target may use more."""
_HORIZON = 0.6  # s over which the target is looked at before the duration is known
_SAMPLES = 16
_LOOKS = 3
_ROUNDING = 1.0 + 1e-6


class Plan(Protocol):
    """A transition: how long it takes, s, and where the joints then are."""

    @property
    def duration(self) -> float: ...

    def at(self, time: float) -> JointState: ...


@dataclass(frozen=True, eq=False)
class OffsetPlan:
    """A transition as an offset from its target.

    Parameters
    ----------
    duration : float, s
    target : callable
    offset : ruckig.Trajectory
    """

    duration: float
    target: Target
    offset: ruckig.Trajectory

    def at(self, time: float) -> JointState:
        """Absolute state at a time, s, since the start."""
        e, v, a = (np.array(part) for part in self.offset.at_time(time))
        on = self.target(time)
        return on[0] + e, on[1] + v, on[2] + a


def plan_offset(state: JointState, target: Target, limits: JointLimits, longest: float) -> OffsetPlan | None:
    """Plan in the target's frame; None where the limits, the target or ruckig do not allow it.

    Parameters
    ----------
    state : JointState
        Finite.
    target : callable
        From time since now, s, to the target's state then.
    limits : JointLimits
    longest : float, s
    """
    for margin in MARGINS:
        plan = _planned(state, target, limits, longest, margin)
        if plan is not None and keeps_limits(plan, limits):
            return plan
    return None


def _planned(
    state: JointState, target: Target, limits: JointLimits, longest: float, margin: float
) -> OffsetPlan | None:
    """A plan within a share of the limits, the target looked at for as long as it takes."""
    horizon = _HORIZON
    for _ in range(_LOOKS):
        seen = _sampled(target, horizon)
        if not all(np.isfinite(part).all() for part in seen):
            return None
        offset = _calculate(state, seen, limits, horizon, margin)
        if offset is None or offset.duration > longest:
            return None
        if offset.duration <= horizon:
            return OffsetPlan(float(offset.duration), target, offset)
        horizon = 1.05 * float(offset.duration)
    return None


def _sampled(state_at: Target, horizon: float, count: int = _SAMPLES) -> JointState:
    """States (S, n) at even times from now to a horizon, s."""
    states = [state_at(float(time)) for time in np.linspace(0.0, horizon, count)]
    return np.array([s[0] for s in states]), np.array([s[1] for s in states]), np.array([s[2] for s in states])


def _calculate(
    state: JointState, seen: JointState, limits: JointLimits, horizon: float, margin: float
) -> ruckig.Trajectory | None:
    """The offset's quickest way to rest at zero within what the target leaves of the limits."""
    count = len(state[0])
    jerk = np.abs(np.diff(seen[2], axis=0)).max(axis=0) / (horizon / (_SAMPLES - 1))
    problem = ruckig.InputParameter(count)
    problem.current_position = list(state[0] - seen[0][0])
    problem.current_velocity = list(state[1] - seen[1][0])
    problem.current_acceleration = list(state[2] - seen[2][0])
    problem.target_position = [0.0] * count
    problem.max_velocity = list(_left(limits.velocity, np.abs(seen[1]).max(axis=0), margin))
    problem.max_acceleration = list(_left(limits.acceleration, np.abs(seen[2]).max(axis=0), margin))
    problem.max_jerk = list(_left(limits.jerk, jerk, margin))
    trajectory = ruckig.Trajectory(count)
    try:
        result = ruckig.Ruckig(count).calculate(problem, trajectory)
    except ruckig.RuckigError:
        return None
    return trajectory if result in (ruckig.Result.Working, ruckig.Result.Finished) else None


def _left(limit: Array, used: Array, margin: float) -> Array:
    """What is left of a limit (n,) beside what the target uses."""
    left: Array = np.maximum(margin * limit - used, LEAST_SHARE * limit)
    return left


def keeps_limits(plan: Plan, limits: JointLimits, looks: int = _SAMPLES) -> bool:
    """Whether positions, velocities, accelerations and jerks of the sum keep their limits, where they are looked at."""
    if plan.duration <= 0.0:
        return True
    step = plan.duration / (looks - 1)
    q, v, a = _sampled(plan.at, plan.duration, looks)
    lower, upper = np.minimum(limits.lower, q[[0, -1]].min(axis=0)), np.maximum(limits.upper, q[[0, -1]].max(axis=0))
    moved = np.abs(np.diff(q, axis=0)) / step
    jerk = np.abs(np.diff(a, axis=0)) / step
    return bool(
        (q >= lower).all()
        and (q <= upper).all()
        and (np.maximum(np.abs(v[1:]), moved) <= _ROUNDING * np.maximum(limits.velocity, np.abs(v[0]))).all()
        and (np.abs(a) <= _ROUNDING * limits.acceleration).all()
        and (jerk <= _ROUNDING * limits.jerk).all()
    )
