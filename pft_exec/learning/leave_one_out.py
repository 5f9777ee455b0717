"""Leaving one out: which experts help, and how much, judged by what they say of demonstrations they were not shown.

In the flow: between the experts of a motion and its covariance; `robust` calls it once per motion.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pft_exec.geometry import Array
from pft_exec.learning.alignment import AlignedSet
from pft_exec.learning.blending import Prediction, Weights, blend_experts, predict, turn_weights, with_ends
from pft_exec.learning.endpoint import Poses, target_positions
from pft_exec.learning.experts import Experts, predict_in_frames
from pft_exec.learning.leverage import Leverage, find_leverage
from pft_exec.learning.stacking import ExpertErrors, blend_positions
from pft_exec.learning.tempo import Tempo

DECIDED = 4.0  # demonstrations that the decision for a frame counts as, beside those that show how well it predicts


def _own_axes_where_they_help(experts: Experts, errors: ExpertErrors) -> Experts:
    """The experts with one kind of axes for each frame that has two: the one with which all of them predict best."""
    kept = list(range(len(experts.keys)))
    for name in dict.fromkeys(name for name, _ in experts.keys):
        pair = [i for i in kept if experts.keys[i][0] == name]
        if len(pair) == 2:
            sets = [[i for i in kept if i == one or i not in pair] for one in pair]
            kept = min(sets, key=lambda chosen: errors.of(chosen).cross_fitted_square())
    return replace(experts, keys=tuple(experts.keys[i] for i in kept), local=experts.local[kept])


def _shaped_where_it_helps(experts: Experts, errors: ExpertErrors) -> tuple[Experts, ExpertErrors]:
    """The experts and their errors, the bent and the scaled path among them only if all predict better with these."""
    unshaped = len(experts.keys) + 1
    if len(errors.errors) == unshaped:
        return experts, errors
    without = errors.of(range(unshaped))
    if errors.cross_fitted_square() < without.cross_fitted_square():
        return experts, errors
    return replace(experts, shaped=False), without


def _believed_target(experts: Experts, poses: Poses, path: Array, overruled: bool) -> float:
    """How much the end that the variables ask for is believed beside the blend; wholly where the user named it."""
    end = target_positions(experts.end, poses, len(path), leave_out=True)
    if overruled or end is None:
        return 1.0
    errors = np.stack([end, path[:, -1]]) - experts.path[:, -1]
    shown = float(ExpertErrors(errors[:, :, None], experts.floor).weights()[0, 0])
    return (len(path) * shown + DECIDED) / (len(path) + DECIDED)


@dataclass(frozen=True, eq=False)
class LeftOut:
    """What the experts say of each demonstration from the others.

    Parameters
    ----------
    experts : those that help
    weights : Weights
    blend : Prediction
    own : (K, N, 3), m
        How far the blend is off where a demonstration's own errors take no part in the weights, less how far it is.
    leverage : Leverage
        What the demonstrations leave open about the weights of the positions.
    """

    experts: Experts
    weights: Weights
    blend: Prediction
    own: Array
    leverage: Leverage


def leave_one_out(experts: Experts, poses: Poses, even: AlignedSet, tempo: Tempo, overruled: bool) -> LeftOut:
    """The experts that help, their weights, and the blend for each demonstrated scene from the others.

    Seen from one frame only, no weights push the blend: it keeps its own tempo.
    """
    in_frames = predict_in_frames(experts, poses, len(even.position), leave_out=True)
    experts = _own_axes_where_they_help(experts, ExpertErrors(in_frames - even.position, experts.floor))
    prediction = predict(experts, poses, leave_out=True)
    experts, errors = _shaped_where_it_helps(experts, ExpertErrors(prediction.position - even.position, experts.floor))
    prediction = replace(prediction, position=prediction.position[: len(errors.errors)])
    weights = Weights(errors.weights(), turn_weights(prediction, even))
    blended = blend_positions(weights.position, prediction.position)
    weights = replace(weights, target=_believed_target(experts, poses, blended, overruled))
    own = errors.cross_fitted - (blended - even.position)
    blend = blend_experts(experts, poses, prediction, weights, leave_out=True)
    paced = Prediction(*tempo.given_to(blend.position, blend.turn, leave_out=True))
    if len(experts.keys) > 1 and not _is_clearly_worse(*(_squares(said, even) for said in (blend, paced))):
        weights, blend = replace(weights, tempo=tempo), paced
    said = with_ends(experts, poses, prediction.position, leave_out=True)
    leverage = find_leverage(said, even.position - blend.position - own, experts.floor)
    return LeftOut(experts, weights, blend, own, leverage)


def _squares(said: Prediction, even: AlignedSet) -> Array:
    """Mean square errors (K,) of the positions."""
    squares: Array = np.mean((said.position - even.position) ** 2, axis=(1, 2))
    return squares


def _is_clearly_worse(without: Array, with_it: Array) -> bool:
    """Whether errors (K,) grow by more than one standard error: less would be no reason to leave the rule."""
    growth = with_it - without
    return bool(growth.mean() > growth.std(ddof=1) / np.sqrt(len(growth)))
