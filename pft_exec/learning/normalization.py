"""Normalization: a demonstrated path carried to other ends, by bending along its arc length or by a similarity.

[Dong2012]_, Algorithm 3 line 3, scales and turns; that has no meaning where a motion is closed ("stir"), so there only
bending is used. In space the turn between two displacements is not unique: gravity stays, the turn about z comes first.
"""

from __future__ import annotations

import numpy as np

from pft_exec.geometry import Array, quaternion_from_rotation_vector, shortest_rotation
from pft_exec.learning.resampling import arc_length
from pft_exec.learning.turning import carry, compose

CLOSED = 0.5  # displacement below this share of the extent gives no direction to turn or scale along
SCALE = (0.5, 2.0)  # how far a path is shrunk or stretched as a whole; the rest is bent
LEVEL = 0.2  # horizontal share of a displacement below which it has no heading


def is_closed(position: Array) -> bool:
    """Whether any of the paths (K, N, 3) ends near to where it began."""
    displacement = np.linalg.norm(position[:, -1] - position[:, 0], axis=1)
    extent = np.linalg.norm(np.ptp(position, axis=1), axis=1)
    return bool(np.any(displacement <= CLOSED * extent))


def upright_rotation(first: Array, second: Array) -> Array:
    """Unit quaternions (..., 4) that take direction `first` to `second` (..., 3): about z first, then the shortest."""
    level = np.linalg.norm(first[..., :2], axis=-1), np.linalg.norm(second[..., :2], axis=-1)
    has_heading = (level[0] > LEVEL * np.linalg.norm(first, axis=-1)) & (
        level[1] > LEVEL * np.linalg.norm(second, axis=-1)
    )
    heading = np.arctan2(second[..., 1], second[..., 0]) - np.arctan2(first[..., 1], first[..., 0])
    angle = np.where(has_heading, (heading + np.pi) % (2.0 * np.pi) - np.pi, 0.0)
    turn = quaternion_from_rotation_vector(angle[..., None] * np.array([0.0, 0.0, 1.0]))
    rotation: Array = compose(shortest_rotation(carry(turn, first), second), turn)
    return rotation


def bent_paths(position: Array, begin: Array, end: Array, leave_out: bool) -> Array:
    """Mean (M, N, 3) of paths (K, N, 3) bent to begin and end at `begin`, `end` (M, 3); M = K where `leave_out`."""
    share = arc_length(position)[..., None]
    fixed = position - (1.0 - share) * position[:, :1] - share * position[:, -1:]
    if leave_out:
        others = len(position) - 1
        fixed = (fixed.sum(axis=0) - fixed) / others
        share = (share.sum(axis=0) - share) / others
    else:
        fixed, share = fixed.mean(axis=0), share.mean(axis=0)
    bent: Array = fixed + (1.0 - share) * begin[:, None] + share * end[:, None]
    return bent


def similar_paths(position: Array, begin: Array, end: Array, leave_out: bool) -> Array:
    """As `bent_paths`, by a similarity transform of each path; what the bounds of the scale leave is bent."""
    shown = position[:, -1] - position[:, 0]
    wanted = end - begin
    shown_length = np.linalg.norm(shown, axis=1)
    ratio = np.linalg.norm(wanted, axis=1)[None, :] / shown_length[:, None]
    scale = np.clip(ratio, *SCALE)
    safe = np.where(np.linalg.norm(wanted, axis=1, keepdims=True) > 1e-9 * shown_length.max(), wanted, shown[:1])
    turn = upright_rotation(shown[:, None], np.broadcast_to(safe, (len(shown), *safe.shape)))
    moved = (position - position[:, :1])[:, None]
    paths = begin[:, None] + scale[..., None, None] * carry(turn[:, :, None], moved)
    gap = end - paths[:, :, -1]
    paths = paths + arc_length(position)[:, None, :, None] * gap[:, :, None]
    if leave_out:
        own = paths[np.arange(len(position)), np.arange(len(position))]
        mean: Array = (paths.sum(axis=0) - own) / (len(position) - 1)
    else:
        mean = paths.mean(axis=0)
    return mean
