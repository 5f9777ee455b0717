"""What stands in a world besides the robot: objects, what fills them, and what the grippers hold of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from pft_exec.demonstration import Scene
from pft_exec.description import TaskDescription, VesselShape
from pft_exec.exceptions import MissingObjectError, SimulationError
from pft_exec.geometry import Array, Pose
from pft_exec.simulation.engine import Engine
from pft_exec.simulation.grasp import Grasps
from pft_exec.simulation.liquid import Liquid, places_in
from pft_exec.simulation.object_body import ObjectBody
from pft_exec.simulation.robot_body import RobotBody


@dataclass(frozen=True)
class SetUp:
    """How grippers and vessels are when a run begins.

    Parameters
    ----------
    holding : mapping of arm to object
        The pads close about the object where that stands in the scene.
    opened : tuple of str
        Arms whose gripper is open.
    liquid : str or None
        The vessel that holds the task's liquid; only then are vessels hollow.
    """

    holding: Mapping[str, str] = field(default_factory=dict)
    opened: tuple[str, ...] = ()
    liquid: str | None = None

    @property
    def is_plain(self) -> bool:
        """Whether nothing is held and nothing filled, so that nothing has to settle."""
        return not self.holding and self.liquid is None


class Contents:
    """Objects of a task in an engine, the balls in them, and the grasps on them.

    Parameters
    ----------
    engine : Engine
    task : TaskDescription
    scene : Scene
        Poses of the placed objects, world frame.
    robot : RobotBody
    set_up : SetUp
    grasp : "friction" or "constraint"

    Raises
    ------
    MissingObjectError
        If the set-up names an object that the task has not.
    SimulationError
        If the liquid is to be in what is no vessel.
    """

    def __init__(
        self, engine: Engine, task: TaskDescription, scene: Scene, robot: RobotBody, set_up: SetUp, grasp: str
    ) -> None:
        self._engine, self._task = engine, task
        self.objects = {
            name: ObjectBody(
                engine, item, item.fixed.pose if item.fixed is not None else scene[name], set_up.liquid is not None
            )
            for name, item in task.objects.items()
        }
        self.liquid = None if set_up.liquid is None else self._filled(set_up.liquid)
        self.grasps = Grasps(engine, robot, self.objects, grasp)
        for name in set_up.holding.values():
            self.object(name)

    def object(self, name: str) -> ObjectBody:
        """One of the task's objects, placed or fixed."""
        if name not in self.objects:
            raise MissingObjectError("object of the task", name, self.objects)
        return self.objects[name]

    def _filled(self, name: str) -> Liquid:
        item = self.object(name)
        if not isinstance(item.description.shape, VesselShape):
            raise SimulationError(f"the liquid is to be in {name!r}, which is no vessel.")
        places = item.pose.apply(places_in(self._task.liquid, item.description.shape))
        return Liquid(self._engine, self._task.liquid, places)

    @property
    def scene(self) -> Scene:
        """Poses of the placed objects now, world frame."""
        return Scene({name: self.objects[name].pose for name in self._task.placed})

    @property
    def poses(self) -> Array:
        """The same, (M, 7), in the order of the task."""
        return np.array([self.objects[name].pose.array for name in self._task.placed]).reshape(-1, 7)

    @property
    def balls(self) -> Array:
        """Where the liquid is, (S, 3), m, world frame; (0, 3) where there is none."""
        return np.zeros((0, 3)) if self.liquid is None else self.liquid.positions

    def load(self, name: str, tool: Pose) -> tuple[float, Array]:
        """Mass, kg, of an object and of the liquid in it, and their center (3,), m, in the frame of a tool."""
        item = self.objects[name]
        bodies = [(item.description.mass, item.pose.position)]
        if self.liquid is not None:
            near = np.abs(item.pose.inverse().apply(self.balls))
            size = item.description.shape
            bodies += [
                (self.liquid.mass, place)
                for place, (x, y, z) in zip(self.balls, near, strict=True)
                if x * x + y * y <= size.outline**2 and z <= 0.5 * size.height
            ]
        mass = sum(weight for weight, _ in bodies)
        center = sum((weight * place for weight, place in bodies), np.zeros(3)) / mass
        return mass, tool.inverse().apply(center)

    def show(self, poses: Array, balls: Array) -> None:
        """Put objects (M, 7) and balls (S, 3) where they once were, for a picture."""
        for name, pose in zip(self._task.placed, poses, strict=True):
            self.objects[name].place(Pose.from_array(pose))
        if len(balls) and self.liquid is None:
            self.liquid = Liquid(self._engine, self._task.liquid, balls)
        if self.liquid is not None and len(balls):
            self.liquid.place(balls)
