"""Views: the whole arm, what stands before it and the workspace are in the picture, of any robot, and fill it."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pybullet
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pft_exec.description import load_task
from pft_exec.geometry import Array
from pft_exec.model import load_robot
from pft_exec.simulation import View, World, whole_view
from pft_exec.simulation.view import camera_axes, nearest_view

ASPECT = 4.0 / 3.0


def seen(points: Array, eye: Array, target: Array, field_of_view: float) -> Array:
    """Where points (M, 3) are in a picture (M, 2): from -1 to 1 inside it; not finite behind the camera."""
    axes = camera_axes(np.asarray(target) - eye)
    across, up, depth = axes @ (points - eye).T
    half = np.where(depth > 0.0, depth, np.nan) * np.tan(0.5 * np.radians(field_of_view))
    return np.stack([across / (ASPECT * half), up / half], axis=1)


def of_view(view: View, world: World, points: Array) -> Array:
    eye, target = world.base.apply([view.eye, view.target])
    return seen(points, eye, target, view.field_of_view)


def boxes_in_engine(world: World, arm: str) -> Array:
    """Corners (M, 3) of the boxes that the engine has about everything that the arm's joints move."""
    body, client = world._body.body, world._engine.client
    pybullet.performCollisionDetection(physicsClientId=client)
    moved: set[int] = set()
    for link in range(pybullet.getNumJoints(body, physicsClientId=client)):
        info = pybullet.getJointInfo(body, link, physicsClientId=client)
        if info[1].decode() in world.arm(arm).joint_names or info[16] in moved:
            moved.add(link)
    boxes = [pybullet.getAABB(body, link, physicsClientId=client) for link in sorted(moved)]
    return np.array([corner for low, high in boxes for corner in product(*zip(low, high, strict=True))])


@given(st.integers(0, 2**31))
def test_the_nearest_view_holds_all_points_and_no_nearer_one_does(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(0.0, 0.5, (rng.integers(2, 40), 3)) * rng.uniform(0.1, 2.0, 3)
    direction = np.array([*rng.normal(size=2), rng.uniform(-1.0, 0.5)])
    eye, target = nearest_view(points, direction, 36.0, ASPECT)
    np.testing.assert_allclose(camera_axes(target - eye), camera_axes(direction), atol=1e-9)
    there = seen(points, eye, target, 36.0)
    assert np.abs(there).max() <= 0.94 + 1e-9
    reached = np.stack([there.min(axis=0), there.max(axis=0)])
    touches = np.isclose(np.abs(reached), 0.94, atol=1e-6).all(axis=0)
    nearest = ((points - eye) @ camera_axes(direction)[2]).min()
    assert nearest >= 0.3 - 1e-9
    assert touches.any() or nearest == pytest.approx(0.3), "points touch both edges: nothing nearer holds them"


@pytest.mark.parametrize(("robot", "task", "arm"), [("pr2", "bottle", "right"), ("pr2", "bottle", "left")])
def test_the_whole_arm_is_in_the_picture_of_either_side(robot: str, task: str, arm: str) -> None:
    with World(robot, task) as world:
        for name in world.arm(arm).configurations:
            world.reset(configurations={arm: world.arm(arm).configuration(name)})
            there = of_view(whole_view(world, arm), world, boxes_in_engine(world, arm))
            assert np.abs(there).max() <= 1.0


@pytest.mark.parametrize("task", ["anchor", "cable", "ball_bin"])
def test_the_elbow_of_an_arm_that_reaches_over_its_base_is_in_the_picture(task: str) -> None:
    with World(load_robot("wam", tool="gripper"), task) as world:
        for elbow in (0.5, 1.5, 2.5):
            world.reset(configurations={"arm": [0.0, 0.2, 0.0, elbow, 0.0, 0.5, 0.0]})
            there = of_view(whole_view(world, "arm"), world, boxes_in_engine(world, "arm"))
            assert np.abs(there).max() <= 1.0


def test_objects_and_workspace_are_in_the_picture_and_other_instants_where_they_are_asked_for(world: World) -> None:
    sides = load_task("tabletop").workspace
    corners = np.array(list(product(sides.x, sides.y, sides.z)))
    placed = np.array([pose.position for pose in world.scene.objects.values()])
    view = whole_view(world, "right")
    assert np.abs(of_view(view, world, np.vstack([corners, placed]))).max() <= 1.0
    earlier = np.array([[0.5, -1.5, 1.5]])
    assert np.abs(of_view(view, world, earlier)).max() > 1.0
    assert np.abs(of_view(whole_view(world, "right", [earlier]), world, earlier)).max() <= 1.0


def test_furniture_is_in_the_picture_unless_it_is_larger_than_all_that_counts(world: World) -> None:
    table = next(item for item in world.task.objects.values() if item.fixed is not None)
    corners = table.fixed.pose.apply(0.5 * np.array(table.shape.size) * np.array(list(product((-1.0, 1.0), repeat=3))))
    assert np.abs(of_view(whole_view(world, "right"), world, corners)).max() <= 1.0
    walled = {**world.task.objects, "wall": replace(table, shape=replace(table.shape, size=(0.1, 9.0, 9.0)))}
    with World(world.robot, replace(world.task, objects=walled), world.scene) as room:
        assert whole_view(room, "right") == whole_view(world, "right")


def test_the_view_of_the_other_arm_is_the_mirror_image(world: World) -> None:
    q, scene = world.arm("right").configuration("home"), world.scene
    world.reset(scene, {"right": q})
    ours = whole_view(world, "right")
    task = world.task_for("left")
    with World(world.robot, task, scene.mirrored(world.base)) as other:
        other.reset(configurations={"left": other.arm("left").configuration("home")})
        theirs = whole_view(other, "left").mirrored()
    np.testing.assert_allclose(theirs.eye, ours.eye, atol=5e-3)
    np.testing.assert_allclose(theirs.target, ours.target, atol=5e-3)
