"""A command: what the controller decided in one control period, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from pft_exec.geometry import Array


@dataclass(frozen=True, eq=False)
class Command:
    """Motor torques of one control period, with what they came from.

    Parameters
    ----------
    torque : (n,), N m
        Within the limits.
    acceleration : (n,), rad/s^2
        That the torques should give; zeros where gravity alone is compensated.
    configuration, velocity, reference_acceleration : (n,), rad, rad/s, rad/s^2
        The joint reference; the measured state where there is none.
    position, quaternion : (3,), m, and (4,), (x, y, z, w)
        The tool reference, base frame.
    phase : float
        Of the reference along its tube.
    error : (6,), m, rad
        Of the measured tool: position in base axes, rotation vector in the reference tool frame.
    torque_active, bound_active : (n,), bool
        Joints at their torque limit, and at a position, velocity or acceleration bound.
    status : str
        The solver's word, or why there is no solution.
    fallback : bool
        Whether this is damped gravity compensation because nothing else could be had.
    costs : mapping of str to float
        What each objective ("tracking", "posture", ...) costs at the solution; empty where nothing was solved.
    distance : float, m
        Smallest distance between bodies that are kept apart; infinite where none are near.
    apart_active : tuple of str
        Pairs whose distance limits the motion now, such as "r_forearm_link / bottle".
    solve_time : float, s
        Of the solver alone; 0 where nothing was solved.
    iterations : int
        Of the solver.
    """

    torque: Array
    acceleration: Array
    configuration: Array
    velocity: Array
    reference_acceleration: Array
    position: Array
    quaternion: Array
    phase: float
    error: Array
    torque_active: NDArray[np.bool_]
    bound_active: NDArray[np.bool_]
    status: str
    fallback: bool
    costs: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    distance: float = float("inf")
    apart_active: tuple[str, ...] = ()
    solve_time: float = 0.0
    iterations: int = 0
