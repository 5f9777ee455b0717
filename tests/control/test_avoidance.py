"""Avoidance: the second derivative of every distance is exact, and the arm keeps off whatever stands or moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pft_exec.control import Avoidance, TrackingController, constant_compliance, holding
from pft_exec.control.avoidance import APPROACH, SAFE_DISTANCE
from pft_exec.geometry import Pose
from pft_exec.model import Box, Capsule, Cylinder, Obstacle, Sphere
from tests.control.plant import Plant

KEPT = 0.02  # m


def around(arm, start):
    """A ball, a capsule that moves and turns, and a box, near the tool."""
    tool = arm.forward(start).position
    drift = np.array([0.1, -0.2, 0.3, 0.5, 0.2, -0.4])
    return (
        Obstacle("ball", Sphere(0.04), Pose(tool + np.array([0.05, 0.12, 0.02])), drift * [1, 1, 1, 0, 0, 0]),
        Obstacle("stick", Capsule(0.03, 0.2), Pose(tool + np.array([-0.05, 0.15, 0.02]), [0.5, 0.5, 0.5, 0.5]), drift),
        Obstacle("crate", Box((0.1, 0.1, 0.2)), Pose(tool + np.array([0.05, -0.05, -0.25]))),
    )


@pytest.mark.parametrize("seed", range(4))
def test_second_derivative_of_distances_is_that_of_finite_differences(arm, start, seed):
    """Along q(t) of constant acceleration; flat-sided bodies may only be more cautious than the truth."""
    generator = np.random.default_rng(seed)
    v, a = generator.normal(0.0, 0.7, 7), generator.normal(0.0, 2.0, 7)
    arm = arm.with_payload(0.0)
    arm.limits = replace(arm.limits, acceleration=np.full(7, 1e6))  # every row asks for what its distance needs
    avoidance = Avoidance(arm)
    avoidance.watch(around(arm, start), 0.0)

    def at(t):
        near = avoidance.near(arm, start + v * t + 0.5 * a * t**2, v + a * t, t)
        names = near.names(np.ones(len(near.distance), dtype=bool))
        return near, dict(zip(names, near.distance, strict=True))

    now, step = 2e-3, 1e-3
    near, here = at(now)
    before, after = at(now - step)[1], at(now + step)[1]
    names = near.names(np.ones(len(near.distance), dtype=bool))
    assert len(names) >= 6
    checked = 0
    for row, lower, name in zip(near.constraint.G, near.constraint.lower, names, strict=True):
        if name not in before or name not in after:
            continue
        rate = (after[name] - before[name]) / (2 * step)
        measured = (after[name] - 2 * here[name] + before[name]) / step**2
        stated = row @ a - lower - 2 * APPROACH * rate - APPROACH**2 * (here[name] - SAFE_DISTANCE)
        if name.endswith(("ball", "stick")) or "_link_" not in name:
            is_flat = name.endswith("crate")
            assert stated <= measured + 0.02 * (1.0 + abs(measured))
            assert is_flat or stated == pytest.approx(measured, rel=0.02, abs=0.05)
            checked += 1
    assert checked >= 5


def keep_off(arm, start, obstacle, duration, period=0.002, self_collision=False):
    """Smallest distance, m, of an arm that wants to stay where it is, from an obstacle; and the commands."""
    controller, plant = TrackingController(arm, period, self_collision=self_collision), Plant(arm, start)
    controller.follow(holding(start), constant_compliance(100.0), 0.0, blend=False)
    smallest, commands = np.inf, []
    for step in range(round(duration / period)):
        time = step * period
        if step % 10 == 0:
            controller.avoid([replace(obstacle, pose=obstacle.after(time))], time)
        commands.append(controller.update(time, plant.q, plant.v))
        smallest = min(smallest, commands[-1].distance)
        for _ in range(round(period / 0.001)):
            plant.step(commands[-1].torque)
    return smallest, commands


@pytest.mark.parametrize("solid", [Sphere(0.05), Capsule(0.04, 0.1), Box((0.1, 0.08, 0.12)), Cylinder(0.04, 0.1)])
def test_a_body_that_comes_at_the_tool_is_given_way_to(arm, start, solid):
    tool = arm.forward(start)
    ahead = tool.rotation[:, 0]
    coming = Obstacle("it", solid, Pose(tool.position + 0.35 * ahead), np.concatenate([-0.1 * ahead, np.zeros(3)]))
    smallest, commands = keep_off(arm, start, coming, 3.0)
    assert smallest >= KEPT
    assert not any(command.fallback for command in commands)
    last = commands[-1]
    assert any(name.endswith(" / it") for name in last.apart_active)
    assert np.linalg.norm(last.error[:3]) >= 0.03


def test_no_row_asks_for_more_than_the_joints_may_accelerate(arm, start):
    """An obstacle that appears inside the arm is left at the acceleration limits, not by a jump."""
    avoidance = Avoidance(arm, self_collision=False)
    avoidance.watch([Obstacle("it", Sphere(0.3), arm.forward(start))], 0.0)
    near = avoidance.near(arm, start, np.zeros(7), 0.0)
    reach = np.abs(near.constraint.G) @ arm.limits.acceleration
    assert near.distance.min() < 0.0
    assert (near.constraint.lower <= reach + 1e-9).all()
    assert np.isclose(near.constraint.lower, reach).any()
    assert not any("shoulder_pan" in near.bodies[i] for i, _ in near.pairs)


def test_what_is_far_away_changes_nothing(arm, start):
    controller = TrackingController(arm)
    controller.follow(holding(start), constant_compliance(100.0), 0.0, blend=False)
    free = controller.update(0.0, start + 0.05, np.zeros(7))
    controller.avoid([Obstacle("far", Sphere(0.1), Pose(np.array([5.0, 0.0, 0.0])))])
    watched = controller.update(0.0, start + 0.05, np.zeros(7))
    np.testing.assert_array_equal(free.torque, watched.torque)
    assert watched.distance == np.inf
    controller.avoid([])
    assert controller.update(0.0, start, np.zeros(7)).apart_active == ()


@pytest.mark.parametrize(
    "inward",
    [[-0.25, 1.28, -2.16, -1.60, -1.34, -0.86, 1.41], [-0.36, 1.23, -2.53, -1.98, 0.0, -1.06, 1.27]],
    ids=["hand into the chest", "wrist into the shoulder"],
)
def test_links_keep_off_the_robot_itself(arm, start, inward):
    """A reference that leads through the robot's own parts is followed as far as it is safe, and no farther."""
    witness, smallest = Avoidance(arm), {}
    for is_careful in (True, False):
        controller, plant = TrackingController(arm, 0.002, self_collision=is_careful), Plant(arm, start)
        controller.follow(holding(np.array(inward)), constant_compliance(30.0), 0.0, blend=False)
        smallest[is_careful] = np.inf
        for step in range(800):
            command = controller.update(0.002 * step, plant.q, plant.v)
            for _ in range(2):
                plant.step(command.torque)
            near = witness.near(arm, plant.q, plant.v, 0.0) if step % 5 == 0 else None
            smallest[is_careful] = min(smallest[is_careful], np.inf if near is None else near.distance.min())
    assert smallest[False] < 0.0
    assert smallest[True] >= KEPT


