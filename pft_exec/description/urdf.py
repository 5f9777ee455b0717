"""What a URDF says of its joints and links, read without a physics library: names, types and limits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from xml.etree import ElementTree

from pft_exec.exceptions import DescriptionError


@dataclass(frozen=True)
class UrdfJoint:
    """One joint as the URDF states it, in rad or m, N m or N.

    Parameters
    ----------
    lower, upper : float
        Hard stops.
    soft_lower, soft_upper : float
        Limits of the safety controller, inside the hard ones; the hard ones where none are stated.
    velocity, effort : float
        Largest speed and torque (force).
    """

    name: str
    kind: str
    parent: str
    child: str
    lower: float
    upper: float
    soft_lower: float
    soft_upper: float
    velocity: float
    effort: float


@dataclass(frozen=True)
class UrdfStructure:
    """Joints by name, link names in the order of the file, and the link that no joint moves."""

    joints: Mapping[str, UrdfJoint]
    links: tuple[str, ...]
    root: str

    def chain(self, link: str) -> tuple[UrdfJoint, ...]:
        """Joints from the root to `link`, in order."""
        above = {joint.child: joint for joint in self.joints.values()}
        joints: list[UrdfJoint] = []
        while link in above:
            joints.append(above[link])
            link = joints[-1].parent
        return tuple(reversed(joints))


def read_urdf(path: Path) -> UrdfStructure:
    """Read names, types and limits of a URDF.

    Raises
    ------
    DescriptionError
        If the file is missing, is no URDF, or has not exactly one root link.
    """
    try:
        tree = ElementTree.parse(path).getroot()  # noqa: S314  a robot's own file, not a stranger's
        joints = {joint.name: joint for joint in map(_joint, tree.findall("joint"))}
        links = tuple(link.attrib["name"] for link in tree.findall("link"))
    except OSError as error:
        raise DescriptionError(f"{path}: cannot be read: {error.strerror}.") from error
    except (ElementTree.ParseError, KeyError, ValueError, AttributeError) as error:
        raise DescriptionError(f"{path}: is not a URDF: {error}.") from error
    children = {joint.child for joint in joints.values()}
    roots = [link for link in links if link not in children]
    if len(roots) != 1:
        raise DescriptionError(f"{path}: expected one root link, got {roots}.")
    return UrdfStructure(MappingProxyType(joints), links, roots[0])


def _joint(element: ElementTree.Element) -> UrdfJoint:
    limit, safety = element.find("limit"), element.find("safety_controller")
    lower, upper = _number(limit, "lower", -math.inf), _number(limit, "upper", math.inf)
    return UrdfJoint(
        name=element.attrib["name"],
        kind=element.attrib["type"],
        parent=_link(element, "parent"),
        child=_link(element, "child"),
        lower=lower,
        upper=upper,
        soft_lower=_number(safety, "soft_lower_limit", lower),
        soft_upper=_number(safety, "soft_upper_limit", upper),
        velocity=_number(limit, "velocity", math.inf),
        effort=_number(limit, "effort", math.inf),
    )


def _link(joint: ElementTree.Element, end: str) -> str:
    element = joint.find(end)
    if element is None:
        raise ValueError(f"joint {joint.attrib['name']!r} has no {end}")
    return element.attrib["link"]


def _number(element: ElementTree.Element | None, attribute: str, default: float) -> float:
    return default if element is None else float(element.attrib.get(attribute, default))
