r"""Avoidance: what an arm must keep away from, as rows on its joint accelerations.

For each pair of a link and an obstacle, or of two links, that is near, with distance d,

.. math:: \ddot d \ge -2 a\, \dot d - a^2 (d - d_s),

so that the arm comes to rest at the distance :math:`d_s` without overshoot, however the obstacle moves: an exponential
control barrier function with both poles at -a [Nguyen2016]_. The rows are soft and :math:`d_s` is a centimetre more
than what is to be kept: torque limits come first. No row asks for more than all joints at their acceleration limits
would give: what is near from the beginning, or appears there, is left quickly, but never by a jump. How d changes is
`separation`'s matter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import coal
import numpy as np
from numpy.typing import NDArray

from pft_exec.control.limits import Constraint
from pft_exec.control.separation import (
    chain_motion,
    distance_rows,
    distances_that_matter,
    least_rates,
    move_body,
    pairs_that_may_be_near,
    place_links,
    strongest_accelerations,
)
from pft_exec.control.tool_kernel import matrix_of
from pft_exec.geometry import Array
from pft_exec.model import Arm, Box, Capsule, Cylinder, Obstacle, Solid, Sphere
from pft_exec.model.distance import coal_shape, nearest_points

SAFE_DISTANCE = 0.03
"""m; where the approach ends. Soft rows and torque limits took up to 8 mm of it (measured), so 2 cm are kept."""
NEAR = 0.25
"""m; pairs of a link and an obstacle that are farther apart are left out, and nearer ones where nothing that the joints
can do would matter yet."""
OWN_NEAR = 0.12
"""m; the same for pairs of the robot's own parts, which approach each other slowly."""
APPROACH = 20.0
"""1/s; a: 5 to 20 make no difference to what is kept (measured)."""
FIRST_MOVED = 1
"""Index of the joint from which on links keep off obstacles: the first joint turns its link about that link's own axis,
which avoids nothing, and beside the other arm's it stands anyway."""
FORESEEN = 0.5
"""s; for which an obstacle is taken to move on at its velocity when nothing newer is known of it."""


@dataclass(frozen=True, eq=False)
class Nearness:
    """Pairs that are near, and what keeps them apart.

    Parameters
    ----------
    constraint : Constraint
        A soft row for each of P pairs.
    distance : (P,), m
    pairs : P times (int, int)
        Of bodies.
    bodies : sequence of str
        Names of all bodies.
    """

    constraint: Constraint
    distance: Array
    pairs: Sequence[tuple[int, int]]
    bodies: Sequence[str]

    def names(self, chosen: NDArray[np.bool_]) -> tuple[str, ...]:
        """Names of chosen (P,) pairs: "link / obstacle"."""
        if not chosen.any():
            return ()
        return tuple(
            f"{self.bodies[i]} / {self.bodies[k]}"
            for (i, k), is_chosen in zip(self.pairs, chosen, strict=True)
            if is_chosen
        )


