"""Evidence: how well the whole thing works, beside the paper, its baseline and other methods.

The last room of the flow, above all others. `reproduce` rebuilds the paper's two tables in a planar world of seeded
synthetic people and judges the recordings of real people; `benchmark` times the parts. Every method stands behind one
interface (`trace`, `methods`) and one protocol (`protocol`); `baselines` are what ours is measured against. The demo
and the study of many seeds live here too, since they measure the whole way from teaching to execution.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pft_exec.evaluation.benchmarks import benchmark
    from pft_exec.evaluation.reproduction import reproduce

_HOMES = {"benchmark": "benchmarks", "reproduce": "reproduction"}

__all__ = ["benchmark", "reproduce"]


def __getattr__(name: str) -> Any:
    """Load a public name on first use (PEP 562); neither the demo nor the command line pay for the comparisons."""
    if name not in _HOMES:
        raise AttributeError(f"module 'pft_exec.evaluation' has no attribute {name!r}")
    return getattr(import_module(f"pft_exec.evaluation.{_HOMES[name]}"), name)
