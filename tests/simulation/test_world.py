"""The world as whoever teaches or executes sees it: poses, commands, pushes, set-up, refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.demonstration import Scene
from pft_exec.description import TaskDescription
from pft_exec.exceptions import (
    MissingObjectError,
    SimulationError,
    UnknownArmError,
    UnknownRobotError,
    UnknownTaskError,
)
from pft_exec.geometry import Pose, rotate
from pft_exec.model import RobotModel
from pft_exec.simulation import World
from tests.simulation.runs import float_arm

ASIDE = Pose([-1.5, 0.0, 0.0])
TURNED = Pose([-0.3, 0.1, 0.05], [0.0, 0.0, np.sin(0.4), np.cos(0.4)])


def test_names_load_what_they_name() -> None:
    with World("pr2", "tabletop", seed=2) as world:
        assert world.robot.name == "pr2"
        assert world.task.labels == ("reach", "put_on_table", "move_left", "go_home")
        assert world.scene.objects.keys() == {"bottle", "mat", "cup"}


def test_a_scene_stands_where_it_was_put(world: World) -> None:
    asked = world.draw_scene(11)
    world.reset(asked)
    for name in asked:
        np.testing.assert_allclose(world.scene[name].array, asked[name].array, rtol=0, atol=1e-12)
        assert world.pose(name) == world.scene[name]


def test_objects_stand_still_on_the_table(world: World) -> None:
    before = world.scene
    for _ in range(500):
        world.step()
    for name in before:
        assert np.abs(world.scene[name].position - before[name].position).max() < 5e-5


def test_time_is_whole_steps(world: World) -> None:
    for _ in range(10):
        world.step()
    assert world.time == 10 * world.physics_step
    world.reset()
    assert world.time == 0.0


def test_a_control_period_is_whole_steps(robot: RobotModel, task: TaskDescription) -> None:
    with World(robot, task, control_period=2e-3, physics_step=5e-4) as world:
        assert world.steps_per_period == 4


@pytest.mark.parametrize("periods", [(1.5e-3, 1e-3), (5e-4, 1e-3)])
def test_clocks_that_do_not_fit_are_refused(
    robot: RobotModel, task: TaskDescription, periods: tuple[float, float]
) -> None:
    with pytest.raises(SimulationError, match="whole number of physics steps"):
        World(robot, task, control_period=periods[0], physics_step=periods[1])
    with pytest.raises(SimulationError, match="must be positive"):
        World(robot, task, physics_step=0.0)


def test_the_default_arm_is_the_right_one_or_the_only_one(world: World) -> None:
    assert world.arm_name() == "right"
    with World("wam", world.task, world.scene) as single:
        assert single.arm_name() == "arm"


def test_tool_pose_agrees_with_the_model_in_a_turned_base(robot: RobotModel, task: TaskDescription) -> None:
    with World(robot, replace(task, robot_base=TURNED), World(robot, task).scene) as world:
        q = world.arm("right").configuration("teach")
        world.place("right", q)
        expected = TURNED @ world.arm("right").forward(q)
        np.testing.assert_allclose(world.tool("right").array, expected.array, rtol=0, atol=1e-12)
        position, quaternion, velocity = world.tool_motion("right")
        np.testing.assert_allclose(np.append(position, quaternion), expected.array, rtol=0, atol=1e-12)
        np.testing.assert_allclose(velocity, np.zeros(6), rtol=0, atol=1e-12)


@pytest.mark.parametrize("base", [ASIDE, TURNED], ids=["straight", "turned"])
def test_a_push_acts_along_the_axes_of_the_world(world: World, base: Pose) -> None:
    """Pushes of one step add up; what they do to the joints is J^T F less friction, F turned into the base frame.

    With the bare arm of the WAM, since the fingers of the PR2 give way a little.
    """
    with World("wam", replace(world.task, robot_base=base), world.scene) as single:
        model = single.arm()
        q, v = single.state()
        single.command("arm", model.gravity(q))
        single.push("arm", [0.0, 25.0, 0.0])
        single.push("arm", [0.0, 5.0, 0.0], [0.2, 0.0, 0.0])
        single.step()
        wrench = rotate(base.inverse().quaternion, np.array([[0.0, 30.0, 0.0], [0.2, 0.0, 0.0]])).ravel()
        dynamics = model.dynamics(q, v)
        driven = dynamics.mass_matrix @ single.state()[1] / single.physics_step
        assert (np.abs(dynamics.jacobian.T @ wrench - driven) <= model.friction.coulomb + 1e-6).all()
        assert single.tool_motion()[2][1] > 1e-3


def test_a_push_lasts_one_step(world: World) -> None:
    float_arm(world, "right", 1)
    world.push("right", [0.0, 30.0, 0.0])
    world.step()
    speed = np.abs(world.state("right")[1]).max()
    float_arm(world, "right", 100)
    assert np.abs(world.state("right")[1]).max() < 0.1 * speed


def test_a_reset_puts_named_arms_where_told_and_parks_the_others(world: World) -> None:
    teach = world.arm("left").configuration("teach")
    world.reset(configurations={"left": teach})
    np.testing.assert_array_equal(world.state("left")[0], teach)
    np.testing.assert_array_equal(world.state("right")[0], world.arm("right").configuration("parked"))
    world.reset()
    np.testing.assert_array_equal(world.state("right")[0], world.arm("right").configuration("work"))


def test_the_task_is_mirrored_for_the_other_arm(world: World) -> None:
    assert world.task_for("right").mirror is None
    assert world.task_for("left").mirror == world.base


def test_unknown_names_are_refused_with_the_nearest(world: World) -> None:
    with pytest.raises(UnknownArmError, match="Did you mean 'right'"):
        world.tool("rigth")
    with pytest.raises(UnknownArmError, match="'left', 'right'"):
        world.reset(configurations={"middle": np.zeros(7)})
    with pytest.raises(UnknownRobotError, match="Did you mean 'pr2'"):
        World("pr3", "tabletop")
    with pytest.raises(UnknownTaskError, match="Did you mean 'tabletop'"):
        World("pr2", "tabletopp")
    with pytest.raises(MissingObjectError, match="Did you mean 'bottle'"):
        world.pose("botle")


def test_a_scene_that_does_not_fit_the_task_is_refused(world: World) -> None:
    objects = dict(world.scene.objects)
    with pytest.raises(MissingObjectError, match="Task 'tabletop' needs it"):
        world.reset(Scene({"bottle": objects["bottle"], "mat": objects["mat"]}))
    with pytest.raises(MissingObjectError, match="no placed object of the task is named 'bin'"):
        world.reset(Scene(objects | {"bin": objects["cup"]}))


def test_a_scene_of_nothing_is_a_scene_and_no_invitation_to_draw_one(world: World) -> None:
    with pytest.raises(MissingObjectError, match="Task 'tabletop' needs it"):
        World("wam", world.task, Scene({}))


def test_values_that_do_not_fit_are_refused(world: World) -> None:
    with pytest.raises(SimulationError, match=r"torque of an arm must have shape \(7,\), N m; got \(6,\)"):
        world.command("right", np.zeros(6))
    with pytest.raises(SimulationError, match="torque of an arm must be finite"):
        world.command("right", [np.nan] * 7)
    with pytest.raises(SimulationError, match=r"force must have shape \(3,\), N"):
        world.push("right", [1.0])
    with pytest.raises(SimulationError, match="torque must be finite"):
        world.push("right", [1.0, 0.0, 0.0], [np.inf, 0.0, 0.0])
    with pytest.raises(SimulationError, match="configuration of an arm must be finite"):
        world.place("right", [np.nan] * 7)


def test_a_placement_beyond_the_limits_is_refused(world: World) -> None:
    q = np.array(world.state("right")[0])
    q[3] = 0.5
    with pytest.raises(SimulationError, match=r"joint 'r_elbow_flex_joint' cannot stand at 0.5000 rad"):
        world.place("right", q)


def test_a_closed_world_closes_again_and_says_so(robot: RobotModel, task: TaskDescription) -> None:
    world = World(robot, task)
    world.close()
    world.close()
    assert not world.is_open
    with pytest.raises(SimulationError, match="the world is closed"):
        world.step()
    with pytest.raises(SimulationError, match="the world is closed"):
        _ = world.scene
    with pytest.raises(SimulationError, match="the world is closed"):
        world.pose("bottle")
