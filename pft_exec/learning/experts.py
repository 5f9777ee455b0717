"""Experts: predictions of a path in a scene, each from one point of view; `stacking` blends them.

The same functions predict for one new scene and, leaving each demonstration out in turn, for the demonstrated scenes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pft_exec.geometry import (
    Array,
    geodesic_distance,
    multiply,
    quaternion_from_rotation_vector,
    relative_rotation_vector,
    rotate,
    rotation_matrix,
)
from pft_exec.learning.averaging import average
from pft_exec.learning.endpoint import Endpoint, Poses, frame_pose, target_positions, target_turns
from pft_exec.learning.normalization import bent_paths, is_closed, similar_paths
from pft_exec.learning.resampling import smoothing
from pft_exec.learning.variables import ABSOLUTE, START

PRIOR_DEGREES = 4.0  # of the normal-inverse-Wishart prior around the isotropic variance profile
BENDING_FROM = 5  # demonstrations from which the bent and the scaled path join the experts
SIMILAR_UP_TO = 20  # demonstrations: leaving each out costs their square, and frames predict better by then
TURNED = 0.02  # rad, below which an object counts as never turned
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
    groups : tuple of tuples
        Frames whose Gaussians are multiplied.
    """

    path: Array
    share: Array
    end: Endpoint
    keys: tuple[FrameKey, ...]
    turn_keys: tuple[FrameKey, ...]
    local: Array
    local_turn: Array | None
    floor: float
    groups: tuple[tuple[int, ...], ...] = ()

    @cached_property
    def statistics(self) -> tuple[Array, Array]:
        """`local_statistics` of all demonstrations, for new scenes."""
        return local_statistics(self.local, self.floor, leave_out=False)

    @cached_property
    def mean_turn(self) -> Array:
        """`local_mean_turns` of all demonstrations, for new scenes; empty where there is no orientation."""
        return np.empty((0, 1, 0, 4)) if self.local_turn is None else local_mean_turns(self.local_turn, leave_out=False)


def expert_keys(poses: Poses, has_turn: bool) -> tuple[tuple[FrameKey, ...], tuple[FrameKey, ...]]:
    """Frames of the position experts and of the orientation experts; `poses` are those of the demonstrated scenes.

    An object that never turned has one frame, not two that say the same.
    """
    names = [name for name in poses if name != START]
    turned = [
        name for name in names if float(geodesic_distance(poses[name][:1, 3:], poses[name][:, 3:]).max()) > TURNED
    ]
    keys = [(START, "world"), (ABSOLUTE, "world")]
    keys += [(START, "object")] if has_turn else []
    keys += [(name, axes) for name in names for axes in ("world", "object") if axes == "world" or name in turned]
    turns = [(START, "object"), (START, "world"), (ABSOLUTE, "world")] + [(name, "object") for name in names]
    return tuple(keys), tuple(turns) if has_turn else ()


def product_groups(keys: Sequence[FrameKey], errors: Array) -> tuple[tuple[int, ...], ...]:
    """Which Gaussians to multiply: all, and the start with the frames of the object that predicts best.

    Parameters
    ----------
    keys : F frames, the start in the world's axes first
    errors : (F, K, N, 3)
        Leave-one-out errors.
    """
    every = tuple(range(len(keys)))
    objects = [i for i, (name, _) in enumerate(keys) if name not in (START, ABSOLUTE)]
    if not objects:
        return (every,)
    best = min(objects, key=lambda i: float(np.sum(errors[i] ** 2)))
    same = tuple(i for i in objects if keys[i][0] == keys[best][0])
    pairs = tuple((0, i) for i in same)
    return tuple(dict.fromkeys((every, *pairs, (0, *same))))


