"""An upper bound, not a competitor: a recognizer that knows how the people of the planar world move.

It is told what no recognizer is told, and what learning could only estimate: the law by which `planar` draws goals,
loops, bows, pace and pauses. It sees what all see: the scene, the first sample, and the samples so far. By the rule of
Bayes nobody who sees that much is right more often than the motion that is then most probable.

Two things are not as they are: tremor is taken to be white, which leaves its size but not its rhythm, and positions to
be read to `READING`. Read without any error, a few samples of a path that a formula draws would give away its end. So
the bound is that of recognizers which do not read the formula of the simulated hand out of its last digits.

For the motions of table 1 the searches share what they find, and the answers at the end are those of the goals' law in
closed form. Loops, above all anchors with their 35 chances, are searched alone, and about one trial in fifty is lost on
the way: over all of table 2 the figure is what such a recognizer reaches at least, and no row of that table.

Answers are computed after each twentieth of a recording and hold until the next; each knows the samples up to it alone.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pft_exec.demonstration import Demonstration
from pft_exec.evaluation import planar
from pft_exec.evaluation.baselines.oracle_kernel import weigh_prefix
from pft_exec.evaluation.baselines.planar_hand import ANCHOR, GOAL, LEFT, LOOP, OWN, SHARED, lay_waypoints
from pft_exec.evaluation.trace import Trace, grouped, softmax
from pft_exec.geometry import Array

READING = 0.005  # units: standard deviation with which a position is read, a two-thousandth of the field
TIMES = 20  # answers a recording
DRAWS = 200  # of chances, for each motion and each cell of pauses
HOPELESS = 60.0  # a motion whose log density is by so much less than the best one's is not followed any further
_LOOK_BACK = (1, 3, 6)  # answers ago: a search begins where the hand was thought to be before it paused
_PACES = (0.0, -1.0, 1.0)  # deviations of the pace at which searches begin

# Chances of a pause (when, how long), least and greatest: none, or one of six, each searched by itself.
_NO_PAUSE = np.array([[0.0, 0.0], [1.0, 1.0]])
_PAUSES = [np.array([[i / 3, j / 2], [(i + 1) / 3, (j + 1) / 2]]) for i in range(3) for j in range(2)]
_CELLS = [_NO_PAUSE, *_PAUSES]
_KINDS = {
    "to bin": GOAL,
    "to x": GOAL,
    "left": LEFT,
    "CW": LOOP,
    "CCW": LOOP,
    "anchor x, o": ANCHOR,
    "anchor o, x": ANCHOR,
}


@dataclass(frozen=True, eq=False)
class Oracle:
    """The motions it is asked for; all else it knows."""

    labels: tuple[str, ...]

    def recognize(self, demonstration: Demonstration) -> Trace:
        """Posterior of each motion after each twentieth of the samples."""
        return _recognized(self.labels, demonstration)


def know_people(demonstrations: Sequence[Demonstration]) -> Oracle:
    """Learn nothing of demonstrations but the names of their motions."""
    return Oracle(tuple(grouped(demonstrations)))


@lru_cache(maxsize=1024)
def _recognized(labels: tuple[str, ...], demonstration: Demonstration) -> Trace:
    """Kept, since one recording is a test in several folds."""
    begin, count = time.perf_counter(), len(demonstration)
    ends = sorted({max(int(np.ceil(k * count / TIMES - 1e-9)), 1) for k in range(1, TIMES + 1)})
    searches, scores = [_Search(label, demonstration) for label in labels], np.zeros((count, len(labels)))
    for end in ends:
        best = max(search.log_density for search in searches)
        followed = [search for search in searches if search.log_density > best - HOPELESS]
        for search in followed:
            search.see(end)
        _compare([search for search in followed if search.is_straight], end)
        scores[end - 1 :] = [search.log_density for search in searches]
    strangeness = -scores.max(axis=1) / np.arange(1, count + 1)
    return Trace(labels, scores, softmax(scores), strangeness, (time.perf_counter() - begin) / count)


class _Search:
    """How probable the prefix is under one motion, as the prefix grows; where its chances were found is remembered."""

    def __init__(self, label: str, demonstration: Demonstration) -> None:
        kind = _KINDS[label]
        people, style = planar.PEOPLE, planar.PEOPLE.style
        self._seen = np.ascontiguousarray(demonstration.position[:, :2])
        self._time = demonstration.time - demonstration.time[0]
        scatter = np.array([people.goal, people.reach, people.loop, people.bow])
        hand = np.array([style.overlap, style.bow, style.pace, *style.pause])
        self._trial = kind, self._seen[0].copy(), _places(label, demonstration), scatter, hand
        self._size = SHARED + OWN[kind]
        self._draws = np.random.default_rng(self._size).standard_normal((DRAWS, self._size))
        self._noise = np.array([READING, people.tremor])
        log_prior = [np.log1p(-people.pause_probability)] + [np.log(people.pause_probability)] * len(_PAUSES)
        self._log_prior = np.array(log_prior)
        self._found: list[list[Array]] = []  # at each answer, for each cell
        self._logs = np.zeros(len(_CELLS))
        self.log_density = 0.0

    @property
    def is_straight(self) -> bool:
        """Whether it is one way to one goal: then all differ in the law of the goal alone."""
        return self._trial[0] in (GOAL, LEFT)

    def see(self, end: int) -> None:
        """Compute `log_density` of the first `end` samples."""
        results = [self._weigh(number, end, self._starts(number)) for number in range(len(_CELLS))]
        self._found.append([z for _, z in results])
        self._settle(np.array([log for log, _ in results]))

    def reconsider(self, end: int, hand: tuple[Array, Array], number: int) -> None:
        """Search one cell once more, from what another straight motion found there: shared chances, goal."""
        log, z = self._weigh(number, end, self._from_goal(*hand)[None])
        if log > self._logs[number]:
            self._found[-1][number] = z
            self._settle(np.where(np.arange(len(_CELLS)) == number, log, self._logs))

    def hand(self, number: int) -> tuple[Array, Array]:
        """Shared chances (5,) and goal (2,) of a straight motion, as last found in a cell."""
        kind, start, places, scatter, _ = self._trial
        z, points = self._found[-1][number], np.zeros((2, 2))
        lay_waypoints(kind, start, places, scatter, z[SHARED:], points)
        return z[:SHARED], points[1]

    def _from_goal(self, shared: Array, goal: Array) -> Array:
        kind, start, places, scatter, _ = self._trial
        if kind == GOAL:
            return np.concatenate([shared, (goal - places[0]) / scatter[0]])
        length = max(float(start[0] - goal[0]), 0.1)
        offset = (goal - start + [length, 0.0]) / (0.3 * scatter[0])
        return np.concatenate([shared, offset, [np.log(length) / scatter[1]]])

    def _weigh(self, number: int, end: int, starts: Array) -> tuple[float, Array]:
        z, trial = np.zeros(self._size), (*self._trial, number > 0)
        time, seen = self._time[:end], self._seen[:end]
        log = weigh_prefix(trial, _CELLS[number], time, seen, self._noise, starts, self._draws, z)
        return float(log + self._log_prior[number]), z

    def _settle(self, logs: Array) -> None:
        self._logs = logs
        self.log_density = float(np.logaddexp.reduce(logs))

    def _starts(self, number: int) -> Array:
        """Where searches in a cell begin: where its last one ended, where others did before, and at usual chances."""
        usual = np.zeros((len(_PACES), self._size))
        usual[:, 0] = _PACES
        before = [self._found[-back][0] for back in _LOOK_BACK if back <= len(self._found)]
        best = [self._found[-1][int(np.argmax(self._logs))]] if self._found else []
        others = np.array([*best, *before, *usual])
        others[:, 3:5] = _CELLS[number].mean(axis=0)
        own = self._found[-1][number : number + 1] if self._found else []
        return np.array([*own, *others])


def _compare(searches: Sequence[_Search], end: int) -> None:
    """Let each straight motion look for the hand where the others found it: they share everything but the goal."""
    for number in range(len(_CELLS)):
        hands = [search.hand(number) for search in searches]
        for search in searches:
            for hand in hands:
                search.reconsider(end, hand, number)


def _places(label: str, demonstration: Demonstration) -> Array:
    """(2, 2): the goal, the turn of a loop, or the two places of an anchor; `planar_hand.lay_waypoints`."""
    if label == "to bin":
        goal = demonstration.scene["bin"].position[:2]
        return np.stack([goal, goal])
    turn = np.full(2, 1.0 if label == "CCW" else -1.0)
    choices = {"to x": (planar.X, planar.X), "anchor x, o": (planar.X, planar.O), "anchor o, x": (planar.O, planar.X)}
    return np.stack(choices.get(label, (turn, turn)))
