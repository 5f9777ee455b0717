"""The watch: who looks on while a pursuit goes on, in one place for `execute` and `assist` alike."""

from __future__ import annotations

from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.pursuit import Attendant, Supervisor
from pft_exec.execution.supervisor import SafetySupervisor
from pft_exec.learning.flow_tube import FlowTube


def supervisors_of(loop: ControlLoop, tube: FlowTube) -> list[Supervisor]:
    """Those who may slow a pursuit of a tube (world frame) down or end it; asked in this order."""
    in_base = tube.transformed(loop.world.base.inverse())
    return [SafetySupervisor(in_base, loop.guard, loop.world.control_period, loop.log)]


def attendants_of(loop: ControlLoop, tube: FlowTube) -> list[Attendant]:
    """Those who act after each control period of a pursuit of a tube (world frame); called in this order."""
    del loop, tube
    return []
