"""Verdicts on the tool's course: shaken, stirred, wound, led round anchors; by the path that was measured."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pft_exec.description.measured import Verdict
from pft_exec.description.motion import WORLD
from pft_exec.description.predicates import Anchored, Shaken, Stirred, Wound
from pft_exec.geometry import Array, Pose

_SAMPLES = 1000  # evenly along the arc, for what must not depend on the pace
_TURN_SLACK = 0.25  # of a turn, by which the course may fall short of the turns that were taught
_BACKWARD = 0.1  # of a turn that the course may go back in all


def judge_shaken(limits: Shaken, path: Array) -> Verdict:
    """Whether the tool (T, 3) went to and fro as often and as far as taught."""
    along = path @ (np.array(limits.direction) / np.linalg.norm(limits.direction))
    least = limits.share * limits.amplitude
    extremes = reversals(along, least)
    swings = np.abs(np.diff(extremes))
    shortest = float(swings.min()) if len(swings) else 0.0
    reason = (
        f"{len(extremes)} reversals ({limits.reversals} taught), the shortest swing {1e3 * shortest:.0f} mm "
        f"(at least {2e3 * least:.0f})"
    )
    return Verdict(len(extremes) == limits.reversals and shortest >= 2.0 * least, reason)


def judge_stirred(limits: Stirred, before: Mapping[str, Pose], path: Array) -> Verdict:
    """Whether the tool (T, 3) went round in one sense, on the radius and about the place it should."""
    even = along_arc(path)[:, :2]
    center = even.mean(axis=0)
    for _ in range(5):  # what leads to the circle and away from it weighs less each time
        distance = np.linalg.norm(even - center, axis=1)
        near = np.abs(distance - np.median(distance)) <= 0.25 * np.median(distance)
        center = 0.5 * (even[near].max(axis=0) + even[near].min(axis=0))
    radius = float(np.median(np.linalg.norm(even - center, axis=1)))
    turns, backward = winding(even, center)
    wanted = _origin(limits.frame, before)[:2] + np.array(limits.center[:2])
    aside = float(np.linalg.norm(center - wanted))
    reason = (
        f"{turns:.2f} turns ({limits.turns:g} taught, {backward:.2f} backwards), radius {1e3 * radius:.1f} mm "
        f"({1e3 * limits.radius:.0f} taught), centre {1e3 * aside:.1f} mm aside (at most "
        f"{1e3 * limits.center_tolerance:.0f})"
    )
    round_enough = np.sign(turns) == np.sign(limits.turns) and abs(turns) >= abs(limits.turns) - _TURN_SLACK
    on_radius = abs(radius - limits.radius) <= limits.radius_tolerance * limits.radius
    done = round_enough and backward <= _BACKWARD and on_radius and aside <= limits.center_tolerance
    return Verdict(bool(done), reason)


def judge_wound(limits: Wound, before: Mapping[str, Pose], path: Array) -> Verdict:
    """Whether the tool (T, 3) wound so often about a vertical."""
    post = _origin(limits.frame, before)[:2]
    turns, _ = winding(path[:, :2], post)
    distance = np.linalg.norm(path[:, :2] - post, axis=1)
    least, greatest = (float(x) for x in (distance.min(), distance.max())) if len(path) else (0.0, 0.0)
    reason = (
        f"wound {turns:.2f} times ({limits.turns:g} taught) at {1e3 * least:.0f} to {1e3 * greatest:.0f} mm "
        f"({1e3 * limits.radius[0]:.0f} to {1e3 * limits.radius[1]:.0f})"
    )
    within = limits.radius[0] <= least and greatest <= limits.radius[1]
    return Verdict(abs(turns - limits.turns) <= limits.tolerance and within, reason)


def judge_anchored(limits: Anchored, before: Mapping[str, Pose], path: Array) -> Verdict:
    """Whether the tool (T, 3) passed the anchors in order, each on its side."""
    origin, since = _origin(limits.frame, before), 0
    for number, anchor in enumerate(limits.anchors, start=1):
        place = origin + np.array(anchor.offset)
        crossings = np.flatnonzero(np.diff(np.sign(path[since:, 1] - place[1])) != 0) + since
        sides = anchor.side * (path[crossings, 0] - place[0])
        passed = np.flatnonzero(sides >= limits.margin)
        if not len(passed) or (sides[: passed[0]] < 0.0).any():
            return Verdict(False, f"anchor {number} was not passed on its side")
        since = int(crossings[passed[0]]) + 1
    return Verdict(True, f"{len(limits.anchors)} anchors passed, each on its side")


def reversals(along: Array, least: float) -> Array:
    """Extremes (R,) at which a course (T,) turns back by at least `least`, in order; ends are none."""
    extremes: list[float] = []
    if len(along) == 0:
        return np.array(extremes)
    low = high = turning = float(along[0])
    heading = 0
    for value in along.tolist():
        if heading == 0:
            low, high = min(low, value), max(high, value)
            heading = 1 if value - low >= least else -1 if high - value >= least else 0
            turning = value
        elif heading * (value - turning) >= 0.0:
            turning = value
        elif heading * (turning - value) >= least:
            extremes.append(turning)
            heading, turning = -heading, value
    return np.array(extremes)


def winding(path: Array, center: Array) -> tuple[float, float]:
    """Turns of a level path (T, 2) about a center (2,), + counterclockwise, and turns that go against that in all."""
    if len(path) < 2:
        return 0.0, 0.0
    angle = np.unwrap(np.arctan2(path[:, 1] - center[1], path[:, 0] - center[0])) / (2.0 * np.pi)
    turns = float(angle[-1] - angle[0])
    steps = np.diff(angle) * (1.0 if turns >= 0.0 else -1.0)
    return turns, float(-steps[steps < 0.0].sum())


def along_arc(path: Array) -> Array:
    """The path (T, 3) at `_SAMPLES` places evenly along its length."""
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
    if len(path) < 2 or length[-1] <= 0.0:
        return np.zeros((_SAMPLES, 3)) if len(path) == 0 else np.repeat(path[:1], _SAMPLES, axis=0)
    places = np.linspace(0.0, length[-1], _SAMPLES)
    return np.stack([np.interp(places, length, path[:, axis]) for axis in range(3)], axis=1)


def _origin(frame: str, before: Mapping[str, Pose]) -> Array:
    return np.zeros(3) if frame == WORLD else before[frame].position
