"""What the choice of a sidestep computes of an arm that is led aside, compiled."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pft_exec.control.separation import cross, move_body
from pft_exec.control.tool_kernel import between
from pft_exec.geometry import Array
from pft_exec.geometry.definite import factorize, substitute_back, substitute_forward

_DAMPING = 1e-4  # m^2; near a singularity no joint is led far aside
_SAMPLES = 5  # of a link, beside a flat-sided obstacle
_NOTHING = 1e-6  # deviations below which there is no step
_SHORTEST = 1e-12  # m^2; a segment below this is a point


@njit(cache=True)
def spread_of(deviation: Array, phase: float) -> Array:
    """Deviation (3, 3), m, between those (N, 3, 3) that are evenly spaced in phase."""
    spread: Array = between(deviation, phase)
    return spread


@njit(cache=True)
def follow_choice(
    wanted: Array, chain: Array, pole: float, period: float, deviation: Array, phase: float, shift: Array
) -> bool:
    """Let three equal poles in a row follow a choice over one period; whether there is a step at all.

    Parameters
    ----------
    wanted, chain : (3,) and (3, 3), deviations
        The choice, and the states of the poles, which go on.
    pole, period : float, 1/s and s
    deviation, phase : (N, 3, 3), m, and float
        Of the tube, and where on it.
    shift : (3, 3), m, m/s, m/s^2
        Written to: shift of the target, its velocity and its acceleration.
    """
    if max(np.abs(chain).max(), np.abs(wanted).max()) < _NOTHING:
        chain[:] = 0.0
        return False
    share = 1.0 - math.exp(-pole * period)
    before = wanted
    for stage in range(3):
        chain[stage] += share * (before - chain[stage])
        before = chain[stage]
    rate = pole * (chain[1] - chain[2])
    spread = between(deviation, phase)
    shift[0] = spread @ chain[2]
    shift[1] = spread @ rate
    shift[2] = spread @ (pole * (pole * (chain[0] - chain[1]) - rate))
    return True


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
    cores, rotations, rounding, half = others
    lacking, worst, moved, led = np.zeros(len(steps)), np.zeros(len(steps)), np.zeros(3), np.zeros((len(steps), 2, 3))
    for j in range(len(ends)):
        worst[:] = 0.0
        for i in range(ends.shape[1]):
            farthest = 0.0
            for c in range(len(steps)):
                for r in range(3):
                    aside = 0.0
                    for m in range(3):
                        aside += spread[j, r, m] * steps[c, m]
                    moved[r] = (1.0 - fading[j]) * aside + fading[j] * error[r]
                farthest = max(farthest, _lead(ends[j, i], carried[j, i], moved, led[c]))
            for k in range(cores.shape[1]):
                close = room + radius[i] + rounding[k]
                if _distance(ends[j, i], cores[j, k], rotations[j, k], half[k]) > close + farthest:
                    continue
                for c in range(len(steps)):
                    worst[c] = max(worst[c], close - _distance(led[c], cores[j, k], rotations[j, k], half[k]))
        for c in range(len(steps)):
            lacking[c] += worst[c] ** 2
    return lacking


@njit(cache=True)
def _lead(ends: Array, carried: Array, moved: Array, led: Array) -> float:
    """Write where the ends (2, 3), m, of a link are when the tool moves by (3,), m; how far the farther one moves."""
    farthest = 0.0
    for e in range(2):
        total = 0.0
        for r in range(3):
            aside = 0.0
            for m in range(3):
                aside += carried[e, r, m] * moved[m]
            led[e, r] = ends[e, r] + aside
            total += aside * aside
        farthest = max(farthest, total)
    return math.sqrt(farthest)


@njit(cache=True)
def _distance(ends: Array, core: Array, rotation: Array, half: Array) -> float:
    """Distance, m, of a segment from a core: a segment (2, 3), m, or a box of half lengths (3,), m, about it."""
    if half[0] > 0.0:
        return float(box_distance(ends, core[0], rotation, half))
    return float(segment_distance(ends, core))


@njit(cache=True)
def box_distance(ends: Array, center: Array, rotation: Array, half: Array) -> float:
    """Distance, m, of samples of a segment (2, 3), m, from a box with a center, a rotation and half lengths (3,), m."""
    least = math.inf
    for sample in range(_SAMPLES):
        share, total = sample / (_SAMPLES - 1.0), 0.0
        for axis in range(3):
            local = 0.0
            for i in range(3):
                place = (1.0 - share) * float(ends[0, i]) + share * float(ends[1, i])
                local += float(rotation[i, axis]) * (place - float(center[i]))
            beyond = abs(local) - float(half[axis])
            if beyond > 0.0:
                total += beyond * beyond
        if total < least:
            least = total
    return math.sqrt(least)


@njit(cache=True)
def segment_distance(one: Array, other: Array) -> float:
    """Distance, m, of two segments, ends (2, 3) each, m; either may be a point.

    Notes
    -----
    The nearest points of the lines, each held within its segment and the other taken anew [Ericson2005]_, 5.1.9.
    """
    aa, ee, f, g, mixed = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        first, second = float(one[1, i] - one[0, i]), float(other[1, i] - other[0, i])
        apart = float(one[0, i] - other[0, i])
        aa, ee, mixed = aa + first * first, ee + second * second, mixed + first * second
        f, g = f + second * apart, g + first * apart
    s, t = 0.0, f / ee if ee > _SHORTEST else 0.0
    if aa > _SHORTEST:
        flat = aa * ee - mixed * mixed
        s = within_one((mixed * f - g * ee) / flat) if flat > _SHORTEST * aa * ee else 0.0
        t = (mixed * s + f) / ee if ee > _SHORTEST else 0.0
        if ee <= _SHORTEST or t < 0.0 or t > 1.0:
            t = within_one(t)
            s = within_one((mixed * t - g) / aa)
    t, total = within_one(t), 0.0
    for i in range(3):
        place = (1.0 - s) * float(one[0, i]) + s * float(one[1, i])
        gap = place - (1.0 - t) * float(other[0, i]) - t * float(other[1, i])
        total += gap * gap
    return math.sqrt(total)


@njit(cache=True)
def within_one(share: float) -> float:
    """A share held within [0, 1]."""
    return 0.0 if share < 0.0 else 1.0 if share > 1.0 else share


@njit(cache=True)
def places_of(started: tuple[Array, Array, Array], half: Array, elapsed: Array) -> tuple[Array, Array]:
    """Ends of the cores (N, K, 2, 3), m, and rotations (N, K, 3, 3) of K obstacles after N times, s.

    Parameters
    ----------
    started : (K, 3), m, (K, 3, 3) and (K, 6), m/s and rad/s
        Where their frames were, how they were turned, and their velocities.
    half : (K,), m
        Half the core segments.
    elapsed : (N,), s
    """
    count = len(half)
    ends, rotations = np.zeros((len(elapsed), count, 2, 3)), np.zeros((len(elapsed), count, 3, 3))
    middle, motion = np.zeros((count, 3)), np.zeros((count, 2, 6))
    for j in range(len(elapsed)):
        bodies = rotations[j], middle, ends[j], motion
        for k in range(count):
            move_body(started[0][k], started[1][k], started[2][k], elapsed[j], half[k], k, bodies)
    return ends, rotations
