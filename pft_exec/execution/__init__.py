"""The rooms put together: teach, execute, assist; composition, no mathematics.

`teach` lets a synthetic person lead the floating arm and records what it did. `execute` finishes a flow tube from a
standstill. `assist` lets the person begin, recognizes the motion, takes over and finishes it. `prepare` sets a world up
for that, in a scene nobody taught. All turn the same crank, one control period at a time (`control_loop`), and leave an
`ExecutionLog` or demonstrations.
"""

from pft_exec.execution.assistance import assist
from pft_exec.execution.autonomous import execute
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.execution.hand.person import TakeBackPlan
from pft_exec.execution.log import BeliefHistory, Event, ExecutionLog, LogRecorder, Stage
from pft_exec.execution.preparation import prepare
from pft_exec.execution.teaching import GuidingFigures, teach

__all__ = [
    "BeliefHistory",
    "ControlLoop",
    "Event",
    "ExecutionLog",
    "GuidingFigures",
    "LogRecorder",
    "Stage",
    "TakeBackPlan",
    "assist",
    "execute",
    "prepare",
    "teach",
]
