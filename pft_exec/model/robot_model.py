"""A robot as the controller knows it: its description, and one mechanism per arm."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pinocchio

from pft_exec.description import ArmDescription, RobotDescription, load_robot_description
from pft_exec.description.urdf import read_urdf
from pft_exec.exceptions import DescriptionError, UnknownArmError
from pft_exec.model.arm import Arm
from pft_exec.model.arm_geometry import arm_geometry
from pft_exec.model.counterbalance import Counterbalance
from pft_exec.model.limits import joint_friction, joint_limits


class RobotModel:
    """A robot and its arms; made by `load_robot`.

    Parameters
    ----------
    description : RobotDescription

    Raises
    ------
    DescriptionError
        If pinocchio cannot make a mechanism of the URDF.
    """

    def __init__(self, description: RobotDescription) -> None:
        self.description = description
        self._urdf = read_urdf(description.urdf)
        self._model = _mechanism(description.urdf)
        self._arms = {name: self._built(arm) for name, arm in description.arms.items()}

    @property
    def name(self) -> str:
        """Name of the robot, such as "pr2"."""
        return self.description.name

    @property
    def arms(self) -> tuple[str, ...]:
        """Names of the arms."""
        return tuple(self._arms)

    def __repr__(self) -> str:
        return f"RobotModel({self.name!r}, arms {', '.join(map(repr, self.arms))})"

    def arm(self, name: str) -> Arm:
        """Look up an arm; the same object every time.

        Raises
        ------
        UnknownArmError
            If the robot has no arm of that name.
        """
        if name not in self._arms:
            raise UnknownArmError("arm", name, self.arms, f"The robot is {self.name!r}.")
        return self._arms[name]

    def _built(self, description: ArmDescription) -> Arm:
        held = [self._model.getJointId(name) for name in self._model.names[1:] if name not in description.joints]
        model = pinocchio.buildReducedModel(self._model, held, pinocchio.neutral(self._model))
        postures = tuple(np.array(posture) for posture in description.configurations.values())
        urdf, whole = self.description.urdf, self._model
        return Arm(
            description,
            model,
            joint_limits(description, self._urdf),
            joint_friction(description),
            Counterbalance(model, description.counterbalance, description.joints),
            cache(lambda: arm_geometry(urdf, whole, model, held, postures)),
        )


def _mechanism(urdf: Path) -> pinocchio.Model:
    try:
        return pinocchio.buildModelFromUrdf(str(urdf))
    except (ValueError, RuntimeError) as error:
        raise DescriptionError(f"{urdf}: cannot be made a mechanism: {error}.") from error


def load_robot(name_or_path: str | Path, tool: str | None = None) -> RobotModel:
    """Load a robot.

    Parameters
    ----------
    name_or_path : str or Path
        Name of a robot that ships with the package, or a folder with a ``robot.toml``.
    tool : str or None
        An optional attachment that the robot offers; None is the bare robot.

    Raises
    ------
    UnknownRobotError
        If there is no such robot.
    UnknownNameError
        If the robot offers no such tool.
    DescriptionError
        If its folder cannot be read as a robot.
    """
    return RobotModel(load_robot_description(name_or_path, tool))
