"""Inverse kinematics: a configuration, or a whole joint path, that puts the tool where it should be.

Descents (`pft_exec.model.descent`) from a seed, then from the arm's named configurations, then from a fixed sequence of
others; along a path, each sample from the one before. All is deterministic and inside the soft limits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.exceptions import ConfigurationError
from pft_exec.geometry import Array, Pose, read_only, rotation_matrix
from pft_exec.model.arm import Arm
from pft_exec.model.descent import Descent, descend

POSITION_TOLERANCE = 1e-6  # m
ROTATION_TOLERANCE = 1e-6  # rad
_ITERATIONS = 60  # of one descent; those that arrive take about ten
_PATH_ITERATIONS = 20
_RANDOM_STARTS = 24


@dataclass(frozen=True, eq=False)
class InverseKinematics:
    """A configuration and how well it reaches.

    Parameters
    ----------
    configuration : (n,), rad
        Inside the soft limits; the nearest that was found where none reaches.
    found : bool
        Whether it reaches within 1e-6 m and 1e-6 rad.
    position_error, rotation_error : float, m and rad
    manipulability : float
        Smallest singular value of the Jacobian, m and rad mixed; 0 is singular.
    limit_margin : float, rad
        Distance of the nearest joint from its soft limit.
    """

    configuration: Array
    found: bool
    position_error: float
    rotation_error: float
    manipulability: float
    limit_margin: float


@dataclass(frozen=True, eq=False)
class JointPath:
    """A joint path for N tool poses.

    Parameters
    ----------
    samples : (N, n), rad
    position_error, rotation_error : (N,), m and rad
        How far each sample's tool is from its pose.
    found : bool
        Whether every sample reaches within 1e-6 m and 1e-6 rad.
    manipulability : float
        Smallest along the path.
    limit_margin : float, rad
        Smallest along the path.
    """

    samples: Array
    position_error: Array
    rotation_error: Array
    found: bool
    manipulability: float
    limit_margin: float

    @property
    def worst_position_error(self) -> float:
        """Largest position error along the path, m."""
        return float(self.position_error.max())

    @property
    def worst_rotation_error(self) -> float:
        """Largest rotation error along the path, rad."""
        return float(self.rotation_error.max())


def solve_inverse_kinematics(
    arm: Arm, pose: Pose, seed: ArrayLike, *, posture: ArrayLike | None = None
) -> InverseKinematics:
    """Find a configuration that puts the tool at a pose.

    Parameters
    ----------
    arm : Arm
    pose : Pose
        Of the tool in the robot's base frame.
    seed : (n,), rad
        Where the search begins; where it fails, it goes on from the arm's named configurations and from
        a fixed sequence of others.
    posture : (n,) or None, rad
        What the redundant joint is drawn to; None is the seed.

    Returns
    -------
    InverseKinematics
        With ``found`` False and the nearest configuration where nothing reaches.

    Raises
    ------
    ConfigurationError
        If the seed or posture does not fit the arm.
    """
    start = _inside(arm, seed)
    drawn_to = start if posture is None else _inside(arm, posture)
    goal = pose.position, pose.rotation
    best = descend(arm, goal, start, drawn_to, _ITERATIONS)
    for begin in _other_starts(arm):
        if _is_reached(best.error):
            break
        other = descend(arm, goal, begin, drawn_to, _ITERATIONS)
        best = min(best, other, key=lambda descent: descent.size)
    return _judged(arm, best, start)


def follow_path(arm: Arm, positions: ArrayLike, quaternions: ArrayLike, seed: ArrayLike) -> JointPath:
    """Find a joint path that leads the tool along a path, each sample from the one before.

    Parameters
    ----------
    arm : Arm
    positions : (N, 3), m
        Of the tool in the robot's base frame.
    quaternions : (N, 4)
        Of the tool in the base frame, (x, y, z, w).
    seed : (n,), rad
        Near the first sample, such as the measured configuration; also the posture that the redundant joint
        is drawn to as the path goes on.

    Returns
    -------
    JointPath
        Where a pose is out of reach its sample is the nearest found, and its errors say so.

    Raises
    ------
    ConfigurationError
        If the seed does not fit the arm, or the path is not (N, 3) and (N, 4) with N of at least 1.
    """
    positions, quaternions = _checked_path(positions, quaternions)
    posture = _inside(arm, seed)
    q = solve_inverse_kinematics(arm, Pose(positions[0], quaternions[0]), posture).configuration
    descents = []
    for goal in zip(positions, rotation_matrix(quaternions), strict=True):
        descents.append(descend(arm, goal, q, posture, _PATH_ITERATIONS))
        q = descents[-1].configuration
    return _path(arm, descents)


def _checked_path(positions: ArrayLike, quaternions: ArrayLike) -> tuple[Array, Array]:
    positions, quaternions = np.asarray(positions, dtype=float), np.asarray(quaternions, dtype=float)
    count = len(positions)
    if count == 0 or positions.shape != (count, 3) or quaternions.shape != (count, 4):
        raise ConfigurationError(
            f"a path has positions (N, 3) and quaternions (N, 4) (x, y, z, w), N of at least 1; got shapes "
            f"{positions.shape} and {quaternions.shape}."
        )
    return positions, quaternions


def _inside(arm: Arm, q: ArrayLike) -> Array:
    """Take the nearest configuration inside the soft limits."""
    arm.check_configuration(q)
    inside: Array = np.clip(np.asarray(q, dtype=float), arm.limits.lower, arm.limits.upper)
    return inside


def _other_starts(arm: Arm) -> Iterator[Array]:
    for name in arm.configurations:
        yield _inside(arm, arm.configuration(name))
    generator = np.random.default_rng(0)
    lower, upper = np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)
    for _ in range(_RANDOM_STARTS):
        yield generator.uniform(lower, upper)


def _is_reached(error: Array) -> bool:
    return bool(np.linalg.norm(error[:3]) <= POSITION_TOLERANCE and np.linalg.norm(error[3:]) <= ROTATION_TOLERANCE)


def _judged(arm: Arm, descent: Descent, seed: Array) -> InverseKinematics:
    configuration = _unwound(arm, descent.configuration, seed)
    return InverseKinematics(
        configuration=read_only(configuration),
        found=_is_reached(descent.error),
        position_error=float(np.linalg.norm(descent.error[:3])),
        rotation_error=float(np.linalg.norm(descent.error[3:])),
        manipulability=_manipulability(descent.jacobian),
        limit_margin=float(arm.limits.margin(configuration).min()),
    )


def _unwound(arm: Arm, q: Array, seed: Array) -> Array:
    """Take whole turns out of joints that may turn without end, towards the seed."""
    turns = np.where(arm.limits.upper - arm.limits.lower > 4.0 * np.pi, np.round((seed - q) / (2.0 * np.pi)), 0.0)
    unwound: Array = q + 2.0 * np.pi * turns
    return unwound


def _manipulability(jacobian: Array) -> float:
    return float(np.linalg.svd(jacobian, compute_uv=False)[..., -1].min())


def _path(arm: Arm, descents: list[Descent]) -> JointPath:
    samples = np.array([descent.configuration for descent in descents])
    errors = np.array([descent.error for descent in descents])
    return JointPath(
        samples=read_only(samples),
        position_error=read_only(np.linalg.norm(errors[:, :3], axis=1)),
        rotation_error=read_only(np.linalg.norm(errors[:, 3:], axis=1)),
        found=all(_is_reached(error) for error in errors),
        manipulability=_manipulability(np.array([descent.jacobian for descent in descents])),
        limit_margin=float(arm.limits.margin(samples).min()),
    )
