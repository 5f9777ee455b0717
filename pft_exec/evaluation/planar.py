"""The planar world of [Dong2012]_, sections 6.1 and 6.2, with seeded synthetic people.

Ten by ten units: a red box, a green bin, and two fixed places x = (5, 5) and o = (5, 3), which are marks in the world
and no objects. In *varying scenes* box and bin lie elsewhere in each trial and there are three motions; in *one scene*
nothing moves between trials and there are seven. Every motion begins at the box.

How scattered the people are is not told by the paper. It is set once, so that the baseline of the paper (three states,
six shared Gaussians) comes within 8 points of the paper's own 55 % (varying scenes) and 78 % (one scene) at the end of
the motion: `PEOPLE`, the same people in both. Nothing else was looked at when it was set, and it was left alone since.
What bows, though, was put right: the straight legs of a motion. Loops and anchors had bowed as a whole, by a share of
their long way, so that three hands in four flew past one of their places; the README has the figures of both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.demonstration.synthetic import HumanStyle, human_path
from pft_exec.geometry import Array, Pose

PERIOD = 0.03  # s; a mouse or pen sampled at 33 Hz gives 30 to 200 samples a motion
SIZE = 10.0  # units; [Dong2012]_ prints no size, this follows from its figures
X = np.array([5.0, 5.0])
O = np.array([5.0, 3.0])  # noqa: E741 - the paper's name of the place

VARYING_MOTIONS = ("to bin", "left", "to x")
SCENE_MOTIONS = ("to bin", "left", "to x", "CW", "CCW", "anchor x, o", "anchor o, x")

BOX_IN_SCENE = np.array([3.0, 7.0])  # the positions of figure 6 are not printed; these are ours
BIN_IN_SCENE = np.array([8.0, 8.0])


@dataclass(frozen=True)
class Scatter:
    """How people differ from trial to trial, in units of the planar world; standard deviations.

    Parameters
    ----------
    start, goal : float
        Per axis, of where the hand takes hold and where it lets go.
    reach : float
        Of the logarithm of the length of "left".
    loop : float
        Of the logarithm of a loop's radius; its center and roundness scatter by half as much of the radius.
    bow : float
        Sideways deviation of a straight leg's middle, as a share of its length.
    pace : float
        Of the logarithm of the duration.
    pause_probability : float
    tremor : float
        Root mean square, per axis.
    """

    start: float
    goal: float
    reach: float
    loop: float
    bow: float
    pace: float
    pause_probability: float
    tremor: float

    @property
    def style(self) -> HumanStyle:
        """The part of it that belongs to the hand."""
        return HumanStyle(
            overlap=0.6,
            bow=self.bow,
            pace=self.pace,
            pause_probability=self.pause_probability,
            pause=(0.1, 0.5),
            tremor=self.tremor,
            end_error=0.0,
        )


PEOPLE = Scatter(start=0.3, goal=0.4, reach=0.2, loop=0.2, bow=0.12, pace=0.25, pause_probability=0.3, tremor=0.015)


def draw_scene(rng: np.random.Generator, clearance: float = 1.0) -> Scene:
    """Box and bin at random; box, bin and x lie at least `clearance` apart, as things one unit wide do."""
    while True:
        box, container = rng.uniform(1.0, SIZE - 1.0, (2, 2))
        gaps = [box - container, box - X, container - X]
        if min(float(np.linalg.norm(gap)) for gap in gaps) >= clearance:
            return _scene(box, container)


def fixed_scene() -> Scene:
    """The scene of the seven motions."""
    return _scene(BOX_IN_SCENE, BIN_IN_SCENE)


def _scene(box: Array, container: Array) -> Scene:
    return Scene({"box": Pose(np.append(box, 0.0)), "bin": Pose(np.append(container, 0.0))})


def perform(label: str, scene: Scene, rng: np.random.Generator, scatter: Scatter = PEOPLE) -> Demonstration:
    """Let a synthetic person perform one motion of the planar world in a scene."""
    box, container = scene["box"].position[:2], scene["bin"].position[:2]
    start = box + scatter.start * rng.standard_normal(2)
    waypoints = _waypoints(label, start, container, rng, scatter)
    lengths = np.linalg.norm(np.diff(waypoints, axis=0), axis=1)
    durations = 0.4 / len(lengths) + 0.25 * lengths  # s: short moves are slow for their length
    is_leg = len(waypoints) == 2  # the waypoints of other motions bow their legs already
    style = scatter.style if is_leg else replace(scatter.style, bow=0.0)
    path = human_path(_raised(waypoints), None, durations, rng, style, planar=True)
    time: Array = PERIOD * np.arange(int(np.ceil(path.duration / PERIOD)) + 1, dtype=float)
    position, _ = path.at(time)
    return Demonstration(
        label,
        time,
        position,
        objects={"box": _box_track(label, position, box), "bin": scene["bin"].array},
    )


def _raised(points: ArrayLike) -> Array:
    """Planar points (N, 2) as (N, 3) with z = 0."""
    points = np.asarray(points, dtype=float)
    return np.concatenate([points, np.zeros((len(points), 1))], axis=1)


def _waypoints(label: str, start: Array, container: Array, rng: np.random.Generator, scatter: Scatter) -> Array:
    goal = scatter.goal * rng.standard_normal(2)
    if label == "to bin":
        return np.stack([start, container + goal])
    if label == "to x":
        return np.stack([start, X + goal])
    if label == "left":
        length = np.exp(scatter.reach * rng.standard_normal())
        return np.stack([start, start + length * np.array([-1.0, 0.0]) + 0.3 * goal])
    if label in ("CW", "CCW"):
        center = start + np.array([0.0, -1.5])
        return _loop(start, center, 1.0 if label == "CCW" else -1.0, rng, scatter)
    places = (X, O) if label == "anchor x, o" else (O, X)
    first, second = (place + 0.5 * scatter.goal * rng.standard_normal(2) for place in places)
    return _anchor(start, first, second, rng, scatter)


def _loop(entry: Array, center: Array, turn: float, rng: np.random.Generator, scatter: Scatter) -> Array:
    """A full uneven turn about `center` from `entry` back to near it; `turn` 1 is counter-clockwise."""
    arm = entry - center
    shift = scatter.loop * 0.5 * np.linalg.norm(arm) * rng.standard_normal(2)
    angles = np.arctan2(arm[1], arm[0]) + turn * np.linspace(0.0, 2.0 * np.pi, 9)
    size = np.exp(scatter.loop * rng.standard_normal()) * np.linalg.norm(arm)
    radii = size * np.exp(0.5 * scatter.loop * rng.standard_normal(9))
    circle: Array = center + shift + radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    circle[0] = entry
    return circle


def _anchor(start: Array, first: Array, second: Array, rng: np.random.Generator, scatter: Scatter) -> Array:
    """A loop round one place, then round another, as a rope is laid round two posts."""
    pieces = [start[None]]
    for place, came_from in ((first, start), (second, first)):
        arm = came_from - place
        entry = place + 0.6 * np.exp(scatter.loop * rng.standard_normal()) * arm / np.linalg.norm(arm)
        pieces.append(_middle(pieces[-1][-1], entry, scatter.bow * rng.standard_normal())[None])
        pieces.append(_loop(entry, place, 1.0, rng, replace(scatter, loop=0.5 * scatter.loop)))
    return np.concatenate(pieces)


def _middle(begin: Array, end: Array, bow: float) -> Array:
    """Middle (2,) of a leg that bows to the left by a share of its length."""
    x, y = end - begin
    middle: Array = 0.5 * (begin + end) + bow * np.array([-y, x])
    return middle


def _box_track(label: str, position: Array, box: Array) -> Array:
    """The box goes with the hand in the motions that carry it, else it lies still; (N, 7) or (7,)."""
    if label not in VARYING_MOTIONS:
        return Pose(np.append(box, 0.0)).array
    track = position - position[0] + np.append(box, 0.0)
    return np.concatenate([track, np.tile([0.0, 0.0, 0.0, 1.0], (len(track), 1))], axis=1)


def varying_trials(seed: int, count: int = 50, scatter: Scatter = PEOPLE) -> list[Demonstration]:
    """`count` trials of each of the three motions, each in a scene of its own; [Dong2012]_, section 6.1: 50."""
    rng = np.random.default_rng([seed, 61])
    return [perform(label, draw_scene(rng), rng, scatter) for label in VARYING_MOTIONS for _ in range(count)]


def scene_trials(seed: int, count: int = 25, scatter: Scatter = PEOPLE) -> list[Demonstration]:
    """`count` trials of each of the seven motions in one scene; [Dong2012]_, section 6.2: 25."""
    rng = np.random.default_rng([seed, 62])
    return [perform(label, fixed_scene(), rng, scatter) for label in SCENE_MOTIONS for _ in range(count)]
