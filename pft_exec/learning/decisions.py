"""From demonstrations to motion variables: weigh the frames at both ends, decide, and say why in words.

In the flow: called once per motion by `pft_exec.learning.motion.learn_motion`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from scipy.special import fdtrc

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array
from pft_exec.learning.carrying import carried_objects
from pft_exec.learning.directions import split_directions
from pft_exec.learning.frames import (
    Candidate,
    object_names,
    object_poses,
    orientation_candidates,
    partly_recorded,
    position_candidates,
    tool_poses,
)
from pft_exec.learning.relevance import DECISIVE, FLOOR, TURN_EXTENT, TURN_SCATTER, Evidence, choose_frame, weigh_frames
from pft_exec.learning.signals import signal_ends
from pft_exec.learning.variables import ABSOLUTE, ENDS, NONE, START, EndDecision, FrameDecision, MotionVariables

NEAR = 0.4  # of the extent: an object the tool ended (started) closer to than this is what the motion is about
LEVER = 3.0  # spreads: a level offset longer than this makes the axes it is meant in matter
AXES_ODDS = 3.0  # how much likelier an object's own axes must be than the world's

ENOUGH = 3  # demonstrations that decide what an object which others lack is to the motion
CHAIN = 2.0  # times the spread that start and end add up to, within which the frame of the start also holds the end

Overrules = Mapping[str, Sequence[str]]  # "end", "start", "end.orientation", ... -> names of frames


def motion_extent(demonstrations: Sequence[Demonstration]) -> float:
    """Median diagonal of the box around a demonstrated path, m."""
    return float(np.median([np.linalg.norm(np.ptp(d.position, axis=0)) for d in demonstrations]))


def _best(candidates: Sequence[Candidate], evidence: Evidence, name: str) -> Candidate:
    """The candidate of that name whose kind of axes explains more; the world's axes win a draw."""
    rated = [(float(p), c) for p, c in zip(evidence.posterior, candidates, strict=False) if c.name == name]
    world = next(((p, c) for p, c in rated if c.axes == "world"), None)
    best = max(rated, key=lambda pair: pair[0])
    return best[1] if world is None or best[0] > AXES_ODDS * world[0] else world[1]


def _spreads(candidates: Sequence[Candidate]) -> dict[str, float]:
    spreads: dict[str, float] = {}
    for c in candidates:
        spreads[c.name] = min(spreads.get(c.name, np.inf), c.spread)
    return dict(sorted(spreads.items(), key=lambda item: item[1]))


def _reason(
    name: str, rivals: Sequence[str], spreads: Mapping[str, float], unit: str, directions: Sequence[str]
) -> str:
    listed = ", ".join(f"{n} {s:.3g} {unit}" for n, s in spreads.items())
    words = "nothing holds it: every spread is wide" if name == NONE else f"{name} explains it best"
    if directions:
        words = "no single frame explains it: x, y, z are held by " + ", ".join(directions)
    if rivals:
        words += f"; the demonstrations do not tell it from {', '.join(r or 'none' for r in rivals)}"
    return f"{words} (spreads: {listed})"


def _decide(
    candidates: Sequence[Candidate],
    evidence: Evidence,
    extent: float,
    unit: str,
    forced: Sequence[str] | None,
) -> FrameDecision:
    """One decision, with its numbers; `forced` are the frames that the user named, or None."""
    name, possible = choose_frame(evidence, NEAR * extent if unit == "m" else 0.0)
    rivals = possible[1:]
    if forced is not None:
        name, rivals = (forced[0] if forced else NONE), ()
    spreads = _spreads(candidates)
    chosen = _best(candidates, evidence, ABSOLUTE if name == NONE else name)
    directions: tuple[str, ...] = ()
    if forced is None and unit == "m":
        directions = split_directions(chosen, candidates, extent, FLOOR * extent)
    if directions:
        name, rivals = max(set(directions), key=lambda n: (directions.count(n), n != ABSOLUTE, n)), ()
        chosen = next(c for c in candidates if c.name == name and c.axes == "world")
    relevant = tuple(dict.fromkeys((name, *directions, *(forced or ())))) if name != NONE else ()
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
        reason=_reason(name, rivals, spreads, unit, directions),
        relevant=relevant,
        rivals=tuple(r for r in rivals if r != NONE),
        overruled=forced is not None,
        directions=directions,
        kinds={n: _best(candidates, evidence, n).axes for n in dict.fromkeys(c.name for c in candidates)},
    )


def _are_told_apart(evidence: Evidence, name: str) -> bool:
    """Whether the two kinds of axes of a frame differ in how likely they are."""
    odds = {c.axes: float(p) for p, c in zip(evidence.posterior, evidence.candidates, strict=False) if c.name == name}
    return max(odds.values()) > AXES_ODDS * min(odds.values())


def _with_turn(decision: FrameDecision, objects: Collection[str], evidence: Evidence) -> FrameDecision:
    """The decision, its offset turning with an object that always stood much the same way: then nobody can know."""
    if decision.frame not in objects or decision.directions:
        return decision
    level = float(np.linalg.norm(decision.offset[:2]))
    if level <= LEVER * decision.spread or _are_told_apart(evidence, decision.frame):
        return decision
    own = next(c for c in evidence.candidates if c.name == decision.frame and c.axes == "object")
    words = (
        f"; {decision.frame} always stood much the same way: whether the offset turns with it is not shown, "
        "it is taken to"
    )
    return decision.changed(
        axes="object",
        offset=own.offset,
        ambiguous=not decision.overruled,
        reason=decision.reason + words,
        kinds={**decision.kinds, decision.frame: "object"},
    )


