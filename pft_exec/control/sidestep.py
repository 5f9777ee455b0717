r"""The sidestep: on which side of an obstacle to pass, chosen ahead of the encounter, where the tube is wide.

Rows on the distance keep an arm off whatever comes, but they see only the present: before a ball that crosses the tube
the arm flees, although a step to the other side would have let it pass. So the coming seconds are looked at. With
:math:`S(t)` the deviation of the tube, the symmetric root of its position's covariance at given orientation, and e the
tool's present error, each candidate u, a sidestep counted in deviations, leads the tool along

.. math:: x(\tau) = x_{ref}(\tau) + (1 - f(\tau))\, S(\tau)\, u + f(\tau)\, e, \qquad
          f(\tau) = (1 + a \tau + \tfrac12 a^2 \tau^2)\, e^{-a \tau} ,

and the links with it, to first order. Obstacles move on at their velocities. The candidate of least

.. math:: u^T u + \kappa \lVert u - u_{now} \rVert^2 + \sum_\tau \max(0, d_r - d(\tau))^2 / d_s^2

is taken: the first term is the tube's own measure of what a step costs, the second keeps a choice that is as good as
another, and the third is what a path lacks of the room d_r; a path that changes sides through the obstacle lacks much,
so sides are changed only where there is still time. The step follows its choice with three equal poles at -a, so that
the target's acceleration never jumps, and it shifts the tracking's target: gains, weights, rows and limits stay what
they are. Where nothing comes near, nothing is shifted. Derivation ours.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from pft_exec.control.compliance import Compliance
from pft_exec.control.reference import JointReference
from pft_exec.control.sidestep_kernel import carried_ends, follow_choice, judge_steps, places_of, spread_of
from pft_exec.control.tool_kernel import matrix_of
from pft_exec.geometry import Array
from pft_exec.model import Arm, Box, Capsule, Cylinder, Obstacle, Solid, Sphere

INSTANTS, INTERVAL = 24, 0.125
"""So many instants, s apart, are looked at: three seconds. A ball of 0.3 m/s moves by its radius in between."""
LOOK_PERIOD = 0.006
"""s between the looks at two instants: a choice is made anew every 0.14 s, and most control periods pay nothing."""
POLE = 8.0
"""1/s; a: a step is done within 0.7 s, which gains of a wide tube follow."""
ROOM = 0.03
"""m; d_r: where the rows' approach ends. A step that leaves so much is never pushed on by them."""
SHORT = 0.005
"""m; d_s: lacking this much of the room at one instant costs as much as a step of one deviation."""
LOYALTY = 0.1
"""kappa."""
LARGEST, COARSE = 3.0, 0.5
"""Deviations: of the largest step, and between candidates."""
FINE = (0.05, 0.1, 0.25)
"""Deviations by which the last choice is improved along each axis."""
NARROW, NARROWER = 0.01, 1.0 / 3.0
"""m, and share of the widest axis: what is narrower than either is no room to step aside."""

Ahead = Callable[[float], JointReference]
"""From a time, s, to where the reference will be then, as far as it is known."""
Shift = tuple[Array, Array, Array]
"""Of the tool's target, (3,) each, base frame: m, m/s, m/s^2."""


@dataclass(frozen=True, eq=False)
class _Crowd:
    """K obstacles as they were at a time, s.

    Parameters
    ----------
    time : float, s
    started : (K, 3), m, (K, 3, 3) and (K, 6), m/s and rad/s
        Positions, rotations and velocities.
    half : (K,), m
        Half the core segments.
    rounding : (K,), m
        Zero of flat-sided ones.
    box : (K, 3), m
        Half lengths of flat-sided ones.
    """

    time: float
    started: tuple[Array, Array, Array]
    half: Array
    rounding: Array
    box: Array


