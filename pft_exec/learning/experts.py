"""Experts: predictions of a path in a scene, each from one point of view; `stacking` blends them.

The same functions predict for one new scene and, leaving each demonstration out in turn, for the demonstrated scenes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pft_exec.geometry import Array, geodesic_distance, rotation_matrix
from pft_exec.learning.averaging import average
from pft_exec.learning.endpoint import Endpoint, Poses, frame_pose, target_positions, target_turns
from pft_exec.learning.frame_product import fuse, scatters
from pft_exec.learning.normalization import bent_paths, is_closed, similar_paths
from pft_exec.learning.smoothing import smoothed
from pft_exec.learning.turning import carry, compose, turn_between, turn_by
from pft_exec.learning.variables import ABSOLUTE, START

PRIOR_DEGREES = 4.0  # of the normal-inverse-Wishart prior around the isotropic variance profile
SIMILAR_UP_TO = 20  # demonstrations: leaving each out costs their square, and frames predict better by then
TURNED = 0.02  # rad, below which an object counts as never turned
TOGETHER = 0.03  # of the extent: frames whose distance varied less show the same; as precise as a relevant end is held
PROFILE_WINDOW = 0.03  # of the motion, over which the prior variance is averaged

FrameKey = tuple[str, str]  # name and kind of axes


@dataclass(frozen=True, eq=False)
class Experts:
    """What the experts of one motion know.

    Parameters
    ----------
    path : (K, N, 3), m
        The aligned demonstrations, each in its own scene.
    share : (N,)
        Mean share of the path's length passed at each step.
    end : Endpoint
    keys, turn_keys : frames of the position (F) and of the orientation (F')
    local : (F, K, N, 3), m
        The demonstrations seen in those frames.
    local_turn : (F', K, N, 4), (x, y, z, w), or None
    floor : float
        Smallest standard deviation, m.
    shaped : bool
        Whether the bent and the scaled path join.
    """

    path: Array
    share: Array
    end: Endpoint
    keys: tuple[FrameKey, ...]
    turn_keys: tuple[FrameKey, ...]
    local: Array
    local_turn: Array | None
    floor: float
    shaped: bool = True

    @cached_property
    def covariance(self) -> Array:
        """`local_covariance` of all demonstrations, for new scenes."""
        return local_covariance(self.local, self.floor, leave_out=False)

    @cached_property
    def mean_turn(self) -> Array:
        """`local_mean_turns` of all demonstrations, for new scenes; empty where there is no orientation."""
        return np.empty((0, 1, 0, 4)) if self.local_turn is None else local_mean_turns(self.local_turn, leave_out=False)


def expert_keys(
    names: Sequence[str], poses: Poses, has_turn: bool, extent: float
) -> tuple[tuple[FrameKey, ...], tuple[FrameKey, ...]]:
    """Frames of the position experts and of the orientation experts.

    Frames that never moved against one another show the same, and would count twice: the first of them stands for all.

    Parameters
    ----------
    names : objects that count
    poses : poses (K, 7) of these and of the start in the demonstrated scenes
    has_turn : bool
    extent : float
        Size of the motion, m.
    """
    turned = [n for n in (START, *names) if float(geodesic_distance(poses[n][:1, 3:], poses[n][:, 3:]).max()) > TURNED]
    keys = [(START, "world")] + ([(START, "object")] if has_turn and START in turned else [])
    keys += [(name, axes) for name in names for axes in ("world", "object") if axes == "world" or name in turned]
    keys.append((ABSOLUTE, "world"))
    kept: list[FrameKey] = []
    for key in keys:
        if key[1] == "object" or not any(_moved_together(key, other, poses, extent) for other in kept):
            kept.append(key)
    turns = [(START, "object"), (START, "world"), (ABSOLUTE, "world")] + [(name, "object") for name in names]
    return tuple(kept), tuple(turns) if has_turn else ()


def _moved_together(one: FrameKey, other: FrameKey, poses: Poses, extent: float) -> bool:
    """Whether two frames in the world's axes were always at the same distance."""
    if other[1] == "object":
        return False
    count = len(poses[START])
    offset = frame_pose(one[0], poses, count)[:, :3] - frame_pose(other[0], poses, count)[:, :3]
    spread = np.sqrt(np.sum((offset - offset.mean(axis=0)) ** 2) / max(count - 1, 1))
    return bool(spread < TOGETHER * extent)


def local_covariance(local: Array, floor: float, leave_out: bool) -> Array:
    """Predictive covariance (F, M, N, 3, 3) of paths seen in F frames.

    Parameters
    ----------
    local : (F, K, N, 3), m
    floor : float
        Smallest standard deviation, m.
    leave_out : bool
        M = K, each without its own demonstration; else M = 1.
    """
    count = local.shape[1]
    mean = local.mean(axis=1, keepdims=True)
    residual = local - mean
    covariance: Array = scatters(residual, leave_out)
    used = count - 1 if leave_out else count
    degrees = max(used - 1, 1)
    axes = max(int(np.sum(np.ptp(local, axis=(0, 1, 2)) > 1e-9 * np.ptp(local))), 1)  # planar data have two
    variance = np.trace(covariance, axis1=-2, axis2=-1) / axes / degrees
    profile = smoothed(np.moveaxis(variance, -1, 0), PROFILE_WINDOW * local.shape[2])
    covariance[..., [0, 1, 2], [0, 1, 2]] += PRIOR_DEGREES * np.moveaxis(profile, 0, -1)[..., None]
    covariance *= (1.0 + 1.0 / used) / (degrees + PRIOR_DEGREES)
    covariance[..., [0, 1, 2], [0, 1, 2]] += floor**2
    return covariance


def _own_axes(keys: Sequence[FrameKey]) -> NDArray[np.bool_]:
    """(F,): which frames are meant in their own axes."""
    return np.array([axes == "object" for _, axes in keys])


def framed_positions(mean: Array, keys: Sequence[FrameKey], poses: Poses) -> Array:
    """Paths (F, M, N, 3) in the world from means (F, M, N, 3) in frames."""
    pose = np.stack([frame_pose(name, poses, mean.shape[1]) for name, _ in keys])[:, :, None]
    own = _own_axes(keys)
    world = np.array(mean)
    if own.any():
        world[own] = carry(pose[own, ..., 3:], world[own])
    return world + pose[..., :3]


def product(world: Array, covariance: Array, keys: Sequence[FrameKey], poses: Poses) -> Array:
    """Product of Gaussians (M, N, 3) of all frames; `covariance` (F, M, N, 3, 3) in their own axes."""
    count = world.shape[1]
    turns = np.stack([_axes(key, poses, count) for key in keys])
    fused: Array = fuse(world, covariance, turns)
    return fused


def _axes(key: FrameKey, poses: Poses, count: int) -> Array:
    """Rotation matrices (M, 3, 3) from the axes in which a frame is meant to the world's, in M scenes."""
    if key[1] == "world":
        return np.broadcast_to(np.eye(3), (count, 3, 3))
    return rotation_matrix(frame_pose(key[0], poses, count)[:, 3:])


def framed_turns(local: Array, keys: Sequence[FrameKey], poses: Poses) -> Array:
    """Orientations (F, M, N, 4) in the world from those (F, M, N, 4) in frames."""
    pose = np.stack([frame_pose(name, poses, local.shape[1]) for name, _ in keys])[:, :, None, 3:]
    own = _own_axes(keys)
    world = np.empty(local.shape)
    world[own] = compose(pose[own], local[own])
    world[~own] = compose(local[~own], pose[~own])
    return world


def local_mean_turns(local: Array, leave_out: bool) -> Array:
    """Mean orientations (F, M, N, 4) of (F, K, N, 4); M = K, each without its own, or 1."""
    mean = average(local.swapaxes(0, 1))[:, None]
    if not leave_out:
        return mean
    means: Array = turn_by(mean, turn_between(mean, local) / (1.0 - local.shape[1]))
    return means


def slerp(begin: Array, end: Array, share: Array) -> Array:
    """Geodesics (M, N, 4) from `begin` to `end` (M, 4), passed as `share` (N,) says."""
    turned: Array = turn_by(begin[:, None], turn_between(begin, end)[:, None] * share[:, None])
    return turned


def predict_positions(experts: Experts, poses: Poses, begin: Array, leave_out: bool) -> Array:
    """Predictions (E, M, N, 3) of every expert in M scenes that begin at `begin` (M, 3)."""
    world = predict_in_frames(experts, poses, len(begin), leave_out)
    covariance = local_covariance(experts.local, experts.floor, True) if leave_out else experts.covariance
    found = [world, product(world, covariance, experts.keys, poses)[None]]
    end = target_positions(experts.end, poses, len(begin), leave_out) if experts.shaped else None
    paths = experts.path
    if end is not None:
        found.append(bent_paths(paths, begin, end, leave_out)[None])
        if len(paths) <= SIMILAR_UP_TO and not is_closed(paths):
            found.append(similar_paths(paths, begin, end, leave_out)[None])
    return np.concatenate(found)


def predict_in_frames(experts: Experts, poses: Poses, count: int, leave_out: bool) -> Array:
    """Predictions (F, M, N, 3) of the frames in `count` M scenes."""
    mean = experts.local.mean(axis=1, keepdims=True)
    if leave_out:
        mean = mean - (experts.local - mean) / (experts.local.shape[1] - 1)
    return framed_positions(np.broadcast_to(mean, (len(mean), count, *mean.shape[2:])), experts.keys, poses)


def predict_turns(experts: Experts, poses: Poses, begin: Array, leave_out: bool) -> Array:
    """Orientations (E, M, N, 4) of every expert in M scenes that begin turned as `begin` (M, 4)."""
    if experts.local_turn is None:
        return np.empty((0, len(begin), len(experts.share), 4))
    local = experts.mean_turn if not leave_out else local_mean_turns(experts.local_turn, leave_out)
    count = len(begin)
    world = framed_turns(np.broadcast_to(local, (len(local), count, *local.shape[2:])), experts.turn_keys, poses)
    end = target_turns(experts.end, poses, count, leave_out)
    if end is None:
        return world
    return np.concatenate([world, slerp(begin, end, experts.share)[None]])
