"""Obstacles and the capsules of links: what they hold, how they move, and that bad ones are refused."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.description import load_task
from pft_exec.exceptions import ConfigurationError
from pft_exec.geometry import Pose
from pft_exec.model import Box, Capsule, Cylinder, Obstacle, Sphere, load_robot, task_obstacles
from pft_exec.model.arm_geometry import place
from pft_exec.model.distance import coal_shape, nearest_points
from pft_exec.model.link_capsules import enclosing_capsule


def distance_to_segment(points, start, end):
    edge = end - start
    share = np.clip((points - start) @ edge / max(edge @ edge, 1e-18), 0.0, 1.0)
    return np.linalg.norm(points - start - share[:, None] * edge, axis=1)


@pytest.mark.parametrize("seed", range(5))
def test_a_capsule_holds_its_points(seed):
    points = np.random.default_rng(seed).normal(size=(60, 3)) * [0.2, 0.05, 0.03]
    capsule = enclosing_capsule("cloud", 0, points)
    assert distance_to_segment(points, capsule.start, capsule.end).max() <= capsule.radius + 1e-9
    sphere = 4.0 / 3.0 * np.pi * np.linalg.norm(points, axis=1).max() ** 3
    assert capsule.volume < sphere


@pytest.mark.parametrize("name", ["pr2", "wam"])
def test_links_of_a_robot_are_held_by_capsules_of_their_size(name):
    robot = load_robot(name)
    for arm in map(robot.arm, robot.arms):
        links = arm.geometry.links
        assert [link.joint for link in links] == sorted(link.joint for link in links)
        assert {link.joint for link in links} == set(range(len(arm.joint_names)))
        assert all(0.02 <= link.radius <= 0.25 for link in links)
        assert all(links[j].joint - links[i].joint >= 3 for i, j in arm.geometry.link_pairs)


def test_mirrored_arms_have_mirrored_capsules():
    robot = load_robot("pr2")
    left, right = (robot.arm(name).geometry.links for name in ("left", "right"))
    np.testing.assert_allclose([link.radius for link in left], [link.radius for link in right], atol=2e-3)


def test_distances_are_those_of_closed_forms():
    ball, far = coal_shape(Sphere(0.1)), place(Pose(np.array([1.0, 0.0, 0.0])))
    for solid, expected in (
        (Sphere(0.2), 0.7),
        (Capsule(0.2, 1.0), 0.7),
        (Box((0.6, 1, 1)), 0.6),
        (Cylinder(0.3, 1), 0.6),
    ):
        distance, point, normal = nearest_points(ball, far, coal_shape(solid), place(Pose(np.zeros(3))))
        assert distance == pytest.approx(expected, abs=1e-6)
        np.testing.assert_allclose(point, [0.9, 0.0, 0.0], atol=1e-4)
        np.testing.assert_allclose(normal, [-1.0, 0.0, 0.0], atol=1e-4)


def test_an_obstacle_moves_on_and_is_seen_from_other_frames():
    moving = Obstacle("it", Sphere(0.1), Pose(np.array([1.0, 0.0, 0.0])), np.array([0.0, 0.2, 0.0, 0.0, 0.0, 0.5]))
    np.testing.assert_allclose(moving.after(2.0).position, [1.0, 0.4, 0.0])
    half_turn = Pose(np.array([0.5, 0.0, 0.0]), np.array([0.0, 0.0, 1.0, 0.0]))
    seen = moving.seen_from(half_turn)
    np.testing.assert_allclose(seen.pose.position, [-0.5, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(seen.velocity, [0.0, -0.2, 0.0, 0.0, 0.0, 0.5], atol=1e-12)


def test_objects_and_furniture_of_a_task_are_obstacles_but_for_those_left_out():
    task = load_task("tabletop")
    poses = {name: Pose(np.array([0.5, 0.1 * k, 0.8])) for k, name in enumerate(task.placed)}
    names = {obstacle.name for obstacle in task_obstacles(task, poses)}
    assert set(task.placed) <= names
    assert {name for name, item in task.objects.items() if item.fixed is not None} <= names
    left_out = task.placed[0]
    assert left_out not in {obstacle.name for obstacle in task_obstacles(task, poses, (left_out,))}


@pytest.mark.parametrize("make", [lambda: Sphere(0.0), lambda: Box((1.0, -1.0, 1.0)), lambda: Capsule(np.nan, 1.0)])
def test_solids_without_size_are_refused(make):
    with pytest.raises(ConfigurationError, match="must be positive"):
        make()


def test_a_velocity_of_another_shape_is_refused():
    with pytest.raises(ConfigurationError, match=r"must be \(6,\)"):
        Obstacle("it", Sphere(0.1), Pose(np.zeros(3)), np.zeros(3))
