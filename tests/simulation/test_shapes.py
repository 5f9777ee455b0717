"""Hollow shapes are hollow, closed at the sides and at the bottom, and as large as they say."""

from __future__ import annotations

import math

import numpy as np
import pybullet
import pytest

from pft_exec.description import (
    BoxShape,
    CompoundShape,
    CylinderShape,
    LiquidDescription,
    ObjectDescription,
    SphereShape,
    TrayShape,
    VesselShape,
)
from pft_exec.description.object import Placement
from pft_exec.description.quantities import FixedPose
from pft_exec.description.shape import Part
from pft_exec.exceptions import SimulationError
from pft_exec.geometry import Pose
from pft_exec.simulation.engine import Engine
from pft_exec.simulation.liquid import places_in
from pft_exec.simulation.object_body import ObjectBody
from pft_exec.simulation.shapes import half_width, pieces_of

CUP = VesselShape("vessel", 0.045, 0.1)
BIN = TrayShape("tray", (0.3, 0.2, 0.1))
POST = CylinderShape("cylinder", 0.02, 0.2)
POSTS = CompoundShape("compound", tuple(Part(POST, (0.0, y, 0.0)) for y in (0.1, -0.1)), 0.12, 0.2)
_ANYWHERE = Placement("table", (0.0, 0.0), (0.0, 0.0))


def _dropped(shape, place: tuple[float, float]) -> float:
    """Height, m, at which a ball of 5 mm radius comes to rest that falls on a shape that stands fixed on z = 0."""
    engine = Engine(1e-3)
    try:
        stands = FixedPose((0.0, 0.0, 0.5 * shape.height))
        ObjectBody(engine, ObjectDescription(shape, fixed=stands), stands.pose, hollow=True)
        ball = ObjectBody(
            engine,
            ObjectDescription(SphereShape("sphere", 0.005), mass=0.002, fixed=None, placement=_ANYWHERE),
            Pose(np.array([*place, shape.height + 0.01])),
        )
        for _ in range(600):
            engine.step()
        return float(ball.pose.position[2])
    finally:
        engine.close()


@pytest.mark.parametrize(("shape", "floor"), [(CUP, 0.006), (BIN, 0.006)])
def test_a_ball_falls_to_the_floor_of_a_hollow_shape(shape, floor: float) -> None:
    assert _dropped(shape, (0.0, 0.0)) == pytest.approx(floor + 0.005, abs=2e-3)


def test_a_ball_lies_on_top_of_a_solid_one() -> None:
    assert _dropped(BoxShape("box", (0.1, 0.1, 0.1)), (0.0, 0.0)) == pytest.approx(0.105, abs=2e-3)


def test_a_ball_falls_between_two_posts() -> None:
    assert _dropped(POSTS, (0.0, 0.0)) < 0.0


def test_a_vessel_is_closed_all_round() -> None:
    """Every ray from the axis meets a wall between inner and outer radius (of the corners)."""
    engine = Engine(1e-3)
    try:
        stands = FixedPose((0.0, 0.0, 0.05))
        ObjectBody(engine, ObjectDescription(CUP, fixed=stands), stands.pose, hollow=True)
        angles = np.linspace(0.0, 2.0 * np.pi, 97)
        ends = [[math.cos(a), math.sin(a), 0.05] for a in angles]
        hits = pybullet.rayTestBatch([[0.0, 0.0, 0.05]] * len(ends), ends, physicsClientId=engine.client)
        distance = np.array([hit[2] for hit in hits])
        assert (distance > 0.037).all()
        assert (distance < 0.045 / math.cos(math.pi / 8) + 1e-3).all()
    finally:
        engine.close()


def test_a_vessel_that_need_not_be_hollow_is_one_piece() -> None:
    assert len(pieces_of(CUP, hollow=False)) == 1
    assert len(pieces_of(CUP, hollow=True)) == CUP.sides + 1


def test_half_width_is_what_stands_between_the_pads() -> None:
    assert half_width(CUP, np.array([1.0, 0.0, 0.0])) == 0.045
    assert half_width(BoxShape("box", (0.1, 0.06, 0.2)), np.array([0.0, 1.0, 0.0])) == pytest.approx(0.03)


def test_balls_lie_in_the_vessel_without_overlap() -> None:
    liquid, bottle = LiquidDescription(), VesselShape("vessel", 0.03, 0.18)
    places = places_in(liquid, bottle)
    gaps = np.linalg.norm(places[:, None] - places, axis=2)[np.triu_indices(len(places), 1)]
    assert gaps.min() >= 2.0 * liquid.radius - 1e-12
    assert (np.hypot(places[:, 0], places[:, 1]) <= 0.03 - 0.006 - liquid.radius).all()


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(SimulationError, match="do not fit"):
        places_in(LiquidDescription(count=500), CUP)
    with pytest.raises(ValueError, match="leaves nothing of the inside"):
        VesselShape("vessel", 0.005, 0.1)
    with pytest.raises(ValueError, match="3 to 15 sides"):
        VesselShape("vessel", 0.05, 0.1, sides=20)
