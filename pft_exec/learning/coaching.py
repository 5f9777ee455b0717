"""Coaching: what a teacher should know after some demonstrations, and what one more should show.

In the flow: ``motion.coach()`` after learning; nothing else depends on it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array, geodesic_distance
from pft_exec.learning.decisions import motion_extent
from pft_exec.learning.frames import object_names, object_poses, partly_recorded, tool_poses
from pft_exec.learning.variables import CHANNELS, ENDS, START, FrameDecision, MotionVariables

STANDS_OUT = 2.5  # times the median leave-one-out error of the others
UNVARIED = 0.1  # of the extent: an object (a start) moved less was always in the same place
UNTURNED = 0.1  # rad


@dataclass(frozen=True)
class Coaching:
    """Advice to a teacher.

    Parameters
    ----------
    errors : (K,) tuple of float, m
        Root mean square leave-one-out error of each demonstration.
    outlier : int or None
        The demonstration that stands out, if one does.
    uncovered : tuple of str
        What the placements do not cover.
    advice : tuple of str
        What one more demonstration should vary, most useful first.
    """

    errors: tuple[float, ...]
    outlier: int | None
    uncovered: tuple[str, ...]
    advice: tuple[str, ...]

    def __str__(self) -> str:
        """A few lines for the teacher."""
        lines = []
        if self.outlier is not None:
            error = 1000.0 * self.errors[self.outlier]
            lines.append(f"demonstration {self.outlier + 1} stands out: {error:.0f} mm from what the others predict")
        else:
            lines.append("no demonstration stands out")
        lines += [f"not covered: {text}" for text in self.uncovered]
        lines += [f"next: {text}" for text in self.advice]
        return "\n".join(lines)


def _outlier(errors: Array) -> int | None:
    """The demonstration whose error is far above those of the others; two cannot be told apart."""
    if len(errors) < 3:
        return None
    worst = int(np.argmax(errors))
    return worst if errors[worst] > STANDS_OUT * float(np.median(np.delete(errors, worst))) else None


def _gap(places: Array) -> Array:
    """The corner (3,) of the box around places (K, 3) that is farthest from all of them."""
    low, high = places.min(axis=0), places.max(axis=0)
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    distance = np.linalg.norm(corners[:, None] - places[None], axis=-1).min(axis=1)
    corner: Array = corners[int(np.argmax(distance))]
    return corner


def _uncovered(name: str, poses: Array, extent: float) -> tuple[list[str], list[str]]:
    """What is not covered of one object's placements (K, 7), and what to do about it."""
    found, advice = [], []
    spread = float(np.linalg.norm(np.ptp(poses[:, :3], axis=0)))
    if spread < UNVARIED * extent:
        found.append(f"{name} always stood in the same place (within {1000 * spread:.0f} mm)")
        advice.append(f"put {name} elsewhere, {0.5 * extent:.2f} m away or more")
    else:
        x, y, z = _gap(poses[:, :3])
        advice.append(f"put {name} near ({x:.2f}, {y:.2f}, {z:.2f}) m, the emptiest corner of its placements")
    if float(geodesic_distance(poses[:1, 3:], poses[:, 3:]).max()) < UNTURNED:
        found.append(f"{name} always stood the same way round")
        advice.append(f"turn {name}")
    return found, advice


def _ambiguities(variables: MotionVariables) -> list[str]:
    """What tells the frames of an ambiguous decision apart."""
    advice = []
    for end in ENDS:
        for channel in CHANNELS:
            decision: FrameDecision | None = getattr(getattr(variables, end), channel)
            if decision is None or not decision.rivals:
                continue
            names = ", ".join((decision.frame, *decision.rivals))
            advice.append(f"vary what tells {names} apart: the {end} {channel} may be tied to any of them")
    return advice


def coach(demonstrations: Sequence[Demonstration], variables: MotionVariables, residual: Array) -> Coaching:
    """Advice from leave-one-out residuals (K, N, 3 or 6) and the placements of K demonstrations."""
    errors = np.sqrt(np.mean(np.sum(residual[..., :3] ** 2, axis=-1), axis=1))
    extent = max(motion_extent(demonstrations), 1e-9)
    uncovered: list[str] = []
    advice = _ambiguities(variables)
    for name, count in partly_recorded(demonstrations).items():
        uncovered.append(f"only {count} of {len(demonstrations)} demonstrations have {name}, so it could not count")
        advice.append(f"record {name} in every demonstration, or teach without those that lack it")
    used = [name for name in object_names(demonstrations) if name in variables.objects]
    others = [name for name in object_names(demonstrations) if name not in used]
    for name in (*used, *others):
        found, ideas = _uncovered(name, object_poses(demonstrations, name), extent)
        uncovered += found
        advice += ideas if found or name in used else []
    starts = tool_poses(demonstrations, 0)[:, :3]
    if variables.start.position.frame == "" and np.linalg.norm(np.ptp(starts, axis=0)) < UNVARIED * extent:
        uncovered.append(f"the motion always began in the same place, which hides what is relative to the {START}")
        advice.append("begin elsewhere")
    return Coaching(tuple(float(e) for e in errors), _outlier(errors), tuple(uncovered), tuple(dict.fromkeys(advice)))
