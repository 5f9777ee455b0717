"""Blending: what the experts say of some scenes, how much each is believed, and the path that comes of it.

In the flow: `leave_one_out` finds the weights in the demonstrated scenes, `robust` blends for a new one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pft_exec.geometry import Array
from pft_exec.learning.alignment import AlignedSet
from pft_exec.learning.endpoint import Poses, target_positions, target_turns
from pft_exec.learning.experts import Experts, predict_positions, predict_turns
from pft_exec.learning.stacking import ExpertErrors, blend_positions, blend_turns
from pft_exec.learning.tempo import Tempo
from pft_exec.learning.turning import turn_between, turn_by
from pft_exec.learning.variables import START

TURN_FLOOR = 0.005  # rad, standard deviation below which orientations count as equal


def _corrected(path: Array, begin: Array, end: Array | None, share: Array) -> Array:
    """Paths (M, N, 3) that begin and end where they have to; the correction fades along the path."""
    path = path + ((1.0 - share) ** 2)[:, None] * (begin - path[:, 0])[:, None]
    return path if end is None else path + (share**2)[:, None] * (end - path[:, -1])[:, None]


def _corrected_turns(path: Array, begin: Array, end: Array | None, share: Array) -> Array:
    """Orientations (M, N, 4) that begin and end as they have to."""
    first = turn_between(path[:, 0], begin)
    path = turn_by(path, ((1.0 - share) ** 2)[:, None] * first[:, None])
    if end is None:
        return path
    last = turn_between(path[:, -1], end)
    turned: Array = turn_by(path, (share**2)[:, None] * last[:, None])
    return turned


@dataclass(frozen=True, eq=False)
class Prediction:
    """What experts say of M scenes, or the blend of it.

    Parameters
    ----------
    position : (E, M, N, 3), blended (M, N, 3), m, world frame
    turn : (E', M, N, 4), blended (M, N, 4), (x, y, z, w), or None
    """

    position: Array
    turn: Array | None


@dataclass(frozen=True, eq=False)
class Weights:
    """How much each expert is believed at each step: position (N, E), turn (N, E') or None.

    `target` in [0, 1] is how much the place that the motion variables ask for at the end is believed beside the blend;
    `tempo` is that of the demonstrations, or None where the blend's own predicts better.
    """

    position: Array
    turn: Array | None
    target: float = 1.0
    tempo: Tempo | None = None


def predict(experts: Experts, poses: Poses, leave_out: bool) -> Prediction:
    """Every expert's prediction for M scenes that begin at ``poses["start"]``."""
    begin = poses[START]
    turn = None if experts.local_turn is None else predict_turns(experts, poses, begin[:, 3:], leave_out)
    return Prediction(predict_positions(experts, poses, begin[:, :3], leave_out), turn)


def turn_weights(prediction: Prediction, aligned: AlignedSet) -> Array | None:
    """Weights (N, E') of the orientations, from what the experts say of demonstrations that they were not shown."""
    if prediction.turn is None or aligned.quaternion is None:
        return None
    return ExpertErrors(turn_between(aligned.quaternion[None], prediction.turn), TURN_FLOOR).weights()


def blend_experts(
    experts: Experts, poses: Poses, prediction: Prediction, weights: Weights, leave_out: bool
) -> Prediction:
    """The experts' predictions blended, and made to begin and end where they have to."""
    begin, count, share = poses[START], len(poses[START]), experts.share
    path = blend_positions(weights.position, prediction.position)
    end = target_positions(experts.end, poses, count, leave_out)
    if end is not None:
        end = path[:, -1] + weights.target * (end - path[:, -1])
    path = _corrected(path, begin[:, :3], end, share)
    turn = None
    if prediction.turn is not None and weights.turn is not None:
        end_turn = target_turns(experts.end, poses, count, leave_out)
        turn = _corrected_turns(blend_turns(weights.turn, prediction.turn), begin[:, 3:], end_turn, share)
    if weights.tempo is not None:
        path, turn = weights.tempo.given_to(path, turn, leave_out)
    return Prediction(path, turn)


def with_ends(experts: Experts, poses: Poses, said: Array, leave_out: bool) -> Array:
    """What each expert says (E, M, N, 3) of M scenes, made to begin and end where the motion variables ask for it."""
    begin = poses[START][:, :3]
    end = target_positions(experts.end, poses, len(begin), leave_out)
    return np.stack([_corrected(path, begin, end, experts.share) for path in said])


def left_over(aligned: AlignedSet, blend: Prediction) -> Array:
    """(K, N, 3) or (K, N, 6): what the blend leaves of the demonstrations."""
    left = aligned.position - blend.position
    if aligned.quaternion is None or blend.turn is None:
        return left
    return np.concatenate([left, turn_between(blend.turn, aligned.quaternion)], axis=-1)
