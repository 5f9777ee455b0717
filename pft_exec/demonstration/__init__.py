"""What was taught: demonstrations, scenes, their recording and their storage."""

from pft_exec.demonstration.demonstration import Demonstration
from pft_exec.demonstration.scene import Scene

__all__ = ["Demonstration", "Scene"]
