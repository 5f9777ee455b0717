"""The take-over policy: when belief is enough, when to ask, and when to decline.

The robot takes over a motion that has been likely for a while, without a break. Where two stay close for long, or the
motion is nearly over and still in doubt, it asks which of the two. Where the motion is probably none that it knows, it
declines. A motion that is only a little likely is never taken over without asking.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pft_exec.exceptions import ControlError
from pft_exec.recognition.belief import Belief

Kind = Literal["wait", "take_over", "ask", "decline"]


@dataclass(frozen=True)
class Decision:
    """What to do now.

    Parameters
    ----------
    kind : "wait", "take_over", "ask" or "decline"
    labels : tuple of str
        The motion to take over; the two motions to ask about, more probable first; the most probable one otherwise.
    reason : str
        For people to read.
    time : float, s
        Of the belief that it follows.
    """

    kind: Kind
    labels: tuple[str, ...]
    reason: str
    time: float

    @property
    def label(self) -> str:
        """The first of `labels`."""
        return self.labels[0]


@dataclass(frozen=True)
class PolicySettings:
    """When to take over, ask and decline.

    Parameters
    ----------
    threshold : float
        Probability that a motion must have to be taken over.
    hold_time : float, s
        For which it must have had it, without a break.
    unknown_limit : float
        Probability of an unknown motion above which nothing is taken over.
    least_time, least_phase : float, s, and in [0, 1]
        Evidence that must have been seen: time since the first sample, and the motion's phase. A person's first third
        may point at another object than they mean; waiting for more costs little, a wrong take-over much.
    ask_margin : float
        Probability that the second motion must have for the two to be close.
    ask_time : float, s
        For which they must have been close before the robot asks.
    ask_phase : float
        Phase from which it asks at once, as long as the two are close.

    Raises
    ------
    ControlError
        If a probability or a time is none.
    """

    threshold: float = 0.98
    hold_time: float = 0.25
    unknown_limit: float = 0.65
    least_time: float = 0.5
    least_phase: float = 0.4
    ask_margin: float = 0.1
    ask_time: float = 1.0
    ask_phase: float = 0.7

    def __post_init__(self) -> None:
        shares = {"threshold": self.threshold, "unknown_limit": self.unknown_limit, "ask_margin": self.ask_margin}
        for name, value in shares.items():
            if not 0.0 < value < 1.0:
                raise ControlError(f"{name} must be a probability above 0 and below 1; got {value}.")
        times = {"hold_time": self.hold_time, "ask_time": self.ask_time, "least_time": self.least_time}
        for name, value in times.items():
            if not value >= 0.0:
                raise ControlError(f"{name} must be a time of at least 0 s; got {value}.")


class TakeoverPolicy:
    """Decide, belief by belief.

    Parameters
    ----------
    settings : PolicySettings
    """

    def __init__(self, settings: PolicySettings | None = None) -> None:
        self.settings = settings or PolicySettings()
        self.reset()

    def reset(self) -> None:
        """Forget everything: a new motion begins."""
        self._likely: tuple[str, float] | None = None
        self._close: tuple[frozenset[str], float] | None = None
        self._unknown_since: float | None = None
        self._answer: str | None = None
        self._refused: set[frozenset[str]] = set()

    def answer(self, label: str | None) -> None:
        """Take the person's answer to a question: a label, or None for neither; the same pair is not asked again."""
        self._answer = label
        if self._close is not None:
            self._refused.add(self._close[0])

    def update(self, belief: Belief, time: float | None = None) -> Decision:
        """Decide after a belief.

        Parameters
        ----------
        belief : Belief
        time : float or None, s
            Now; None is the belief's own time.
        """
        now = belief.time if time is None else time
        ranked = sorted(belief.probability, key=lambda label: -belief.probability[label])
        if self._answer is not None:
            return Decision("take_over", (self._answer,), f"the person said {self._answer!r}", now)
        if belief.flagged:
            return Decision("wait", (belief.label,), f"the sample was left out: {belief.flagged}", now)
        self._remember(belief, ranked, now)
        return self._decision(belief, ranked, now)

    def _remember(self, belief: Belief, ranked: list[str], now: float) -> None:
        """Note since when the first has been likely, the first two close, and the motion unknown."""
        limit, best = self.settings, ranked[0]
        known = belief.unknown <= limit.unknown_limit
        self._unknown_since = None if known else _since(self._unknown_since, now)
        likely = known and belief.probability[best] >= limit.threshold
        kept = self._likely[1] if self._likely is not None and self._likely[0] == best else None
        self._likely = (best, _since(kept, now)) if likely else None
        pair = frozenset(ranked[:2])
        close = known and len(ranked) > 1 and belief.probability[ranked[1]] >= limit.ask_margin
        kept = self._close[1] if self._close is not None and self._close[0] == pair else None
        self._close = (pair, _since(kept, now)) if close else None

    def _decision(self, belief: Belief, ranked: list[str], now: float) -> Decision:
        limit, best = self.settings, ranked[0]
        share = belief.probability[best]
        if self._unknown_since is not None and now - self._unknown_since >= limit.hold_time and now >= limit.least_time:
            return Decision("decline", (best,), f"probably none of the motions ({belief.unknown:.0%})", now)
        enough = now >= limit.least_time and belief.phase.get(best, 1.0) >= limit.least_phase
        if enough and self._likely is not None and now - self._likely[1] >= limit.hold_time:
            return Decision(
                "take_over", (best,), f"{best!r} has been likely for {limit.hold_time:g} s ({share:.1%})", now
            )
        if enough and self._has_question(belief, best, now):
            second = ranked[1]
            reason = f"{best!r} ({share:.0%}) and {second!r} ({belief.probability[second]:.0%}) are close"
            return Decision("ask", (best, second), reason, now)
        return Decision("wait", (best,), f"{best!r} leads with {share:.0%}", now)

    def _has_question(self, belief: Belief, best: str, now: float) -> bool:
        if self._close is None or self._close[0] in self._refused:
            return False
        late = belief.phase.get(best, 0.0) >= self.settings.ask_phase
        return late or now - self._close[1] >= self.settings.ask_time


def _since(before: float | None, now: float) -> float:
    return now if before is None else before
