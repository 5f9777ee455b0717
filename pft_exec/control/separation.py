r"""Distances in motion: how the distance between two convex bodies changes, to second order.

A body is what lies within a radius of a core: a point, a segment, or a solid. Let c1, c2 be the nearest points of the
two cores, d their distance L less both radii, n the unit vector from the first to the second. As c1 and c2 are where
the distance is least, moving them along the cores changes nothing to first order, so

.. math:: \dot d = n \cdot (v_2 - v_1), \qquad
          \ddot d = n \cdot (a_2 - a_1) + \frac{\lVert w_\perp \rVert^2}{L} - g^T S^{-1} g ,

with velocities v and accelerations a of the material points, and w the part of v2 - v1 across n: the normal turns.
The last term is the slip of the nearest points along segments e1, e2 (those of them that are inside their segment),

.. math:: g_1 = -(w \cdot e_1)/L - n \cdot (\omega_1 \times e_1),\quad
          g_2 = (w \cdot e_2)/L + n \cdot (\omega_2 \times e_2),\quad
          S = \tfrac1L \begin{pmatrix} |e_1|^2 & -e_1 \cdot e_2 \\ -e_1 \cdot e_2 & |e_2|^2 \end{pmatrix}_\perp .

Of a flat-sided solid neither the turn of the normal nor the slip is counted: its nearest point stays for an instant on
a face, an edge or a corner, and on a face, where most of an arm's encounters are, both vanish. The material
accelerations are :math:`J \ddot q + \dot J \dot q`, so :math:`\ddot d` is linear in the joint accelerations.
Derivation ours.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pft_exec.geometry import Array

_SHORTEST = 1e-3  # m; a core distance below this counts as this
Bodies = tuple[Array, Array, Array, Array]

_INSIDE = 1e-4  # share of a segment from its ends from which on a point is inside
_BESIDES = 1.5
"""Of the joints' accelerations: leaves room for what the motion itself bends, and for limits that are exceeded."""
_PARALLEL = 1e-6  # share of the determinant below which two segments are parallel