class Sidestep:
    """Chooses and carries out steps aside of one arm.

    Parameters
    ----------
    arm : Arm
    moved : sequence of int
        Which of the arm's links count.
    """

    def __init__(self, arm: Arm, moved: Sequence[int]) -> None:
        links = [arm.geometry.links[i] for i in moved]
        self._arm = arm
        self._local = np.array([[link.start, link.end] for link in links])
        self._radius = np.array([link.radius for link in links])
        self._joint = np.array([link.joint for link in links], dtype=np.intp)
        shape = 1, len(links), 2, 3
        self._ends, self._carried = np.zeros(shape), np.zeros((*shape, 3))
        self._seen, self._first, self._due = 0, 0.0, -np.inf
        self._steps, self._lacking = np.zeros((1, 3)), np.zeros(1)
        self._crowd = _crowd((), 0.0)
        self.wanted = np.zeros(3)
        """Step, deviations, that was chosen last."""
        self._follows = np.zeros((3, 3))

    def watch(self, obstacles: Sequence[Obstacle], time: float) -> None:
        """Step aside of these obstacles, base frame, as they are at a time, s, from now on."""
        self._crowd = _crowd(obstacles, time)

    def update(
        self, time: float, period: float, phase: float, error: Array, compliance: Compliance, ahead: Ahead
    ) -> Shift | None:
        """Shift of the tool's target; None where there is none.

        Parameters
        ----------
        time, period : float, s
        phase : float
            Where along the compliance's tube the reference is.
        error : (3,), m
            Of the measured tool from the reference, base frame.
        compliance : Compliance
        ahead : Ahead
        """
        if not len(self._crowd.half):
            self.wanted, self._seen, self._due = np.zeros(3), 0, -np.inf
        elif time >= self._due - 0.5 * period:
            self._due = time + LOOK_PERIOD
            self._look(time, phase, error, compliance, ahead)
        shift = np.empty((3, 3))
        is_aside = follow_choice(self.wanted, self._follows, POLE, period, compliance.deviation, phase, shift)
        return (shift[0], shift[1], shift[2]) if is_aside else None

    def _look(self, time: float, phase: float, error: Array, compliance: Compliance, ahead: Ahead) -> None:
        """Judge every candidate at one more instant of what comes; when all are seen, choose."""
        if self._seen == 0:
            self._first = time
            self._steps = self._candidates(_widths(compliance, phase))
            self._lacking = np.zeros(len(self._steps))
        instant = self._first + self._seen * INTERVAL
        passed = POLE * max(instant - self._first - INSTANTS * LOOK_PERIOD, 0.0)  # since the choice that is to come
        fading = (1.0 + passed + 0.5 * passed**2) * np.exp(-passed)
        self._lacking += self._lack(instant, fading, error, compliance, ahead(instant))
        self._seen = (self._seen + 1) % INSTANTS
        if self._seen == 0:
            self._choose()

    def _lack(
        self, instant: float, fading: float, error: Array, compliance: Compliance, reference: JointReference
    ) -> Array:
        """What each candidate lacks of its room at an instant, s, where the reference will be there, m^2."""
        frames = self._arm.joint_frames(reference.configuration)
        jacobian = self._arm.kinematics(reference.configuration)[2]
        carried_ends(self._local, self._joint, frames, jacobian, self._ends[0], self._carried[0])
        crowd, spread = self._crowd, spread_of(compliance.deviation, reference.phase)
        ends, rotations = places_of(crowd.started, crowd.half, np.array([instant - crowd.time]))
        arm = self._ends, self._carried, self._radius
        others = ends, rotations, crowd.rounding, crowd.box
        lacking: Array = judge_steps(self._steps, arm, spread[None], np.array([fading]), error, others, ROOM)
        return lacking

    def _choose(self) -> None:
        steps, changes = self._steps, self._steps - self.wanted
        cost = np.einsum("ci,ci->c", steps, steps) + LOYALTY * np.einsum("ci,ci->c", changes, changes)
        self.wanted = steps[int(np.argmin(cost + self._lacking / SHORT**2))]

    def _candidates(self, square: Array) -> Array:
        """Steps (C, 3), deviations: none, the last choice and what is near it, and all along wide axes and between.

        `square` (3, 3), m^2, is the mean of the deviations' squares ahead.
        """
        variance, axes = np.linalg.eigh(square)
        widest = float(np.sqrt(variance[-1]))
        wide = axes[:, np.sqrt(np.maximum(variance, 0.0)) >= max(NARROW, NARROWER * widest)]
        if not wide.shape[1]:
            return np.zeros((1, 3))
        signs = np.array([s for s in product((-1.0, 0.0, 1.0), repeat=wide.shape[1]) if any(s)])
        directions = signs @ wide.T / np.linalg.norm(signs, axis=1)[:, None]
        sizes = np.arange(COARSE, LARGEST + 0.5 * COARSE, COARSE)
        kept = wide @ (wide.T @ self.wanted)
        changes = np.concatenate([sign * size * wide.T for sign in (-1.0, 1.0) for size in FINE])
        coarse = (sizes[:, None, None] * directions).reshape(-1, 3)
        steps = np.concatenate([np.zeros((1, 3)), kept[None], kept + changes, coarse])
        return np.ascontiguousarray(steps[np.linalg.norm(steps, axis=1) <= LARGEST + 1e-9])


def _widths(compliance: Compliance, phase: float) -> Array:
    """Mean (3, 3), m^2, of the squares of a tube's deviations from a phase on."""
    ahead = compliance.deviation[min(int(phase * len(compliance.time)), len(compliance.time) - 1) :]
    mean: Array = np.einsum("nij,njk->ik", ahead, ahead) / len(ahead)
    return mean


def _crowd(obstacles: Sequence[Obstacle], time: float) -> _Crowd:
    cores = [_core(obstacle.solid) for obstacle in obstacles]
    started = (
        np.array([obstacle.pose.position for obstacle in obstacles]).reshape(-1, 3),
        np.array([matrix_of(obstacle.pose.quaternion) for obstacle in obstacles]).reshape(-1, 3, 3),
        np.array([obstacle.velocity for obstacle in obstacles]).reshape(-1, 6),
    )
    half, rounding = np.array([core[0] for core in cores]), np.array([core[1] for core in cores])
    return _Crowd(time, started, half, rounding, np.array([core[2] for core in cores]).reshape(-1, 3))


def _core(solid: Solid) -> tuple[float, float, tuple[float, float, float]]:
    """Half a solid's core segment, its rounding, and half the lengths of the box that a flat-sided one counts as, m."""
    match solid:
        case Sphere(radius):
            return 0.0, radius, (0.0, 0.0, 0.0)
        case Capsule(radius, length):
            return 0.5 * length, radius, (0.0, 0.0, 0.0)
        case Cylinder(radius, height):
            return 0.0, 0.0, (radius, radius, 0.5 * height)
        case Box((x, y, z)):
            return 0.0, 0.0, (0.5 * x, 0.5 * y, 0.5 * z)
