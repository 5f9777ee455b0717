"""Who has the arm: when the robot takes over, how it joins the motion, and when the person takes back.

`TakeoverPolicy` turns beliefs into decisions: wait, take over, ask which of two, decline. `plan_transition` leads from
the arm's state onto the tube's moving target, planned once, limits kept; a `PacedClock` lets it all run slower.
`ForceObserver` feels in the joints what the person does to the tool meanwhile, and `TakeBack` notices when that is
meant. What follows the joints is `pft_exec.control`; who calls whom is `pft_exec.execution`.
"""

from pft_exec.handoff.moving_frame import JointState
from pft_exec.handoff.pace import PacedClock
from pft_exec.handoff.policy import Decision, PolicySettings, TakeoverPolicy
from pft_exec.handoff.take_back import ExternalForce, ForceObserver, TakeBack
from pft_exec.handoff.transition import Transition, plan_transition

__all__ = [
    "Decision",
    "ExternalForce",
    "ForceObserver",
    "JointState",
    "PacedClock",
    "PolicySettings",
    "TakeBack",
    "TakeoverPolicy",
    "Transition",
    "plan_transition",
]
