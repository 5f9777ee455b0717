"""The inertials of a URDF: which links have a mass or an inertia that no body can have.

Both engines load such a link without a word; what moves it then moves as nothing does.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

_ROUNDING = 1e-6  # of the largest principal moment: how far below zero one may be by the rounding of its file
_MOMENTS = ("ixx", "ixy", "ixz", "ixy", "iyy", "iyz", "ixz", "iyz", "izz")  # of the tensor, row by row


def impossible_inertials(path: Path) -> dict[str, str]:
    """Links whose inertial no body can have, and why; links without one are left out.

    Parameters
    ----------
    path : Path
        Of a URDF that `read_urdf` reads.
    """
    found = {}
    for link in ElementTree.parse(path).getroot().findall("link"):  # noqa: S314  a robot's own file, not a stranger's
        inertial = link.find("inertial")
        if inertial is None:
            continue
        reason = _why_impossible(inertial)
        if reason:
            found[str(link.get("name"))] = reason
    return found


def _why_impossible(inertial: ElementTree.Element) -> str:
    mass, tensor = inertial.find("mass"), inertial.find("inertia")
    try:
        weight = 0.0 if mass is None else float(mass.get("value", 0.0))
        moments = np.array([0.0 if tensor is None else float(tensor.get(name, 0.0)) for name in _MOMENTS]).reshape(3, 3)
    except ValueError as error:
        return f"what should be a number is none ({error})"
    if not (np.isfinite(weight) and weight >= 0.0):
        return f"its mass is {weight:g} kg"
    if not np.isfinite(moments).all():
        return "its inertia is not finite"
    principal = np.linalg.eigvalsh(moments)
    if principal[0] < -_ROUNDING * abs(principal[2]):
        return f"a principal moment of its inertia is {principal[0]:.3g} kg m^2"
    return ""
