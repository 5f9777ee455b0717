"""Endpoints: where the two ends of a motion have to be in a scene, by the frames that count there.

In the flow: the decisions name frames; here they become places. Several frames at one end are fused by their
precisions (a product of Gaussians); where they contradict one another, that is said.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pft_exec.geometry import Array, conjugate, rotation_matrix
from pft_exec.learning.averaging import average
from pft_exec.learning.turning import carry, compose, turn_between, turn_by
from pft_exec.learning.variables import ABSOLUTE, EndDecision, FrameDecision

CONFLICT = 3.0  # standard deviations of the difference of two targets beyond which they contradict one another

Poses = Mapping[str, Array]  # frame name -> poses (M, 7) of that frame in M scenes, m and (x, y, z, w)


@dataclass(frozen=True, eq=False)
class Endpoint:
    """One end of K demonstrations in the frames that count there.

    Parameters
    ----------
    frames, turn_frames : tuple of (name, axes)
        Those of the position (R of them), and of the orientation (S).
    place : (R, K, 3)
        Tool position in each frame, m.
    turn : (S, K, 4)
        Tool orientation in each frame, (x, y, z, w).
    mask : (R, 3)
        Which of the world's axes each frame decides; all where decisions are not split by direction.
    required : int
        How many of the frames count; the rest are rivals, heard as long as they do not contradict the first.
    floor : float
        Smallest standard deviation of a target, m.
    belief : (R,)
        Posterior of each frame among these.
    """

    frames: tuple[tuple[str, str], ...]
    turn_frames: tuple[tuple[str, str], ...]
    place: Array
    turn: Array
    mask: Array
    required: int
    floor: float
    belief: Array


def local_positions(position: Array, pose: Array, axes: str) -> Array:
    """Positions (K, ..., 3) seen from poses (K, 7): offsets in the world's axes or in the frame's own."""
    shape = (len(pose),) + (1,) * (position.ndim - 2)
    offset = position - pose[:, :3].reshape(*shape, 3)
    return carry(conjugate(pose[:, 3:]).reshape(*shape, 4), offset) if axes == "object" else offset


def local_turns(quaternion: Array, pose: Array, axes: str) -> Array:
    """Orientations (K, ..., 4) seen from poses (K, 7): ``pose^-1 * q``, or for the world's axes ``q * pose^-1``."""
    back = conjugate(pose[:, 3:]).reshape(len(pose), *(1,) * (quaternion.ndim - 2), 4)
    turns: Array = compose(quaternion, back) if axes == "world" else compose(back, quaternion)
    return turns


def frame_pose(name: str, poses: Poses, count: int) -> Array:
    """Poses (M, 7) of a frame in M scenes; the world's is the identity."""
    if name == ABSOLUTE:
        return np.broadcast_to(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), (count, 7))
    return poses[name]


def _position_frames(decision: FrameDecision) -> tuple[tuple[tuple[str, str], ...], Array]:
    """Frames of a decision, those that count first, then its rivals; and the axes that each decides."""
    names = decision.relevant + decision.rivals if decision.relevant else ()
    frames = tuple((name, decision.axes_of(name)) for name in names)
    if not decision.directions:
        return frames, np.ones((len(frames), 3))
    return frames, np.array([[float(axis == name) for axis in decision.directions] for name, _ in frames])


def make_endpoint(decision: EndDecision, tool: Array, poses: Poses, floor: float) -> Endpoint:
    """The endpoint of K demonstrations whose tool poses there are `tool` (K, 7), frames at `poses`."""
    frames, mask = _position_frames(decision.position)
    turned = decision.orientation
    turn_frames = () if turned is None else tuple((name, turned.axes_of(name)) for name in turned.relevant)
    count = len(tool)
    belief = np.array([max(decision.position.probability.get(name, 0.0), 1e-12) for name, _ in frames])
    places = [local_positions(tool[:, :3], frame_pose(n, poses, count), axes) for n, axes in frames]
    turns = [local_turns(tool[:, 3:], frame_pose(n, poses, count), axes) for n, axes in turn_frames]
    return Endpoint(
        frames,
        turn_frames,
        np.array(places).reshape(len(frames), count, 3),
        np.array(turns).reshape(len(turn_frames), count, 4),
        mask,
        len(decision.position.relevant),
        floor,
        belief / max(belief.sum(), 1e-12),
    )


def _means(values: Array, leave_out: bool) -> Array:
    """Means (1, 3) over demonstrations (K, 3), or (K, 3), each without its own."""
    total = values.sum(axis=0, keepdims=True)
    means: Array = (total - values) / (len(values) - 1) if leave_out else total / len(values)
    return means


def _precision(values: Array, floor: float) -> Array:
    """Precision (3, 3) of the mean offset in a new scene, shrunk to an isotropic one: few demonstrations."""
    count = len(values)
    residual = values - values.mean(axis=0)
    scatter = residual.T @ residual
    isotropic = np.eye(3) * np.trace(scatter) / 3.0 / max(count - 1, 1)
    covariance = (scatter + 4.0 * isotropic) / (count + 3.0) * (1.0 + 1.0 / count) + floor**2 * np.eye(3)
    inverse: Array = np.linalg.inv(covariance)
    return inverse