@njit(cache=True)
def cross(a: Array, b: Array) -> Array:
    """Cross product of two vectors (3,)."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@njit(cache=True)
def chain_motion(jacobian: Array, v: Array) -> tuple[Array, Array]:
    """Velocity and acceleration (n, 6) of what each joint moves, at zero joint acceleration.

    Of the point at the origin of the base frame, then angular, from `Arm.joint_frames`' Jacobian (6, n) and velocities
    (n,), rad/s. The acceleration is spatial: the derivative of the velocity at that fixed place.
    """
    count = len(v)
    velocity, acceleration = np.zeros((count, 6)), np.zeros((count, 6))
    now, change = np.zeros(6), np.zeros(6)
    for k in range(count):
        column = np.ascontiguousarray(jacobian[:, k])
        now = now + column * v[k]
        change[:3] += v[k] * (cross(now[3:], column[:3]) + cross(now[:3], column[3:]))
        change[3:] += v[k] * cross(now[3:], column[3:])
        velocity[k], acceleration[k] = now, change
    return velocity, acceleration


@njit(cache=True)
def point_motion(point: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array]:
    """Velocity and classical acceleration (3,) of a point (3,), m, of a body with a row of `chain_motion` each."""
    speed = velocity[:3] + cross(velocity[3:], point)
    return speed, acceleration[:3] + cross(acceleration[3:], point) + cross(velocity[3:], speed)


@njit(cache=True)
def distance_row(row: Array, jacobian: Array, joint: int, point: Array, normal: Array, sign: float) -> None:
    """Add ``sign * normal . J`` of a point (3,), m, that a joint moves to a row (n,)."""
    lever = cross(point, normal)
    for k in range(joint + 1):
        total = 0.0
        for i in range(3):
            total += normal[i] * jacobian[i, k] + lever[i] * jacobian[3 + i, k]
        row[k] += sign * total


@njit(cache=True)
def second_order(normal: Array, gap: float, speed: Array, edges: Array, turning: Array, share: Array) -> float:
    """What turn of the normal and slip add to the second derivative of a distance, m/s^2; see the module's formula.

    Parameters
    ----------
    normal : (3,)
    gap : float, m
        Distance L of the cores.
    speed : (3,), m/s
        v2 - v1.
    edges, turning : (2, 3), (2, 3), m and rad/s
        The segments e1, e2 and the angular velocities of the bodies.
    share : (2,)
        Where on each segment its nearest point is.
    """
    length = max(gap, _SHORTEST)
    across = speed - np.dot(speed, normal) * normal
    turn = np.dot(across, across) / length
    g, s, flat = np.zeros(2), np.zeros(2), np.zeros((2, 3))
    for i in range(2):
        if _INSIDE < share[i] < 1.0 - _INSIDE:
            edge = np.ascontiguousarray(edges[i])
            flat[i] = edge - np.dot(edge, normal) * normal
            s[i] = np.dot(flat[i], flat[i]) / length
            g[i] = np.dot(across, edge) / length + np.dot(normal, cross(turning[i], edge))
    g[0] = -g[0]
    mixed = -np.dot(flat[0], flat[1]) / length
    determinant = s[0] * s[1] - mixed**2
    if determinant > _PARALLEL * s[0] * s[1]:
        return float(turn - (s[1] * g[0] ** 2 - 2.0 * mixed * g[0] * g[1] + s[0] * g[1] ** 2) / determinant)
    for i in range(2):
        if s[i] > 0.0:
            return float(turn - g[i] ** 2 / s[i])
    return float(turn)


@njit(cache=True)
def pairs_that_may_be_near(
    pairs: NDArray[np.intp], middle: Array, reach: Array, rotation: Array, half: Array, rounding: Array, near: Array
) -> NDArray[np.intp]:
    """Indices of those of P pairs (P, 2) of bodies whose distance is not surely above `near` (P,), m.

    Parameters
    ----------
    pairs : (P, 2), int
    middle, reach : (B, 3) and (B,), m
        Centre and radius of a ball around each body.
    rotation, half, rounding : (B, 3, 3), (B, 3) and (B,), m
        A box around each body, of these half lengths, rounded; only the second body of a pair is looked at.
    """
    found = np.empty(len(pairs), dtype=np.intp)
    count = 0
    for p in range(len(pairs)):
        i, k = pairs[p]
        away = middle[i] - middle[k]
        total = 0.0
        for axis in range(3):
            local = rotation[k, 0, axis] * away[0] + rotation[k, 1, axis] * away[1] + rotation[k, 2, axis] * away[2]
            total += max(abs(local) - half[k, axis], 0.0) ** 2
        if np.sqrt(total) - rounding[k] - reach[i] < near[p]:
            found[count] = p
            count += 1
    return found[:count]


@njit(cache=True)
def strongest_accelerations(
    jacobian: Array, joint: NDArray[np.intp], middle: Array, reach: Array, most: Array
) -> Array:
    """How hard all joints together can accelerate any point of each of B bodies, (B,), m/s^2; 0 of what none moves.

    Parameters
    ----------
    jacobian : (6, n)
        As of `Arm.joint_frames`.
    joint : (B,), int
        That moves a body; -1 for none.
    middle, reach : (B, 3) and (B,), m
    most : (n,), rad/s^2
    """
    strongest = np.zeros(len(joint))
    for b in range(len(joint)):
        for k in range(joint[b] + 1):
            axis = np.ascontiguousarray(jacobian[3:, k])
            arm = jacobian[:3, k] + cross(axis, middle[b])
            strongest[b] += most[k] * (np.sqrt(np.dot(arm, arm)) + reach[b] * np.sqrt(np.dot(axis, axis)))
    return strongest


@njit(cache=True)
def distances_that_matter(
    pairs: NDArray[np.intp],
    middle: Array,
    reach: Array,
    motion: Array,
    strongest: Array,
    most: Array,
    pole: float,
    safe: float,
) -> Array:
    """Distances (P,), m, beyond which the row of a pair would hold whatever the joints do.

    With the bodies as fast and as hard to stop as any of their points, the row of `least_rates` holds by itself where
    ``pole^2 (d - safe) >= 2 pole speed + acceleration``.

    Parameters
    ----------
    pairs : (P, 2), int
    middle, reach, motion : (B, 3) and (B,), m, and (B, 2, 6)
        As of `distance_rows`.
    strongest : (B,), m/s^2
        As of `strongest_accelerations`.
    most : (P,), m
        No distance is larger than this.
    pole, safe : float, 1/s and m
    """
    quick = np.empty(len(middle))
    for b in range(len(middle)):
        turn = motion[b, 0, 3:]
        speed = motion[b, 0, :3] + cross(turn, middle[b])
        quick[b] = np.sqrt(np.dot(speed, speed)) + reach[b] * np.sqrt(np.dot(turn, turn))
    matters = np.empty(len(pairs))
    for p in range(len(pairs)):
        i, k = pairs[p]
        hard = _BESIDES * (strongest[i] + strongest[k])
        matters[p] = min(most[p], safe + (2.0 * pole * (quick[i] + quick[k]) + hard) / pole**2)
    return matters


@njit(cache=True)
def distance_rows(
    pairs: NDArray[np.intp],
    distance: Array,
    points: Array,
    normals: Array,
    ends: Array,
    rounding: Array,
    is_round: NDArray[np.bool_],
    joint: NDArray[np.intp],
    motion: Array,
    jacobian: Array,
) -> tuple[Array, Array, Array]:
    """How the distances of P pairs (P, 2) of bodies change: ``dd = rows @ qdd + drift``.

    Parameters
    ----------
    pairs : (P, 2), int
    distance, points, normals : (P,), m, (P, 3), m, and (P, 3)
        Nearest points of the first bodies' surfaces, and unit vectors from the first bodies to the second.
    ends, rounding, is_round : (B, 2, 3) and (B,), m, and (B,), bool
        Core segment and radius of each body; without a radius for a flat-sided one.
    joint : (B,), int
        That moves a body; -1 for none.
    motion : (B, 2, 6)
        Velocity and acceleration of each body, as of `chain_motion`.
    jacobian : (6, n)

    Returns
    -------
    rows, drift, rate : (P, n), m, (P,), m/s^2, and (P,), m/s
    """
    rows = np.zeros((len(pairs), jacobian.shape[1]))
    drift, rate = np.empty(len(pairs)), np.empty(len(pairs))
    for p in range(len(pairs)):
        first, second = pairs[p]
        normal, gap = normals[p], distance[p] + rounding[first] + rounding[second]
        point_1 = points[p] - rounding[first] * normal
        point_2 = point_1 + gap * normal
        v1, a1 = point_motion(point_1, motion[first, 0], motion[first, 1])
        v2, a2 = point_motion(point_2, motion[second, 0], motion[second, 1])
        distance_row(rows[p], jacobian, joint[first], point_1, normal, -1.0)
        distance_row(rows[p], jacobian, joint[second], point_2, normal, 1.0)
        rate[p], drift[p] = np.dot(normal, v2 - v1), np.dot(normal, a2 - a1)
        if is_round[second]:
            edges = ends[pairs[p], 1] - ends[pairs[p], 0]
            share = np.array(
                [place_on_segment(point_1, ends[first], edges[0]), place_on_segment(point_2, ends[second], edges[1])]
            )
            drift[p] += second_order(normal, gap, v2 - v1, edges, motion[pairs[p], 0, 3:], share)
    return rows, drift, rate


@njit(cache=True)
def least_rates(
    rows: Array, drift: Array, rate: Array, distance: Array, pole: float, safe: float, most: Array
) -> Array:
    """Least ``rows @ qdd`` (P,), m/s^2, with which pairs come to rest at the safe distance; see `avoidance`.

    Parameters
    ----------
    rows, drift, rate, distance : (P, n), m, (P,), m/s^2, (P,), m/s, and (P,), m
    pole, safe : float, 1/s and m
    most : (n,), rad/s^2
        Accelerations of the joints: no row asks for more than all of them give.
    """
    least = np.empty(len(rows))
    for p in range(len(rows)):
        given = 0.0
        for k in range(len(most)):
            given += abs(rows[p, k]) * most[k]
        wanted = -drift[p] - 2.0 * pole * rate[p] - pole**2 * (distance[p] - safe)
        least[p] = min(wanted, given)
    return least


@njit(cache=True)
def place_on_segment(point: Array, ends: Array, edge: Array) -> float:
    """Share in [0, 1] of a segment (2, 3), m, of edge (3,), at which a point (3,), m, on it lies; 0 without length."""
    square = np.dot(edge, edge)
    return float(np.dot(point - ends[0], edge) / square) if square > 0.0 else 0.0


@njit(cache=True)
def place_links(
    local: Array,
    joint: NDArray[np.intp],
    joint_rotation: Array,
    joint_translation: Array,
    ends: Array,
    middle: Array,
    rotation: Array,
) -> None:
    """Put the first K of B bodies, the links, where an arm's joints are.

    Parameters
    ----------
    local : (K, 2, 3), m
        Ends of the capsules in their joints' frames.
    joint : (B,), int
    joint_rotation, joint_translation : (n, 3, 3), (n, 3), m
    ends, middle, rotation : (B, 2, 3), (B, 3), m, and (B, 3, 3)
        Written to: ends and middles of the capsules, and rotations that turn z into their axes, base frame.
    """
    for i in range(len(local)):
        frame, origin = joint_rotation[joint[i]], joint_translation[joint[i]]
        for e in range(2):
            for r in range(3):
                value = origin[r]
                for c in range(3):
                    value += frame[r, c] * local[i, e, c]
                ends[i, e, r] = value
        middle[i] = 0.5 * (ends[i, 0] + ends[i, 1])
        axis = ends[i, 1] - ends[i, 0]
        length = np.sqrt(np.dot(axis, axis))
        rotation[i] = np.eye(3)
        if length > 1e-9:
            axis = axis / length
            least = np.argmin(np.abs(axis))
            other = np.zeros(3)
            other[least] = 1.0
            x = cross(other, axis)
            x = x / np.sqrt(np.dot(x, x))
            rotation[i, :, 0], rotation[i, :, 1], rotation[i, :, 2] = x, cross(axis, x), axis


@njit(cache=True)
def move_body(start: Array, turn: Array, velocity: Array, elapsed: float, half: float, k: int, bodies: Bodies) -> None:
    """Move body k of some to where it is after a time, s.

    Parameters
    ----------
    start, turn : (3,), m, and (3, 3)
        Where its frame was, base frame.
    velocity : (6,), m/s and rad/s
        Of its frame: linear, then angular.
    half : float, m
        Half its core segment, along its z axis.
    bodies : (rotation, middle, ends, motion)
        (B, 3, 3), (B, 3), m, (B, 2, 3), m, and (B, 2, 6): written to.

    Notes
    -----
    Rodrigues' formula. A frame that moves and turns evenly has no acceleration of its own; the acceleration of the
    point at the base frame's origin is then ``-omega x v``.
    """
    rotation, middle, ends, motion = bodies
    linear, angular = velocity[:3], velocity[3:]
    angle = elapsed * np.sqrt(np.dot(angular, angular))
    if angle > 1e-9:
        axis = angular * (elapsed / angle)
        for column in range(3):
            vector = np.ascontiguousarray(turn[:, column])
            around = np.dot(axis, vector) * axis
            turned = around + np.cos(angle) * (vector - around) + np.sin(angle) * cross(axis, vector)
            rotation[k, :, column] = turned
    else:
        rotation[k] = turn
    middle[k] = start + elapsed * linear
    ends[k, 0], ends[k, 1] = middle[k] - half * rotation[k, :, 2], middle[k] + half * rotation[k, :, 2]
    motion[k, 0, :3], motion[k, 0, 3:] = linear - cross(angular, middle[k]), angular
    motion[k, 1, :3] = -cross(angular, linear)