class _Bodies:
    """B bodies, links first, as arrays that compiled code reads."""

    def __init__(self, arm: Arm, obstacles: Sequence[Obstacle]) -> None:
        links = arm.geometry.links
        self.count = len(links)
        self.names = [*(link.name for link in links), *(obstacle.name for obstacle in obstacles)]
        self.local = np.array([[link.start, link.end] for link in links])
        cores = [(0.5 * link.length, link.radius) for link in links]
        cores += [_core(obstacle.solid) for obstacle in obstacles]
        total = len(cores)
        self.reach = np.array([half + radius for half, radius in cores])
        self.rounding = np.array([radius for _, radius in cores])
        self.is_round = self.rounding > 0.0
        self.joint = np.array([link.joint for link in links] + [-1] * len(obstacles), dtype=np.intp)
        self.half = np.zeros((total, 3))
        self.wrap = self.reach.copy()
        self.middle, self.ends = np.zeros((total, 3)), np.zeros((total, 2, 3))
        self.rotation, self.motion = np.tile(np.eye(3), (total, 1, 1)), np.zeros((total, 2, 6))
        shapes = [coal.Capsule(link.radius, max(link.length, 1e-9)) for link in links]
        self.shapes = [*shapes, *(coal_shape(obstacle.solid) for obstacle in obstacles)]
        self.places = [coal.Transform3s() for _ in range(total)]
        for k, obstacle in enumerate(obstacles, self.count):
            if not self.is_round[k]:
                self.half[k], self.wrap[k] = _half_lengths(obstacle.solid), 0.0
        self.started: list[tuple[Array, Array, Array, float]] = []
        self.replace(obstacles)

    def replace(self, obstacles: Sequence[Obstacle]) -> None:
        """Take the last bodies, of these shapes, to be where these obstacles are."""
        first = len(self.shapes) - len(obstacles)
        del self.started[first - self.count :]
        for k, obstacle in enumerate(obstacles, first):
            half = float(self.reach[k] - self.rounding[k]) if self.is_round[k] else 0.0
            turn = matrix_of(obstacle.pose.quaternion)
            self.started.append((obstacle.pose.position, turn, obstacle.velocity, half))
            self.put(k, 0.0)

    def put(self, k: int, elapsed: float) -> None:
        """Move an obstacle to where it is after a time, s."""
        position, turn, velocity, half = self.started[k - self.count]
        move_body(position, turn, velocity, elapsed, half, k, (self.rotation, self.middle, self.ends, self.motion))
        self.turn(k)

    def turn(self, k: int) -> None:
        """Tell coal where a body is."""
        self.places[k].setRotation(self.rotation[k])
        self.places[k].setTranslation(self.middle[k])

    def changes(
        self, pairs: NDArray[np.intp], distance: Array, points: Array, normals: Array, jacobian: Array
    ) -> tuple[Array, Array, Array]:
        """How the distances of pairs change; see `distance_rows`."""
        found: tuple[Array, Array, Array] = distance_rows(
            pairs, distance, points, normals, self.ends, self.rounding, self.is_round, self.joint, self.motion, jacobian
        )
        return found


