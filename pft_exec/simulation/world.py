"""The world: a robot before a task's objects, stepped at a fixed physics step.

Whoever teaches or executes reads states and poses here, commands torques and steps; nothing else touches the engine.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import ArrayLike

from pft_exec.demonstration import Scene
from pft_exec.description import TaskDescription, load_task
from pft_exec.exceptions import SimulationError, UnknownArmError
from pft_exec.geometry import Array, Pose
from pft_exec.model import Arm, RobotModel, load_robot
from pft_exec.simulation.base_frame import BaseFrame
from pft_exec.simulation.camera import Camera
from pft_exec.simulation.checks import check_within_limits, checked, checked_scene, steps_per_period
from pft_exec.simulation.contents import Contents, SetUp
from pft_exec.simulation.disturbance import Encoder, Mismatch
from pft_exec.simulation.engine import Engine
from pft_exec.simulation.placement import default_arm, draw_reachable_scene, standing_configuration, task_for
from pft_exec.simulation.replay import WorldState
from pft_exec.simulation.robot_body import RobotBody

SETTLING_TIME = 0.3
"""s for which grasps and liquid settle at set-up, before time begins."""


class World:
    """A robot and a task's objects in one physics engine; several worlds may live in one process.

    Every arm is braked until it is commanded. The same calls give bit-identical states, also after a `reset`.

    Parameters
    ----------
    robot : RobotModel, or name or path of one
    task : TaskDescription, or name or path of one
    scene : Scene or None
        Poses of the task's placed objects, world frame; None draws one the default arm reaches, from `seed`.
    gui : bool
        Open PyBullet's window, in which the mouse drags the arm.
    seed : int
        For the scene, where none is given, and for what happens in this world where no other seed is named.
    control_period, physics_step : float, s
        The period is a whole number of steps.
    mismatch : Mismatch or None
        How the plant differs from the model, also after each reset; None: not at all.
    grasp : "friction" or "constraint"
        What holds an object in a gripper: see `pft_exec.simulation.grasp`.

    Raises
    ------
    SimulationError
        If the clocks do not fit, or PyBullet cannot start or load the robot.
    MissingObjectError
        If the scene lacks an object of the task.
    UnreachableError
        If no scene is given and none can be drawn that the arm reaches.
    """

    def __init__(
        self,
        robot: RobotModel | str | Path,
        task: TaskDescription | str | Path,
        scene: Scene | None = None,
        gui: bool = False,
        seed: int = 0,
        *,
        control_period: float = 1e-3,
        physics_step: float = 1e-3,
        mismatch: Mismatch | None = None,
        grasp: str = "friction",
    ) -> None:
        self.robot = robot if isinstance(robot, RobotModel) else load_robot(robot)
        self.task = task if isinstance(task, TaskDescription) else load_task(task)
        self.seed = seed
        self.control_period, self.physics_step = control_period, physics_step
        self._base_frame = BaseFrame(self.base)
        self._mismatch, self._grasp = mismatch, grasp
        self.steps_per_period = steps_per_period(control_period, physics_step)
        self._scene = checked_scene(self.task, self.draw_scene(seed) if scene is None else scene)
        self._engine = Engine(physics_step, gui)
        self.camera = Camera(self._engine.client, self.base)
        self._build({}, SetUp())

    def _build(self, configurations: Mapping[str, ArrayLike], set_up: SetUp) -> None:
        """Load everything into an empty engine, always in the same order."""
        self._engine.clear(liquid=set_up.liquid is not None)
        self._count = 0
        self._robot_body: RobotBody | None = RobotBody(
            self._engine, self.robot, self.base, self._mismatch, self.steps_per_period
        )
        self._contents = Contents(self._engine, self.task, self._scene, self._robot_body, set_up, self._grasp)
        at_work = set(configurations) or {self.arm_name()}
        for name in self.robot.arms:
            standing = standing_configuration(self.arm(name), is_parked=name not in at_work)
            self.place(name, configurations.get(name, standing))
        self._settle(set_up)

    def _settle(self, set_up: SetUp) -> None:
        """Open and close grippers, and let what is held and filled come to rest before time begins."""
        for name in set_up.opened:
            self._body.place_gripper(self._gripping(name))
        for name, held in set_up.holding.items():
            self._contents.grasps.put(self._gripping(name), held, self.tool(name))
        if not set_up.is_plain:
            for _ in range(round(SETTLING_TIME / self.physics_step)):
                self.step()
        self._count = 0

    @property
    def base(self) -> Pose:
        """Pose of the robot's base, world frame."""
        return self.task.robot_base

    @property
    def scene(self) -> Scene:
        """Poses of the task's placed objects now, world frame."""
        return self._inside.scene

    @property
    def _inside(self) -> Contents:
        """What is in the world, as long as it is open."""
        if not self.is_open:
            raise SimulationError("the world is closed; open another.")
        return self._contents

    @property
    def time(self) -> float:
        """Time since the last reset, s: whole physics steps."""
        return self._count * self.physics_step

    def arm_name(self, arm: str | None = None) -> str:
        """Name of an arm; None is the only one, else "right".

        Raises
        ------
        UnknownArmError
            If the robot has no such arm.
        """
        name = default_arm(self.robot) if arm is None else arm
        if name not in self.robot.arms:
            raise UnknownArmError("arm", name, self.robot.arms, f"The robot is {self.robot.name!r}.")
        return name

    def arm(self, arm: str | None = None) -> Arm:
        """The model of an arm; None is the default one."""
        return self.robot.arm(self.arm_name(arm))

    def task_for(self, arm: str | None = None) -> TaskDescription:
        """The task as it is for an arm: as written for the default one, mirrored for the other."""
        return task_for(self.robot, self.task, self.arm_name(arm))

    def state(self, arm: str | None = None) -> tuple[Array, Array]:
        """Measured configuration (n,), rad, and velocity (n,), rad/s, of an arm now."""
        return self._body.arm_state(self.arm_name(arm))

    def true_state(self, arm: str | None = None) -> tuple[Array, Array]:
        """Configuration (n,), rad, and velocity (n,), rad/s, of an arm as they are, to judge by, never to control."""
        return self._body.true_state(self.arm_name(arm))

    @property
    def mismatch(self) -> Mismatch:
        """How the plant differs from the model after each reset."""
        return self._mismatch or Mismatch()

    def disturb(self, mismatch: Mismatch) -> None:
        """Let the plant differ from the model in another way, from now until the next reset."""
        self._body.disturb(mismatch)

    def set_encoder(self, arm: str, encoder: Encoder | None) -> None:
        """Let an arm's encoders report something else until the next reset; None mends them."""
        self._body.set_encoder(self.arm_name(arm), encoder)

    def tool(self, arm: str | None = None) -> Pose:
        """Pose of an arm's tool now, world frame; by the model, from the measured configuration."""
        return self._base_frame.to_world(self.arm(arm).forward(self.state(arm)[0]))

    def true_tool(self, arm: str | None = None) -> Pose:
        """Pose of an arm's tool now, world frame, from where its joints are: to judge by, never to control."""
        return self._base_frame.to_world(self.arm(arm).forward(self.true_state(arm)[0]))

    def tool_motion(self, arm: str | None = None) -> tuple[Array, Array, Array]:
        """Position (3,), m, quaternion (4,), (x, y, z, w), and velocity (6,) of an arm's true tool now, world frame.

        The velocity is linear, m/s, then angular, rad/s. As `tool`, but fast enough for every physics step.
        """
        name = self.arm_name(arm)
        return self._base_frame.motion_to_world(self.robot.arm(name).dynamics(*self._body.true_state(name)))

    def command(self, arm: str, torque: ArrayLike) -> None:
        """Set an arm's motor torque (n,), N m, for the coming physics steps, until it is set again; releases the brake.

        Beyond the limits the motor is saturated: `torque` says what acts.

        Raises
        ------
        SimulationError
            If the shape is wrong or a number is not finite.
        """
        name = self.arm_name(arm)
        self._body.command(name, checked(torque, len(self.robot.arm(name).joint_names), "torque of an arm", "N m"))

    def torque(self, arm: str | None = None) -> Array:
        """Motor torque (n,), N m, that acts in the coming step: the command within the limits."""
        return self._body.torque(self.arm_name(arm))

    def brake(self, arm: str | None = None, *, by_motors: bool = False) -> None:
        """Lock an arm where it is, until it is commanded again; by its motors: no stronger than they are."""
        (self._body.brake_by_motors if by_motors else self._body.brake)(self.arm_name(arm))

    def is_braked(self, arm: str | None = None) -> bool:
        """Whether an arm is locked, or brakes by its motors."""
        return self._body.is_braked(self.arm_name(arm))

    def push(self, arm: str, force: ArrayLike, torque: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Push at an arm's tool during the next physics step; pushes of one step add up.

        Parameters
        ----------
        arm : str
        force, torque : (3,), N and N m
            World frame, at the tool's origin.

        Raises
        ------
        SimulationError
            If a shape is wrong or a number is not finite.
        """
        wrench = np.stack([checked(force, 3, "force", "N"), checked(torque, 3, "torque", "N m")])
        self._body.push(self.arm_name(arm), self._base_frame.wrench_from_world(wrench))

    @property
    def _body(self) -> RobotBody:
        """The robot's body, as long as there is one."""
        if self._robot_body is None:
            raise SimulationError("the world is closed; open another.")
        return self._robot_body

    @property
    def is_open(self) -> bool:
        """Whether the simulation still runs."""
        return self._engine.is_open

    def step(self) -> None:
        """Advance by one physics step.

        Raises
        ------
        SimulationError
            If the world is closed.
        """
        for name in self.robot.arms:
            self._contents.grasps.update(name)
        self._body.actuate()
        self._engine.step()
        self._count += 1

    def gripper(self, arm: str | None = None) -> float:
        """Distance between the pads of an arm's gripper now, m; 0 for an arm without one."""
        name = self.arm_name(arm)
        return self._body.width(name) if self._body.has_gripper(name) else 0.0

    def set_gripper(self, arm: str, width: float) -> None:
        """Ask an arm's gripper for a distance between its pads, m; it moves there with bounded speed and force.

        Raises
        ------
        SimulationError
            If the arm has no gripper, or it does not open that far.
        """
        self._body.set_width(self._gripping(arm), width)

    def _gripping(self, arm: str) -> str:
        """Name of an arm that has a gripper."""
        name = self.arm_name(arm)
        if not self._body.has_gripper(name):
            raise SimulationError(f"arm {name!r} of robot {self.robot.name!r} has no gripper.")
        return name

    def has_gripper(self, arm: str | None = None) -> bool:
        """Whether an arm has fingers."""
        return self._body.has_gripper(self.arm_name(arm))

    def is_gripper_closed(self, arm: str | None = None) -> bool:
        """Whether an arm's gripper is told to be closed."""
        return self._body.is_closing(self.arm_name(arm))

    def grip(self, arm: str, closed: bool) -> None:
        """Tell an arm's gripper to close, on what is between its pads, or to open."""
        gripper = self.robot.description.arms[self.arm_name(arm)].gripper
        if gripper is not None:
            self.set_gripper(arm, gripper.closed_width if closed else gripper.open_width)

    def place(self, arm: str, configuration: ArrayLike) -> None:
        """Set up: put an arm, at rest and braked, into a configuration (n,), rad. No way to move while running.

        Raises
        ------
        SimulationError
            If the shape is wrong, a number is not finite, or a joint would lie beyond its limits.
        """
        name = self.arm_name(arm)
        model = self.robot.arm(name)
        q = checked(configuration, len(model.joint_names), "configuration of an arm", "rad")
        check_within_limits(model, q)
        self._body.place(name, q)

    def held(self, arm: str | None = None) -> str | None:
        """Name of the object that both pads of an arm's gripper press on; None where it holds none."""
        return self._contents.grasps.held(self.arm_name(arm))

    def load(self, name: str, arm: str | None = None) -> tuple[float, Array]:
        """Mass, kg, of an object with what is in it, and its center of mass (3,), m, in the frame of an arm's tool."""
        return self._contents.load(name, self.tool(arm))

    @property
    def liquid(self) -> Array:
        """Where the balls of the liquid are now, (S, 3), m, world frame; (0, 3) where there is none."""
        return self._contents.balls

    def pose(self, name: str) -> Pose:
        """Pose of an object now, world frame; of one alone, where `scene` looks at all."""
        return self._inside.object(name).pose

    def speed(self, name: str) -> float:
        """Speed of an object's middle now, m/s."""
        return self._inside.object(name).speed

    def reset(
        self,
        scene: Scene | None = None,
        configurations: Mapping[str, ArrayLike] | None = None,
        set_up: SetUp | None = None,
    ) -> None:
        """Set up anew: time 0, objects in a scene (None: the one of the last set-up), every arm braked.

        Parameters
        ----------
        scene : Scene or None
        configurations : mapping of arm to (n,), rad
            Where arms stand; those not named are parked. None puts the default arm to its working configuration.
        set_up : SetUp or None
            What grippers hold and what vessels are filled with; None: grippers are closed and empty, vessels solid.

        Raises
        ------
        MissingObjectError
            If the scene lacks an object of the task.
        UnknownArmError
            If `configurations` names an arm that the robot has not.
        """
        configurations = {self.arm_name(name): q for name, q in (configurations or {}).items()}
        if scene is not None:
            self._scene = checked_scene(self.task, scene)
        self._build(configurations, set_up or SetUp())

    def draw_scene(self, seed: int, arm: str | None = None, label: str | None = None) -> Scene:
        """Draw a placement of the objects that the task allows and the arm reaches; the same for the same seed.

        With a label, one for that motion; else one for every motion that needs no placements of its own.

        Raises
        ------
        UnreachableError
            If none of many drawn placements can be reached.
        """
        return draw_reachable_scene(self.robot, self.task, self.arm_name(arm), seed, label)

    def record_state(self) -> WorldState:
        """All that a picture of this instant needs."""
        return WorldState(self.time, self._body.sense()[0].copy(), self._contents.poses, self._contents.balls)

    def show_state(self, state: WorldState) -> None:
        """Put joints and objects where they were recorded, for a picture; time does not pass."""
        self._body.place_joints(state.joints)
        self._contents.show(state.objects, state.liquid)

    def close(self) -> None:
        """End the simulation; a second call does nothing."""
        self._robot_body = None
        self._engine.close()

    def __enter__(self) -> World:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
