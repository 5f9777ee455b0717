"""What the choice of a sidestep computes of an arm that is led aside, compiled."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pft_exec.control.separation import cross
from pft_exec.control.tool_kernel import between
from pft_exec.geometry import Array
from pft_exec.geometry.definite import factorize, substitute_back, substitute_forward

_DAMPING = 1e-4  # m^2; near a singularity no joint is led far aside
_SAMPLES = 5  # of a link, beside a flat-sided obstacle
_SHORTEST = 1e-12  # m^2; a segment below this is a point


@njit(cache=True)
def spread_of(deviation: Array, phase: float) -> Array:
    """Deviation (3, 3), m, between those (N, 3, 3) that are evenly spaced in phase."""
    spread: Array = between(deviation, phase)
    return spread


@njit(cache=True)
def carried_ends(
    local: Array,
    joint: NDArray[np.intp],
    frames: tuple[Array, Array, Array],
    tool_jacobian: Array,
    ends: Array,
    carried: Array,
) -> None:
    """Where the ends of L links are, and how they move where the tool is led aside without turning.

    Parameters
    ----------
    local, joint : (L, 2, 3), m, in the frames of their joints (L,)
    frames : rotation (n, 3, 3), translation (n, 3), m, and Jacobian (6, n)
        As of `Arm.joint_frames`.
    tool_jacobian : (6, n)
    ends, carried : (L, 2, 3), m, and (L, 2, 3, 3)
        Written to; the motion per motion of the tool is that of least joint motion.
    """
    rotation, translation, jacobian = frames
    led = _least_motion(tool_jacobian)
    for i in range(len(local)):
        for e in range(2):
            k = joint[i]
            point = translation[k] + np.ascontiguousarray(rotation[k]) @ local[i, e]
            ends[i, e] = point
            carried[i, e] = 0.0
            for c in range(k + 1):
                axis = np.ascontiguousarray(jacobian[3:, c])
                speed = jacobian[:3, c] + cross(axis, point)
                for r in range(3):
                    for m in range(3):
                        carried[i, e, r, m] += speed[r] * led[c, m]


@njit(cache=True)
def _least_motion(jacobian: Array) -> Array:
    """Joint motion (n, 3) per motion of the tool (6, n), which does not turn."""
    n = jacobian.shape[1]
    square, led = np.zeros((6, 6)), np.zeros((n, 3))
    for i in range(6):
        for j in range(i + 1):
            square[i, j] = _DAMPING if i == j else 0.0
            for k in range(n):
                square[i, j] += jacobian[i, k] * jacobian[j, k]
    factorize(square)
    for m in range(3):
        part = np.zeros(6)
        part[m] = 1.0
        substitute_forward(square, part)
        substitute_back(square, part)
        for k in range(n):
            for i in range(6):
                led[k, m] += jacobian[i, k] * part[i]
    return led


@njit(cache=True)
def judge_steps(
    steps: Array,
    arm: tuple[Array, Array, Array],
    spread: Array,
    fading: Array,
    error: Array,
    others: tuple[Array, Array, Array, Array],
    room: float,
) -> Array:
    """What C steps (C, 3), deviations, lack of their room: the sum over N instants of its square, (C,), m^2.

    Parameters
    ----------
    steps : (C, 3)
    arm : (N, L, 2, 3), m, (N, L, 2, 3, 3) and (L,), m
        Ends of the links, how they are carried along with the tool, and radii.
    spread, fading, error : (N, 3, 3), m, (N,) and (3,), m
        Of the tube; what is left of the present error; and that error.
    others : (N, K, 2, 3), m, (N, K, 3, 3), (K,), m, and (K, 3), m
        Ends of the obstacles' cores, rotations, roundings, and half lengths of flat-sided ones.
    room : float, m
    """
    ends, carried, radius = arm
    lacking, moved = np.zeros(len(steps)), np.zeros((len(steps), 3))
    worst = np.zeros(len(steps))
    for j in range(len(ends)):
        farthest = 0.0
        for c in range(len(steps)):
            moved[c] = (1.0 - fading[j]) * (np.ascontiguousarray(spread[j]) @ steps[c]) + fading[j] * error
            farthest = max(farthest, float(moved[c] @ moved[c]))
            worst[c] = 0.0
        reach = 2.0 * math.sqrt(farthest) + room
        for i in range(ends.shape[1]):
            for k in range(others[0].shape[1]):
                core = others[0][j, k], others[1][j, k], others[3][k]
                close = room + radius[i] + others[2][k]
                if _distance(ends[j, i, 0], ends[j, i, 1], core) > close + reach:
                    continue
                for c in range(len(steps)):
                    a, b = (
                        _led(ends[j, i, 0], carried[j, i, 0], moved[c]),
                        _led(ends[j, i, 1], carried[j, i, 1], moved[c]),
                    )
                    worst[c] = max(worst[c], close - _distance(a, b, core))
        for c in range(len(steps)):
            lacking[c] += worst[c] ** 2
    return lacking


@njit(cache=True)
def _led(point: Array, carried: Array, moved: Array) -> Array:
    """A point (3,), m, carried along by a motion (3,), m, of the tool."""
    led = point.copy()
    for r in range(3):
        for m in range(3):
            led[r] += carried[r, m] * moved[m]
    return led


@njit(cache=True)
def _distance(a: Array, b: Array, core: tuple[Array, Array, Array]) -> float:
    """Distance, m, of a segment from a to b (3,) from a core: the segment between its ends, or a box around them."""
    ends, rotation, half = core
    if half[0] <= 0.0:
        return float(segment_distance(a, b, ends[0], ends[1]))
    least = math.inf
    for sample in range(_SAMPLES):
        total = 0.0
        for axis in range(3):
            beyond = -float(half[axis])
            local = 0.0
            for i in range(3):
                place = float(a[i]) + sample / (_SAMPLES - 1.0) * float(b[i] - a[i])
                local += float(rotation[i, axis]) * (place - float(ends[0, i]))
            beyond += abs(local)
            if beyond > 0.0:
                total += beyond * beyond
        if total < least:
            least = total
    return math.sqrt(least)


@njit(cache=True)
def segment_distance(a: Array, b: Array, c: Array, d: Array) -> float:
    """Distance, m, of a segment from a to b from another from c to d, (3,) each, m; either may be a point.

    Notes
    -----
    The nearest points of the lines, each held within its segment and the other taken anew [Ericson2005]_, 5.1.9.
    """
    first, second, apart = b - a, d - c, a - c
    aa, ee, f = float(first @ first), float(second @ second), float(second @ apart)
    s, t = 0.0, f / ee if ee > _SHORTEST else 0.0
    if aa > _SHORTEST:
        g, mixed = float(first @ apart), float(first @ second)
        flat = aa * ee - mixed * mixed
        s = within_one((mixed * f - g * ee) / flat) if flat > _SHORTEST * aa * ee else 0.0
        t = (mixed * s + f) / ee if ee > _SHORTEST else 0.0
        if ee <= _SHORTEST or t < 0.0 or t > 1.0:
            t = within_one(t)
            s = within_one((mixed * t - g) / aa)
    t = within_one(t)
    gap = apart + s * first - t * second
    return math.sqrt(gap @ gap)


@njit(cache=True)
def within_one(share: float) -> float:
    """A share held within [0, 1]."""
    return 0.0 if share < 0.0 else 1.0 if share > 1.0 else share
