"""The watch: who looks on while a pursuit goes on, in one place for `execute` and `assist` alike."""

from __future__ import annotations

from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.grasping import GripperReplay, GripperWait
from pft_exec.execution.hand.person import Person
from pft_exec.execution.pursuit import Attendant, Outcome, Pursuit, Supervisor
from pft_exec.execution.safety.force_watch import ForceWatch
from pft_exec.execution.safety.supervisor import SafetySupervisor
from pft_exec.execution.takeover import Takeover
from pft_exec.geometry import Array
from pft_exec.learning.flow_tube import FlowTube


def supervisors_of(loop: ControlLoop, tube: FlowTube) -> list[Supervisor]:
    """Those who may slow a pursuit of a tube (world frame) down or end it; asked in this order."""
    in_base = tube.transformed(loop.world.base.inverse())
    return [
        SafetySupervisor(in_base, loop.guard, loop.world.control_period, loop.log),
        GripperWait(loop.world, loop.name),
    ]


def attendants_of(loop: ControlLoop, tube: FlowTube, phase: float = 0.0) -> list[Attendant]:
    """Those who act after each control period of a pursuit of a tube (world frame) from a phase; in this order."""
    return [GripperReplay(loop.world, loop.name, tube, phase)]


def pursue(
    loop: ControlLoop,
    takeover: Takeover,
    force: ForceWatch,
    *,
    solver: str,
    floating: bool,
    person: Person | None = None,
    fading: Array | None = None,
) -> Outcome:
    """Carry out a take-over with all who look on.

    Parameters
    ----------
    loop : ControlLoop
    takeover : Takeover
    force : ForceWatch
        Takes back for a person.
    solver : str
        Of the quadratic program.
    floating : bool
        Whether the arm floated until now.
    person : Person or None
        Who led until now, and may take hold again.
    fading : (n,), N m, or None
        See `Pursuit`.
    """
    force.begin(letting_go=person is not None)
    attendants = attendants_of(loop, takeover.tube, takeover.phase)
    return Pursuit(
        loop,
        takeover,
        solver=solver,
        floating=floating,
        supervisors=[force.supervise, *supervisors_of(loop, takeover.tube)],
        attendants=attendants if person is None else [*attendants, person.attend],
        pull=None if person is None else person.pull,
        fading=fading,
    ).run()
