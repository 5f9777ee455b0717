"""Motion variables in words: the table of decisions that a reader sees."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.geometry import Array
from pft_exec.learning.frames import partly_recorded
from pft_exec.learning.variables import ABSOLUTE, CHANNELS, ENDS, NONE, START, FrameDecision, MotionVariables, Passage

_HERE = 0.005  # m: what is nearer is said to be at the object, for its distance would be printed as 0.00 m


def _length(value: float) -> str:
    return f"{1000.0 * value:.0f} mm" if value < 0.995 else f"{value:.2f} m"


def _amount(value: float, channel: str) -> str:
    return _length(value) if channel == "position" else f"{np.degrees(value):.1f} deg"


def _where(offset: Array) -> str:
    """A direction in words, in the axes of the offset: front is -x, as seen from a robot that looks along x."""
    words = (("behind", "in front of"), ("left of", "right of"), ("above", "below"))
    axis = int(np.argmax(np.abs(offset)))
    return words[axis][int(offset[axis] < 0)]


def _relation(decision: FrameDecision, channel: str, end: str) -> str:
    verb = "starts" if end == "start" else "ends"
    if decision.frame == NONE:
        return f"{verb} anywhere" if channel == "position" else f"{verb} in any orientation"
    if channel == "orientation":
        words = {ABSOLUTE: "in a fixed orientation", START: "turned from its start"}
        return f"{verb} {words.get(decision.frame, f'turned with {decision.frame}')}"
    distance = float(np.linalg.norm(decision.offset))
    if decision.frame == ABSOLUTE:
        place = ", ".join(f"{x:.2f}" for x in decision.offset)
        return f"{verb} at the place ({place}) m"
    name = "its start" if decision.frame == START else decision.frame
    suffix = " (in its own axes)" if decision.axes == "object" else ""
    if distance < _HERE:
        return f"{verb} at {name}"
    return f"{verb} {distance:.2f} m {_where(decision.offset)} {name}{suffix}"


def sentence(label: str, decision: FrameDecision, channel: str, end: str) -> str:
    """One decision in words, such as "`reach` ends 0.12 m in front of bottle (spread 4 mm; absolute 140 mm)"."""
    rivals = [(n, s) for n, s in decision.candidates.items() if n != decision.frame]
    numbers = [f"spread {_amount(decision.spread, channel)}"] if decision.frame != NONE else []
    numbers += [f"{name} {_amount(spread, channel)}" for name, spread in rivals[:3]]
    text = f"`{label}` {_relation(decision, channel, end)} ({'; '.join(numbers)})"
    if decision.overruled:
        text += ", overruled by the user"
    return text + (f" - AMBIGUOUS: {decision.reason}" if decision.ambiguous else "")


def _passing(label: str, passage: Passage) -> str:
    """One passage in words, such as "`pour` passes 0.15 m above bowl (spread 9 mm; without bowl 90 mm)"."""
    distance = float(np.linalg.norm(passage.offset))
    suffix = " (in its own axes)" if passage.axes == "object" else ""
    where = "at" if distance < _HERE else f"{distance:.2f} m {_where(passage.offset)}"
    numbers = f"spread {_length(passage.spread)}; without {passage.name} {_length(passage.spread_without)}"
    text = f"`{label}` passes {where} {passage.name}{suffix} ({numbers})"
    return text + (f" - AMBIGUOUS: it may as well be {', '.join(passage.rivals)}" if passage.rivals else "")


def describe(label: str, variables: MotionVariables, demonstrations: Sequence[Demonstration] = ()) -> str:
    """All decisions of a motion, one line each, and which objects could not count."""
    lines = []
    for end in ENDS:
        for channel in CHANNELS:
            decision = getattr(getattr(variables, end), channel)
            if decision is not None:
                lines.append(sentence(label, decision, channel, end))
    lines += [_passing(label, passage) for passage in variables.passed]
    lines += [f"`{label}` carries {name}" for name in variables.carried]
    lines += [
        f"`{label}` was not asked about {name}: only {count} of {len(demonstrations)} demonstrations have it"
        for name, count in partly_recorded(demonstrations).items()
    ]
    return "\n".join(lines)
