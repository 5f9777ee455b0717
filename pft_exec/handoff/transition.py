r"""The transition: a jerk-limited joint motion that meets a moving target where it will be, planned once.

From the measured configuration and velocity and the last commanded acceleration, ruckig plans to the state that the
target has on arrival, velocity and acceleration included. It is planned in the target's own frame
(`pft_exec.handoff.moving_frame`); where the target leaves too little of the limits for that, between two absolute
states: the time of arrival T is the shortest that suffices, tried every 50 ms, then halved down to below a millisecond,
and then asked for exactly. Where that is slow, or would move the tool away from its tube first, another is looked for
(`pft_exec.handoff.near_tube`). A plan is never chased from period to period: that lags behind by 18 mrad and jerks all
the time (measured).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import ruckig

from pft_exec.geometry import read_only
from pft_exec.handoff.moving_frame import JointState, plan_offset
from pft_exec.handoff.near_tube import RISE, Deviation, plan_near_tube, rise
from pft_exec.model import JointLimits

SEARCH_STEP = 0.05
"""s between the arrival times that are tried first."""
LATER = 0.01
"""s by which the arrival is put off where no trajectory takes exactly that long."""
LONGEST = 3.0
"""s; a target that cannot be met within this time counts as out of reach."""
TARGET_SHARE = 0.99
"""Share of velocity and acceleration limits that the target may have; ruckig refuses more."""
SLOW = 0.6
"""s; a transition that takes longer may be ruckig's doing, which gives the offset what the target leaves throughout."""
STRETCHES = (0.6, 0.75, 0.9, 1.0, 1.2, 1.5)
"""Durations that are then tried, beside ruckig's."""
DURATIONS = (0.4, 0.55, 0.7, 0.9, 1.2)
"""s; where ruckig has none."""
_HALVINGS = 6
_TOLERANCE = 1e-6  # s and rad


@dataclass(frozen=True, eq=False)
class Transition:
    """A planned transition, or the reason why there is none.

    Parameters
    ----------
    found : bool
        Whether the target is met within the limits; otherwise `at` stays at the start.
    duration : float, s
        Until the target is met; from then on, follow the target.
    reason : str
        Why there is none; empty where one was found.
    start, end : JointState
    """

    found: bool
    duration: float
    reason: str
    start: JointState
    end: JointState
    _path: Callable[[float], JointState] | None = None

    def at(self, time: float) -> JointState:
        """State at a time, s, since the start; before and after, that of the nearer end."""
        if self._path is None or time <= 0.0:
            return self.start
        return self.end if time >= self.duration else self._path(time)


def plan_transition(
    state: JointState,
    target: Callable[[float], JointState],
    limits: JointLimits,
    *,
    longest: float = LONGEST,
    deviation: Deviation | None = None,
) -> Transition:
    """Plan a transition from a state onto a moving target.

    Parameters
    ----------
    state : JointState
        Configuration and velocity as measured, acceleration as last commanded.
    target : callable
        From time since now, s, to the target's state then.
    limits : JointLimits
    longest : float, s
    deviation : callable, optional
        From time since now, s, and configuration (n,), rad, to the tool's error from the target's in deviations of the
        tube (6,), and its derivative (6, n). Where ruckig's transition rises by more than `near_tube.RISE` above the
        start's distance, takes longer than `SLOW` or does not exist, another is looked for: 3 to 10 ms of computing.

    Returns
    -------
    Transition
        With ``found`` False where the target cannot be met within `longest` and within the limits; nothing is raised.
    """
    state = _copied(state)
    quickest = _quickest(state, target, limits, longest)
    if deviation is None or not _are_finite(state, target(0.0)):
        return quickest
    risen = rise(quickest.at, quickest.duration, deviation) if quickest.found else np.inf
    if risen <= RISE and quickest.duration <= SLOW:
        return quickest
    durations = [stretch * quickest.duration for stretch in STRETCHES] if quickest.found else list(DURATIONS)
    enough = quickest.duration if risen <= RISE else longest
    near = plan_near_tube(state, target, limits, deviation, [time for time in durations if time < enough])
    if near is None or rise(near.at, near.duration, deviation) > max(risen, RISE):
        return quickest
    return Transition(True, near.duration, "", state, _copied(target(near.duration)), near.at)


def _quickest(
    state: JointState, target: Callable[[float], JointState], limits: JointLimits, longest: float
) -> Transition:
    """The transition that takes least time."""
    planner = _Planner(state, target, limits)
    if not _are_finite(state):
        return _failed(state, "the state is not finite")
    offset = plan_offset(state, target, limits, longest)
    if offset is not None:
        end = target(offset.duration)
        return Transition(True, offset.duration, "", state, _copied(end), offset.at)
    arrival = planner.earliest_arrival(longest)
    if arrival is None:
        return _failed(state, f"the target cannot be met within {longest:g} s: {planner.trouble}")
    return planner.plan(arrival, longest)