def local_statistics(local: Array, floor: float, leave_out: bool) -> tuple[Array, Array]:
    """Mean (F, M, N, 3) and predictive covariance (F, M, N, 3, 3) of paths seen in F frames.

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
    scatter = np.einsum("fkni,fknj->fnij", residual, residual)[:, None]
    used = count
    if leave_out:
        used = count - 1
        mean = mean - residual / used
        scatter = scatter - count / used * residual[..., :, None] * residual[..., None, :]
    degrees = max(used - 1, 1)
    variance = np.trace(scatter, axis1=-2, axis2=-1) / 3.0 / degrees
    profile = variance @ smoothing(local.shape[2], PROFILE_WINDOW * local.shape[2]).T
    prior = PRIOR_DEGREES * profile[..., None, None] * np.eye(3)
    covariance = (scatter + prior) / (degrees + PRIOR_DEGREES) * (1.0 + 1.0 / used) + floor**2 * np.eye(3)
    return mean, covariance


@njit(cache=True)
def _fuse(means, covariances, members):  # type: ignore[no-untyped-def]
    """Product of Gaussians: (M, N, 3) from means (F, M, N, 3), covariances (F, M, N, 3, 3)."""
    scenes, steps = means.shape[1], means.shape[2]
    fused = np.empty((scenes, steps, 3))
    total, weighted, inverse = np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    for m in range(scenes):
        for n in range(steps):
            total[:] = 0.0
            weighted[:] = 0.0
            for f in members:
                _invert(covariances[f, m, n], inverse)
                for i in range(3):
                    for j in range(3):
                        total[i, j] += inverse[i, j]
                        weighted[i] += inverse[i, j] * means[f, m, n, j]
            _invert(total, inverse)
            for i in range(3):
                fused[m, n, i] = inverse[i, 0] * weighted[0] + inverse[i, 1] * weighted[1] + inverse[i, 2] * weighted[2]
    return fused


@njit(cache=True)
def _invert(a, out):  # type: ignore[no-untyped-def]
    """Inverse of a symmetric matrix (3, 3) by cofactors."""
    out[0, 0] = a[1, 1] * a[2, 2] - a[1, 2] * a[1, 2]
    out[0, 1] = a[0, 2] * a[1, 2] - a[0, 1] * a[2, 2]
    out[0, 2] = a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]
    out[1, 1] = a[0, 0] * a[2, 2] - a[0, 2] * a[0, 2]
    out[1, 2] = a[0, 1] * a[0, 2] - a[0, 0] * a[1, 2]
    out[2, 2] = a[0, 0] * a[1, 1] - a[0, 1] * a[0, 1]
    determinant = a[0, 0] * out[0, 0] + a[0, 1] * out[0, 1] + a[0, 2] * out[0, 2]
    out[1, 0], out[2, 0], out[2, 1] = out[0, 1], out[0, 2], out[1, 2]
    for i in range(3):
        for j in range(3):
            out[i, j] /= determinant


def _own_axes(keys: Sequence[FrameKey]) -> NDArray[np.bool_]:
    """(F,): which frames are meant in their own axes."""
    return np.array([axes == "object" for _, axes in keys])


def framed_positions(mean: Array, keys: Sequence[FrameKey], poses: Poses) -> Array:
    """Paths (F, M, N, 3) in the world from means (F, M, N, 3) in frames."""
    pose = np.stack([frame_pose(name, poses, mean.shape[1]) for name, _ in keys])[:, :, None]
    own = _own_axes(keys)
    world = np.array(mean)
    if own.any():
        world[own] = rotate(pose[own, ..., 3:], world[own])
    return world + pose[..., :3]


def products(
    world: Array, covariance: Array, keys: Sequence[FrameKey], poses: Poses, groups: Sequence[Sequence[int]]
) -> Array:
    """Products of Gaussians (G, M, N, 3) of groups of frames; `covariance` (F, M, N, 3, 3) in their own axes."""
    turned = np.array(np.broadcast_to(covariance, (*world.shape, 3)))
    for index in map(int, np.flatnonzero(_own_axes(keys))):
        turn = rotation_matrix(frame_pose(keys[index][0], poses, world.shape[1])[:, 3:])[:, None]
        turned[index] = turn @ turned[index] @ turn.swapaxes(-1, -2)
    return np.stack([_fuse(world, turned, np.array(group, dtype=np.int64)) for group in groups])


def framed_turns(local: Array, keys: Sequence[FrameKey], poses: Poses) -> Array:
    """Orientations (F, M, N, 4) in the world from those (F, M, N, 4) in frames."""
    pose = np.stack([frame_pose(name, poses, local.shape[1]) for name, _ in keys])[:, :, None, 3:]
    own = _own_axes(keys)
    world = np.empty(local.shape)
    world[own] = multiply(pose[own], local[own])
    world[~own] = multiply(local[~own], pose[~own])
    return world


def local_mean_turns(local: Array, leave_out: bool) -> Array:
    """Mean orientations (F, M, N, 4) of (F, K, N, 4); M = K, each without its own, or 1."""
    mean = average(local.swapaxes(0, 1))[:, None]
    if not leave_out:
        return mean
    residual = relative_rotation_vector(mean, local)
    return multiply(mean, quaternion_from_rotation_vector(-residual / (local.shape[1] - 1)))


def slerp(begin: Array, end: Array, share: Array) -> Array:
    """Geodesics (M, N, 4) from `begin` to `end` (M, 4), passed as `share` (N,) says."""
    step = relative_rotation_vector(begin, end)
    return multiply(begin[:, None], quaternion_from_rotation_vector(step[:, None] * share[:, None]))


def predict_positions(experts: Experts, poses: Poses, begin: Array, leave_out: bool) -> Array:
    """Predictions (E, M, N, 3) of every expert in M scenes that begin at `begin` (M, 3)."""
    if leave_out:
        mean, covariance = local_statistics(experts.local, experts.floor, leave_out)
    else:
        mean, covariance = experts.statistics
    count = len(begin)
    world = framed_positions(np.broadcast_to(mean, (len(mean), count, *mean.shape[2:])), experts.keys, poses)
    found = [world, products(world, covariance, experts.keys, poses, experts.groups)]
    end = target_positions(experts.end, poses, count, leave_out)
    paths = experts.path
    if end is not None and len(paths) >= BENDING_FROM:
        found.append(bent_paths(paths, begin, end, leave_out)[None])
        if len(paths) <= SIMILAR_UP_TO and not is_closed(paths):
            found.append(similar_paths(paths, begin, end, leave_out)[None])
    return np.concatenate(found)


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
