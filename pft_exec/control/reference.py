"""A reference: where the joints should be at an instant, and how fast they should move.

There is one kind. A transition, a path along a tube and a posture to hold all give joint references; the tool's
reference is always their forward kinematics. So the two can never disagree, and where one reference takes over from
another, nothing else in the controller changes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pft_exec.geometry import Array, read_only


@dataclass(frozen=True, eq=False)
class JointReference:
    """One instant of a reference for n joints.

    Parameters
    ----------
    configuration, velocity, acceleration : (n,), rad, rad/s, rad/s^2
    phase : float
        Where along its tube the reference is, in [0, 1]; 0 where there is none.
    """

    configuration: Array
    velocity: Array
    acceleration: Array
    phase: float = 0.0


Reference = Callable[[float], JointReference]
"""From the clock, s since the reference began, to an instant of it."""


def joined(first: Callable[[float], tuple[Array, Array, Array]], until: float, then: Reference) -> Reference:
    """A reference that follows `first` (configuration, velocity, acceleration) up to `until`, s, and `then` after it.

    Both have the same clock. The phase is that of `then` throughout, so gains do not step at the seam.
    """

    def at(time: float) -> JointReference:
        later = then(time)
        return later if time >= until else JointReference(*first(time), later.phase)

    return at


def holding(configuration: Array) -> Reference:
    """A reference that stays at a configuration (n,), rad."""
    rest = read_only(0.0 * configuration)
    still = JointReference(read_only(configuration), rest, rest)
    return lambda _: still