def _chained(start: FrameDecision, end: FrameDecision, candidates: Sequence[Candidate]) -> FrameDecision:
    """The decision at the end, where the start is tied to a frame: what is then tied to the start is tied to it too.

    A closed motion that begins over a cup ends over the cup; no demonstration could tell the two apart, and a new scene
    need not. The world's frame says so of orientations only: a motion that always began in one place may go anywhere.
    """
    name = start.frame
    if name in (NONE, START) or end.frame not in (name, START) or end.overruled or end.directions:
        return end
    own = next((c for c in candidates if c.name == name and c.axes == end.kinds.get(name)), None)
    wide = CHAIN * float(np.hypot(start.spread, end.spread))
    if own is None or (end.frame == START and own.spread > wide):
        return end
    rivals = tuple(r for r in end.rivals if r not in (START, name))
    reason = end.reason if end.frame == name else f"{end.reason}; the start is tied to {name}, so the end is"
    return end.changed(
        frame=name,
        axes=own.axes,
        offset=own.offset,
        spread=own.spread,
        relevant=(name,),
        rivals=rivals,
        ambiguous=bool(rivals) or end.probability.get(NONE, 0.0) > 1.0 - DECISIVE,
        reason=reason,
    )


def _positions(
    demonstrations: Sequence[Demonstration], poses: Mapping[str, Array], overrules: Overrules
) -> list[FrameDecision]:
    starts, ends = tool_poses(demonstrations, 0), tool_poses(demonstrations, -1)
    turned = demonstrations[0].quaternion is not None
    extent = max(motion_extent(demonstrations), 1e-9)
    candidates = [position_candidates(starts, None, poses, turned), position_candidates(ends, starts, poses, turned)]
    evidence = weigh_frames(candidates, extent)
    decisions = [
        _decide(c, e, extent, "m", overrules.get(end)) for c, e, end in zip(candidates, evidence, ENDS, strict=True)
    ]
    if decisions[0].frame != ABSOLUTE:
        decisions[1] = _chained(decisions[0], decisions[1], candidates[1])
    return [_with_turn(d, poses, e) for d, e in zip(decisions, evidence, strict=True)]


def _orientations(
    demonstrations: Sequence[Demonstration],
    poses: Mapping[str, Array],
    places: Sequence[FrameDecision],
    overrules: Overrules,
) -> list[FrameDecision]:
    starts, ends = tool_poses(demonstrations, 0), tool_poses(demonstrations, -1)
    candidates = [orientation_candidates(starts, None, poses), orientation_candidates(ends, starts, poses)]
    near = [{*place.relevant, *place.rivals} for place in places]
    evidence = weigh_frames(candidates, TURN_EXTENT, TURN_SCATTER, near)
    start, end = (
        _decide(c, e, TURN_EXTENT, "rad", overrules.get(f"{end}.orientation"))
        for c, e, end in zip(candidates, evidence, ENDS, strict=True)
    )
    return [start, _chained(start, end, candidates[1])]


def without_incomplete(
    demonstrations: Sequence[Demonstration], overrules: Overrules
) -> tuple[list[Demonstration], tuple[str, ...]]:
    """The demonstrations that have every object which an end is tied to, and such objects that some others lack.

    A tracker that lost the object in one of five demonstrations leaves four that show what the motion is about; with
    all five, an object that happened to stand near it would explain the end best. An object counts so where most
    demonstrations have it, `ENOUGH` at least, and a decision of these is not ambiguous.
    """
    kept = list(demonstrations)
    lacking: list[str] = []
    for name in partly_recorded(demonstrations):
        having = [d for d in kept if name in d.objects]
        if len(having) < max(ENOUGH, len(demonstrations) // 2 + 1) or len(having) == len(kept):
            continue
        variables = find_variables(having, overrules)
        decided = [d for end in (variables.start, variables.end) for d in (end.position, end.orientation) if d]
        if any(decision.frame == name and not decision.ambiguous for decision in decided):
            kept = having
            lacking.append(name)
    return kept, tuple(lacking)


def find_variables(demonstrations: Sequence[Demonstration], overrules: Overrules) -> MotionVariables:
    """Decide the motion variables of K demonstrations of one motion.

    Parameters
    ----------
    demonstrations : K of one label
    overrules : {"start", "end", "start.orientation" or "end.orientation": names of frames}
        What the user names in place of a decision; empty where nothing shall be relevant.
    """
    held = set(carried_objects(demonstrations, from_start=True)).difference(*overrules.values())
    names = [name for name in object_names(demonstrations) if name not in held]
    poses = {name: object_poses(demonstrations, name) for name in names}
    start, end = _positions(demonstrations, poses, overrules)
    turns: list[FrameDecision | None] = [None, None]
    if demonstrations[0].quaternion is not None:
        turns = [*_orientations(demonstrations, poses, (start, end), overrules)]
    continuous, discrete = signal_ends(demonstrations)
    return MotionVariables(
        EndDecision(start, turns[0]), EndDecision(end, turns[1]), carried_objects(demonstrations), continuous, discrete
    )