def test_nothing_touches_in_the_postures_that_the_robot_names(arm):
    avoidance = Avoidance(arm)
    for name in arm.configurations:
        near = avoidance.near(arm, np.array(arm.configuration(name)), np.zeros(7), 0.0)
        assert near is None or near.distance.min() >= SAFE_DISTANCE


def test_a_payload_changes_nothing_of_the_shape(arm, start):
    rows = []
    for model in (arm, arm.with_payload(1.0)):
        avoidance = Avoidance(model)
        avoidance.watch(around(arm, start), 0.0)
        rows.append(avoidance.near(model, start, np.ones(7), 0.0).constraint.G)
    np.testing.assert_array_equal(*rows)


def test_what_was_watched_before_is_where_it_is_seen_now(arm, start):
    """The same things seen again elsewhere, or others, give the rows of an avoidance that never saw anything else."""
    shift, others = np.array([0.02, 0.03, -0.01]), around(arm, start)[1:]
    moved = [replace(it, pose=Pose(it.pose.position + shift, it.pose.quaternion)) for it in around(arm, start)]
    used = Avoidance(arm)
    used.watch(around(arm, start), 0.0)
    used.near(arm, start, np.ones(7), 0.3)
    for seen, time in ((moved, 0.4), (others, 0.5), ((), 0.6), (moved, 0.7)):
        new = Avoidance(arm)
        for avoidance in (used, new):
            avoidance.watch(seen, time)
        one, other = (avoidance.near(arm, start, np.ones(7), time + 0.05) for avoidance in (used, new))
        assert (one is None) == (other is None)
        if one is not None:
            np.testing.assert_array_equal(one.distance, other.distance)
            np.testing.assert_array_equal(one.constraint.lower, other.constraint.lower)
            np.testing.assert_array_equal(one.constraint.G, other.constraint.G)


@pytest.mark.parametrize("seed", range(5))
def test_what_is_left_out_holds_whatever_the_joints_do(arm, start, seed):
    """Beside an arm of joints that could do anything, for which every pair within 25 cm has its row."""
    generator = np.random.default_rng(seed)
    v = generator.uniform(-0.5, 0.5, 7) * arm.limits.velocity
    tool = arm.forward(start).position
    balls = [Obstacle(f"{k}", Sphere(0.03), Pose(tool + generator.normal(0.0, 0.15, 3))) for k in range(12)]
    able = arm.with_payload(0.0)
    able.limits = replace(arm.limits, acceleration=np.full(7, 1e9))
    found = []
    for model in (arm, able):
        avoidance = Avoidance(model)
        avoidance.watch(balls, 0.0)
        found.append(avoidance.near(model, start, v, 0.0))
    pressing = set() if found[0] is None else set(found[0].pairs)
    rows, lower = found[1].constraint.G, found[1].constraint.lower
    left_out = np.array([pair not in pressing for pair in found[1].pairs])
    assert pressing <= set(found[1].pairs)
    assert left_out.any()
    least = -np.abs(rows) @ arm.limits.acceleration
    assert np.all(least[left_out] >= lower[left_out])