class Avoidance:
    """Keeps an arm off obstacles and off the robot itself.

    Parameters
    ----------
    arm : Arm
    self_collision : bool
        Whether links keep off the body and off each other, besides the obstacles.
    safe_distance : float, m
    """

    def __init__(self, arm: Arm, self_collision: bool = True, safe_distance: float = SAFE_DISTANCE) -> None:
        self.safe_distance = safe_distance
        self._arm = arm
        self._self_collision = self_collision
        self.moved = tuple(i for i, link in enumerate(arm.geometry.links) if link.joint >= FIRST_MOVED)
        """Which of the arm's links keep off obstacles."""
        self._watched: tuple[Obstacle, ...] = ()
        self._take_up(())
        self.watch((), 0.0)

    def watch(self, obstacles: Sequence[Obstacle], time: float) -> None:
        """Keep off these obstacles from now on, and off no others.

        Parameters
        ----------
        obstacles : sequence of Obstacle
            Base frame, as they are at `time`, s; they are taken to move on at their velocity.
        time : float, s
        """
        if len(obstacles) == len(self._watched) and all(map(_is_same, obstacles, self._watched)):
            self._bodies.replace(obstacles)
        else:
            self._take_up(obstacles)
        self._watched = tuple(obstacles)
        first = len(self._bodies.shapes) - len(obstacles)
        self._moving = [first + k for k, obstacle in enumerate(obstacles) if obstacle.velocity.any()]
        self._time = time

    def _take_up(self, obstacles: Sequence[Obstacle]) -> None:
        """Make bodies of obstacles that are of other shapes than those before."""
        geometry = self._arm.geometry
        body = geometry.body if self._self_collision else ()
        count, fixed = len(geometry.links), len(geometry.links) + len(body)
        pairs = [(i, fixed + k) for k in range(len(obstacles)) for i in self.moved]
        own = len(pairs)
        if self._self_collision:
            pairs += [(i, count + k) for i, k in geometry.body_pairs] + list(geometry.link_pairs)
        self._pairs = np.array(pairs, dtype=np.intp).reshape(-1, 2)
        self._near = np.where(np.arange(len(pairs)) < own, NEAR, OWN_NEAR)
        self._bodies = _Bodies(self._arm, (*body, *obstacles))

    def near(self, arm: Arm, q: Array, v: Array, time: float) -> Nearness | None:
        """Rows of the pairs that are near; None where none are.

        Parameters
        ----------
        arm : Arm
            Of the same shape, whatever it carries.
        q, v : (n,), rad, rad/s
        time : float, s
        """
        if not len(self._pairs):
            return None
        bodies = self._bodies
        for k in self._moving:
            bodies.put(k, min(max(time - self._time, 0.0), FORESEEN))
        rotation, translation, jacobian = arm.joint_frames(q)
        velocity, acceleration = chain_motion(jacobian, v)
        place_links(bodies.local, bodies.joint, rotation, translation, bodies.ends, bodies.middle, bodies.rotation)
        moved = bodies.joint[: bodies.count]
        bodies.motion[: bodies.count, 0] = velocity[moved]
        bodies.motion[: bodies.count, 1] = acceleration[moved]
        return self._nearness(jacobian)

    def _candidates(self, jacobian: Array) -> list[tuple[list[int], float]]:
        """Pairs that may be near, and what near is, m; coal knows where their links are."""
        bodies = self._bodies
        balls = bodies.middle, bodies.reach
        strongest = strongest_accelerations(jacobian, bodies.joint, *balls, self._arm.limits.acceleration)
        near = distances_that_matter(
            self._pairs, *balls, bodies.motion, strongest, self._near, APPROACH, self.safe_distance
        )
        places = pairs_that_may_be_near(self._pairs, *balls, bodies.rotation, bodies.half, bodies.wrap, near)
        pairs: list[list[int]] = self._pairs[places].tolist()
        for k in {k for pair in pairs for k in pair if k < bodies.count}:
            bodies.turn(k)
        return list(zip(pairs, near[places].tolist(), strict=True))

    def _nearness(self, jacobian: Array) -> Nearness | None:
        shapes, places = self._bodies.shapes, self._bodies.places
        points, normals = np.empty((2, len(self._pairs), 3))
        pairs: list[tuple[int, int]] = []
        apart: list[float] = []
        for (i, k), near in self._candidates(jacobian):
            found, point, normal = nearest_points(shapes[i], places[i], shapes[k], places[k])
            if found < near:
                points[len(pairs)], normals[len(pairs)] = point, normal
                pairs.append((i, k))
                apart.append(found)
        if not pairs:
            return None
        distance, points, normals = np.array(apart), points[: len(pairs)], normals[: len(pairs)]
        rows, drift, rate = self._bodies.changes(np.array(pairs), distance, points, normals, jacobian)
        most = self._arm.limits.acceleration
        lower = least_rates(rows, drift, rate, distance, APPROACH, self.safe_distance, most)
        constraint = Constraint(rows, lower, np.full(len(lower), np.inf), soft=True)
        return Nearness(constraint, distance, pairs, self._bodies.names)


def _is_same(obstacle: Obstacle, before: Obstacle) -> bool:
    """Whether an obstacle is one that was watched before, wherever it is now."""
    return obstacle.name == before.name and obstacle.solid == before.solid


def _core(solid: Solid) -> tuple[float, float]:
    """Half the length of a solid's core segment, m, and its radius, m; (half the diagonal, 0) of a flat-sided one."""
    match solid:
        case Sphere(radius):
            return 0.0, radius
        case Capsule(radius, length):
            return 0.5 * length, radius
        case _:
            return float(np.linalg.norm(_half_lengths(solid))), 0.0


def _half_lengths(solid: Solid) -> tuple[float, float, float]:
    """Half the lengths of the box around a flat-sided solid, m."""
    match solid:
        case Box((x, y, z)):
            return 0.5 * x, 0.5 * y, 0.5 * z
        case Cylinder(radius, height):
            return radius, radius, 0.5 * height
        case _:
            return 0.0, 0.0, 0.0
