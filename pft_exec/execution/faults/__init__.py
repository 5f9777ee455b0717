"""Faults: what can break while an arm runs, by name, and how each is let in where it would come in on a real arm.

`Fault` says what breaks, when and how much, `draw_fault` draws one; a `FaultInjector` lets them act, unknown to every
controller. What answers them is in `safety`.
"""

from pft_exec.execution.faults.fault import KINDS, Fault, FaultKind, draw_fault
from pft_exec.execution.faults.injection import FaultInjector, Sample

__all__ = ["KINDS", "Fault", "FaultInjector", "FaultKind", "Sample", "draw_fault"]