class _Planner:
    """One ruckig planner for one transition."""

    def __init__(self, state: JointState, target: Callable[[float], JointState], limits: JointLimits) -> None:
        self.state, self.target, self.limits = state, target, limits
        self.trouble = "every plan takes longer than the target"
        self._ruckig = ruckig.Ruckig(len(state[0]))
        self._input = ruckig.InputParameter(len(state[0]))
        self._input.current_position, self._input.current_velocity = list(state[0]), list(state[1])
        self._input.current_acceleration = list(np.clip(state[2], -limits.acceleration, limits.acceleration))
        self._input.max_velocity, self._input.max_acceleration = list(limits.velocity), list(limits.acceleration)
        self._input.max_jerk = list(limits.jerk)

    def meeting(self, arrival: float) -> JointState:
        """The target's state on arrival, within what ruckig accepts."""
        q, v, a = self.target(arrival)
        fastest, hardest = TARGET_SHARE * self.limits.velocity, TARGET_SHARE * self.limits.acceleration
        return q, np.clip(v, -fastest, fastest), np.clip(a, -hardest, hardest)

    def calculate(self, arrival: float, exactly: bool) -> ruckig.Trajectory | None:
        """The quickest trajectory to where the target is on arrival, or the one that takes exactly that long."""
        meeting = self.meeting(arrival)
        if not _are_finite(meeting):
            self.trouble = "the target is not finite"
            return None
        self._input.target_position, self._input.target_velocity = list(meeting[0]), list(meeting[1])
        self._input.target_acceleration = list(meeting[2])
        self._input.minimum_duration = arrival if exactly else None
        trajectory = ruckig.Trajectory(len(self.state[0]))
        try:
            result = self._ruckig.calculate(self._input, trajectory)
        except ruckig.RuckigError as error:
            self.trouble = f"ruckig: {error}"
            return None
        return trajectory if result in (ruckig.Result.Working, ruckig.Result.Finished) else None

    def suffices(self, arrival: float) -> bool:
        trajectory = self.calculate(arrival, exactly=False)
        return trajectory is not None and trajectory.duration <= arrival

    def earliest_arrival(self, longest: float) -> float | None:
        """Earliest time, s, at which the target can be met, to 1 ms; None where that is later than `longest`."""
        steps = (SEARCH_STEP * k for k in range(1, int(longest / SEARCH_STEP) + 1))
        late = next((arrival for arrival in steps if self.suffices(arrival)), None)
        if late is None:
            return None
        early = late - SEARCH_STEP
        for _ in range(_HALVINGS):
            middle = 0.5 * (early + late)
            early, late = (early, middle) if self.suffices(middle) else (middle, late)
        return late

    def plan(self, arrival: float, longest: float) -> Transition:
        """The trajectory that takes exactly as long as the target needs to be there, at `arrival` or later if need be.

        Some durations cannot be had although shorter ones can: a joint must stop and come back to spend the time.
        """
        while arrival <= longest:
            trajectory = self.calculate(arrival, exactly=True)
            if trajectory is None:
                return _failed(self.state, self.trouble)
            if abs(trajectory.duration - arrival) <= _TOLERANCE:
                beyond = self.beyond_limits(trajectory)
                if beyond > _TOLERANCE:
                    return _failed(self.state, f"it would pass a joint limit by {beyond:.3g} rad")
                return Transition(True, arrival, "", self.state, self.meeting(arrival), _path_of(trajectory))
            arrival += LATER
        return _failed(self.state, f"the target cannot be met at the time that a transition takes, up to {longest:g} s")

    def beyond_limits(self, trajectory: ruckig.Trajectory) -> float:
        """How far, rad, it leaves the position limits, more than its start and end do."""
        ends = np.array([self.state[0], self.target(trajectory.duration)[0]])
        lowest, highest = (
            np.minimum(self.limits.lower, ends.min(axis=0)),
            np.maximum(self.limits.upper, ends.max(axis=0)),
        )
        extrema = trajectory.position_extrema
        reached = np.array([[joint.min, joint.max] for joint in extrema])
        return float(max(np.max(lowest - reached[:, 0]), np.max(reached[:, 1] - highest)))


def _path_of(trajectory: ruckig.Trajectory) -> Callable[[float], JointState]:
    """A ruckig trajectory from time, s, to state."""

    def at(time: float) -> JointState:
        q, v, a = trajectory.at_time(time)
        return np.array(q), np.array(v), np.array(a)

    return at


def _are_finite(*states: JointState) -> bool:
    return all(bool(np.isfinite(part).all()) for state in states for part in state)


def _copied(state: JointState) -> JointState:
    return read_only(state[0]), read_only(state[1]), read_only(state[2])


def _failed(state: JointState, reason: str) -> Transition:
    return Transition(False, 0.0, reason, state, state)