def _targets(endpoint: Endpoint, poses: Poses, count: int, leave_out: bool) -> list[tuple[Array, Array]]:
    """Place (M, 3) and precision (M, 3, 3) that each frame asks for; a rival that the scene lacks is passed over."""
    found = []
    for index, ((name, axes), values) in enumerate(zip(endpoint.frames, endpoint.place, strict=True)):
        if index >= endpoint.required and name not in (ABSOLUTE, *poses):
            continue
        pose = frame_pose(name, poses, count)
        turn = np.broadcast_to(rotation_matrix(pose[:, 3:]) if axes == "object" else np.eye(3), (count, 3, 3))
        mean = np.broadcast_to(_means(values, leave_out), (count, 3))
        place = pose[:, :3] + np.einsum("mij,mj->mi", turn, mean)
        precision = turn @ _precision(values, endpoint.floor) @ turn.swapaxes(1, 2)
        mask = endpoint.mask[index]
        found.append((place, precision * mask[:, None] * mask[None, :]))
    return found


def _gap(first: tuple[Array, Array], second: tuple[Array, Array]) -> Array:
    """Distance (M,) of two targets in standard deviations of their difference."""
    joint = np.linalg.inv(first[1]) + np.linalg.inv(second[1])
    difference = second[0] - first[0]
    gap: Array = np.sqrt(np.einsum("mi,mij,mj->m", difference, np.linalg.inv(joint), difference))
    return gap


def target_positions(endpoint: Endpoint, poses: Poses, count: int, leave_out: bool = False) -> Array | None:
    """Required positions (M, 3), world frame, in M scenes; None where nothing is relevant.

    `leave_out` (M = K, the demonstrated scenes): each demonstration's target comes from the others. A rival frame that
    contradicts the chosen one is not heard.
    """
    if not endpoint.frames:
        return None
    targets = _targets(endpoint, poses, count, leave_out)
    heard = np.ones((len(targets), count))
    for index in range(endpoint.required, len(targets)):
        heard[index] = _gap(targets[0], targets[index]) < CONFLICT
    places = np.stack([place for place, _ in targets])
    precisions = np.stack([precision for _, precision in targets]) * heard[..., None, None]
    weighted = np.einsum("rmij,rmj->mi", precisions, places)
    target: Array = np.linalg.solve(precisions.sum(axis=0), weighted[..., None])[..., 0]
    return target


def doubt(endpoint: Endpoint, poses: Poses) -> Array:
    """Covariance (3, 3), m^2, of the required position in a scene where rivals contradict the chosen frame.

    The demonstrations do not tell which of them holds, so that the end may lie where any of them says, as likely as it
    is: the second moment of that mixture about the chosen place. Where none contradicts, they are fused instead.
    """
    targets = _targets(endpoint, poses, 1, leave_out=False) if len(endpoint.frames) > endpoint.required else []
    total = np.zeros((3, 3))
    for name, target in zip(_present(endpoint, poses), targets, strict=False):
        if _gap(targets[0], target)[0] >= CONFLICT:
            difference = target[0][0] - targets[0][0][0]
            total += endpoint.belief[endpoint.frames.index(name)] * np.outer(difference, difference)
    return total


def _present(endpoint: Endpoint, poses: Poses) -> list[tuple[str, str]]:
    """Frames that the scenes have."""
    return [frame for frame in endpoint.frames if frame[0] == ABSOLUTE or frame[0] in poses]


def target_turns(endpoint: Endpoint, poses: Poses, count: int, leave_out: bool = False) -> Array | None:
    """Required orientations (M, 4), world frame; parameters as in `target_positions`."""
    if not endpoint.turn_frames:
        return None
    targets, weights = [], []
    for (name, axes), values in zip(endpoint.turn_frames, endpoint.turn, strict=True):
        mean = average(values)
        residual = turn_between(mean, values)
        step = _means(residual, leave_out)
        local = turn_by(mean, step)
        pose = frame_pose(name, poses, count)[:, 3:]
        turned = compose(local, pose) if axes == "world" else compose(pose, local)
        targets.append(np.broadcast_to(turned, (count, 4)))
        weights.append(1.0 / (np.sum(residual**2) + 1e-6))
    share = np.array(weights)[:, None] / np.sum(weights)
    return average(np.stack(targets), np.broadcast_to(share, (len(targets), count)))


def warn_of_conflict(label: str, end: str, endpoint: Endpoint, poses: Poses) -> None:
    """Warn where another frame asks for a place that contradicts the chosen one."""
    if (endpoint.mask == 0.0).any():
        return
    present = [name for name, _ in _present(endpoint, poses)]
    targets = _targets(endpoint, poses, 1, leave_out=False)
    for name, target in zip(present[1:], targets[1:], strict=True):
        if _gap(targets[0], target)[0] >= CONFLICT:
            distance = float(np.linalg.norm(target[0] - targets[0][0]))
            warnings.warn(
                f"the {end} of {label!r}: {present[0]!r} and {name!r} contradict one another in this scene by "
                f"{distance:.3g} m. Name the one that counts: relevant={{{end!r}: [...]}}.",
                RuntimeWarning,
                stacklevel=4,
            )
