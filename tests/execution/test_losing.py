"""An object that the gripper lets fall: the arm goes on within its limits, and the log says what is missing."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.demonstration import Scene
from pft_exec.description import draw_scene
from pft_exec.evaluation.witness import Witness
from pft_exec.execution import execute, prepare
from pft_exec.execution.faults import Fault
from pft_exec.simulation import World
from tests.execution.test_grasping import TASK, _planned


@pytest.mark.slow
def test_the_arm_goes_on_without_what_it_lost_and_says_so() -> None:
    scene = Scene(draw_scene(TASK, np.random.default_rng(0)))
    with World("pr2", TASK, scene, seed=0, control_period=2e-3) as world:
        motion = _planned(world, "shake")
        prepare(world, "shake", seed=0)
        assert world.held("right") == "bottle"
        witness = Witness("right", world.arm("right"))
        tube = motion.flow_tube(world.scene, world.tool("right"))
        log = execute(world, tube, "right", faults=[Fault("gripper_opens", 0.6)], observer=witness.look)
        assert world.held("right") is None
    assert log.event("released").detail == "'bottle' has left the gripper"
    assert not log.success
    assert "not in the gripper" in log.reason
    assert witness.torque <= 1.0 + 1e-9
    assert witness.driven <= 1.0
    assert witness.is_finite
