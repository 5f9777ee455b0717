"""The hand of the planar world once more, compiled: from what is of chance in a trial straight to its positions.

The oracle asks for a million hands. Their law is that of `planar.perform`, to rounding: a test draws trials and finds
them here again. What is of chance in a trial stands in one vector:

==================  ====================================================================================
0                   pace, cut off at 1.5 standard deviations
1, 2                bow and S of a motion that is one straight leg
3, 4                where a pause is, and how long it lasts, each even in [0, 1]
5, 6, ...           the waypoints, in the order in which they are drawn: see `lay_waypoints`
==================  ====================================================================================

All but 3 and 4 are standard normal.
"""

from __future__ import annotations

import numpy as np
from numba import njit

GOAL, LEFT, LOOP, ANCHOR = range(4)
SHARED = 5  # numbers before those of the waypoints
OWN = (2, 3, 12, 32)  # how many numbers the waypoints of each kind take
_CORNERS = 9  # of a loop
_MOST = 3 + 2 * _CORNERS  # waypoints: those of an anchor


@njit(cache=True, error_model="numpy")
def _add_loop(entry, center, turn, loop, z, points):  # type: ignore[no-untyped-def]
    """Corners (9, 2) of an uneven turn about `center`; `planar._loop`."""
    arm = entry - center
    radius = np.sqrt(arm[0] ** 2 + arm[1] ** 2)
    begin, size = np.arctan2(arm[1], arm[0]), np.exp(loop * z[2]) * radius
    for k in range(_CORNERS):
        angle = begin + turn * 2.0 * np.pi * k / (_CORNERS - 1)
        corner = size * np.exp(0.5 * loop * z[3 + k])
        points[k, 0] = center[0] + loop * 0.5 * radius * z[0] + corner * np.cos(angle)
        points[k, 1] = center[1] + loop * 0.5 * radius * z[1] + corner * np.sin(angle)
    points[0] = entry


@njit(cache=True, error_model="numpy")
def lay_waypoints(kind, start, places, scatter, z, points):  # type: ignore[no-untyped-def]
    """Write the waypoints of one trial to `points`; returns how many there are.

    `places` (2, 2) holds the goal, or in its first entry the turn of a loop, or the two places of an anchor;
    `scatter` is goal, reach, loop and bow of `planar.Scatter`.
    """
    goal, reach, loop, bow = scatter[0], scatter[1], scatter[2], scatter[3]
    points[0] = start
    if kind == GOAL:
        points[1] = places[0] + goal * z[:2]
        return 2
    if kind == LEFT:
        points[1] = start + 0.3 * goal * z[:2]
        points[1, 0] -= np.exp(reach * z[2])
        return 2
    if kind == LOOP:
        _add_loop(start, start + np.array([0.0, -1.5]), places[0, 0], loop, z, points)
        return _CORNERS
    first, second = places[0] + 0.5 * goal * z[:2], places[1] + 0.5 * goal * z[2:4]
    came_from, count = start, 1
    for k in range(2):
        place = first if k == 0 else second
        own = z[4 + 14 * k : 18 + 14 * k]
        arm = came_from - place
        entry = place + 0.6 * np.exp(loop * own[0]) * arm / np.sqrt(arm[0] ** 2 + arm[1] ** 2)
        leg = entry - points[count - 1]
        points[count, 0] = entry[0] - 0.5 * leg[0] - bow * own[1] * leg[1]
        points[count, 1] = entry[1] - 0.5 * leg[1] + bow * own[1] * leg[0]
        _add_loop(entry, place, 1.0, 0.5 * loop, own[2:], points[count + 1 : count + 1 + _CORNERS])
        came_from, count = first, count + 1 + _CORNERS
    return count


@njit(cache=True, error_model="numpy")
def _minimum_jerk(u):  # type: ignore[no-untyped-def]
    u = min(max(u, 0.0), 1.0)
    return u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)


@njit(cache=True, error_model="numpy")
def _time_moves(points, count, overlap, pace, onsets, spans):  # type: ignore[no-untyped-def]
    """Write when each submovement begins and how long it lasts, s; returns the duration."""
    moves, clock = count - 1, 0.0
    for k in range(moves):
        length = np.sqrt((points[k + 1, 0] - points[k, 0]) ** 2 + (points[k + 1, 1] - points[k, 1]) ** 2)
        spans[k] = pace * (0.4 / moves + 0.25 * length)
    early = 0.0
    for k in range(moves):
        duration = spans[k]
        late = overlap * min(duration, spans[k + 1]) if k + 1 < moves else 0.0
        onsets[k], spans[k] = clock - 0.5 * early, duration + 0.5 * (early + late)
        clock += duration
        early = late
    return clock


@njit(cache=True, error_model="numpy")
def _own_clock(time, pause_at, cost):  # type: ignore[no-untyped-def]
    if cost == 0.0:
        return time
    inside = min(max((time - pause_at) / (2.0 * cost) + 0.5, 0.0), 1.0)
    return time - 2.0 * cost * (0.5 * inside - np.sin(2.0 * np.pi * inside) / (4.0 * np.pi))


@njit(cache=True, error_model="numpy")
def place_hand(kind, start, places, scatter, style, pausing, z, time, path):  # type: ignore[no-untyped-def]
    """Write the hand at times (T,), s, that go forward, to `path` (T, 3).

    Its position without tremor, and how large tremor is there, in [0, 1]. `style` is overlap, bow, pace, and shortest
    and longest pause of `HumanStyle`.
    """
    points, onsets, spans = np.empty((_MOST, 2)), np.empty(_MOST), np.empty(_MOST)
    count = lay_waypoints(kind, start, places, scatter, z[SHARED:], points)
    pace = np.exp(style[2] * min(max(z[0], -1.5), 1.5))
    over = _time_moves(points, count, style[0], pace, onsets, spans)
    cost = style[3] + z[4] * (style[4] - style[3]) if pausing else 0.0
    pause_at = (0.3 + 0.4 * z[3]) * over + 0.5 * cost
    dx, dy = points[count - 1, 0] - points[0, 0], points[count - 1, 1] - points[0, 1]
    bowed = style[1] if count == 2 else 0.0
    done = 0
    for t in range(len(time)):
        wall = min(time[t], over + cost)
        own = _own_clock(wall, pause_at, cost)
        while done < count - 1 and own >= onsets[done] + spans[done]:
            done += 1
        x, y = points[done, 0], points[done, 1]
        for k in range(done, count - 1):
            if own <= onsets[k]:
                break
            share = _minimum_jerk((own - onsets[k]) / spans[k])
            x += share * (points[k + 1, 0] - points[k, 0])
            y += share * (points[k + 1, 1] - points[k, 1])
        phase = np.pi * _minimum_jerk(own / over)
        bow = bowed * (z[1] * np.sin(phase) + 0.5 * z[2] * np.sin(2.0 * phase))
        path[t, 0], path[t, 1] = x - bow * dy, y + bow * dx
        ratio = wall / (over + cost)
        path[t, 2] = _minimum_jerk(ratio / 0.15) * _minimum_jerk((1.0 - ratio) / 0.15)
