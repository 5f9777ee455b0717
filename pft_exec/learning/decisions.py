"""From demonstrations to motion variables: weigh the frames at both ends, decide, and say why in words.

In the flow: called once per motion by `pft_exec.learning.motion.learn_motion`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import fdtrc

from pft_exec.demonstration import Demonstration
from pft_exec.learning.frames import (
    Candidate,
    object_names,
    object_poses,
    orientation_candidates,
    position_candidates,
    tool_poses,
)
from pft_exec.learning.relevance import TURN_EXTENT, Evidence, choose_frame, weigh_frames
from pft_exec.learning.variables import ABSOLUTE, ENDS, NONE, EndDecision, FrameDecision, MotionVariables

NEAR = 0.4  # of the extent: an object the tool ended (started) closer to than this is what the motion is about


def motion_extent(demonstrations: Sequence[Demonstration]) -> float:
    """Median diagonal of the box around a demonstrated path, m."""
    return float(np.median([np.linalg.norm(np.ptp(d.position, axis=0)) for d in demonstrations]))


def _best(candidates: Sequence[Candidate], evidence: Evidence, name: str) -> Candidate:
    """The candidate of that name whose kind of axes explains more; the world's axes win a draw."""
    rated = [(p, c) for p, c in zip(evidence.posterior, candidates, strict=False) if c.name == name]
    world = next(((p, c) for p, c in rated if c.axes == "world"), None)
    best = max(rated, key=lambda pair: float(pair[0]))
    return best[1] if world is None or best[0] > 3.0 * world[0] else world[1]


def _spreads(candidates: Sequence[Candidate]) -> dict[str, float]:
    spreads: dict[str, float] = {}
    for c in candidates:
        spreads[c.name] = min(spreads.get(c.name, np.inf), c.spread)
    return dict(sorted(spreads.items(), key=lambda item: item[1]))


def _kinds(candidates: Sequence[Candidate], evidence: Evidence) -> dict[str, str]:
    """Axes of each candidate: those that explain more."""
    return {name: _best(candidates, evidence, name).axes for name in dict.fromkeys(c.name for c in candidates)}


def _reason(name: str, rivals: tuple[str, ...], spreads: dict[str, float], unit: str) -> str:
    listed = ", ".join(f"{n} {s:.3g} {unit}" for n, s in spreads.items())
    words = "nothing holds it: every spread is wide" if name == NONE else f"{name} explains it best"
    if rivals:
        words += f"; the demonstrations do not tell it from {', '.join(r or 'none' for r in rivals)}"
    return f"{words} (spreads: {listed})"


def decide(
    candidates: Sequence[Candidate], evidence: Evidence, near: float, unit: str, forced: str | None
) -> FrameDecision:
    """One decision, with its numbers; `forced` is the frame that the user named, or None."""
    name, possible = choose_frame(evidence, near)
    rivals = possible[1:]
    if forced is not None:
        name, rivals = forced, ()
    spreads = _spreads(candidates)
    chosen = _best(candidates, evidence, ABSOLUTE if name == NONE else name)
    others = [s for n, s in spreads.items() if n != name]
    ratio = (min(others) / max(chosen.spread, 1e-12)) ** 2 if others and name != NONE else 1.0
    degrees = 3 * max(len(chosen.residual) - 1, 1)
    return FrameDecision(
        frame=name,
        axes=chosen.axes,
        offset=chosen.offset,
        spread=chosen.spread,
        candidates=spreads,
        probability=evidence.by_name(),
        variance_ratio=ratio,
        p_value=float(fdtrc(degrees, degrees, ratio)),
        ambiguous=bool(rivals),
        reason=_reason(name, rivals, spreads, unit),
        relevant=(name,) if name != NONE else (),
        overruled=forced is not None,
        kinds=_kinds(candidates, evidence),
    )


def _channel(
    demonstrations: Sequence[Demonstration], channel: str, extent: float, forced: dict[str, str | None]
) -> dict[str, FrameDecision]:
    starts, ends = tool_poses(demonstrations, 0), tool_poses(demonstrations, -1)
    objects = {name: object_poses(demonstrations, name) for name in object_names(demonstrations)}
    if channel == "position":
        turned = demonstrations[0].quaternion is not None
        candidates = [
            position_candidates(starts, None, objects, turned),
            position_candidates(ends, starts, objects, turned),
        ]
        near, unit = NEAR * extent, "m"
    else:
        candidates = [orientation_candidates(starts, None, objects), orientation_candidates(ends, starts, objects)]
        extent, near, unit = TURN_EXTENT, 0.0, "rad"
    weighed = weigh_frames(candidates, extent)
    return {end: decide(candidates[i], weighed[i], near, unit, forced.get(end)) for i, end in enumerate(ENDS)}


def find_variables(demonstrations: Sequence[Demonstration], forced: dict[str, str | None]) -> MotionVariables:
    """Decide the motion variables of K demonstrations of one motion.

    Parameters
    ----------
    demonstrations : K of one label
    forced : {"start" or "end": frame}
        What the user names in place of the decision for position.
    """
    extent = max(motion_extent(demonstrations), 1e-9)
    position = _channel(demonstrations, "position", extent, forced)
    if demonstrations[0].quaternion is None:
        return MotionVariables(EndDecision(position["start"]), EndDecision(position["end"]))
    orientation = _channel(demonstrations, "orientation", extent, {})
    return MotionVariables(
        EndDecision(position["start"], orientation["start"]), EndDecision(position["end"], orientation["end"])
    )
