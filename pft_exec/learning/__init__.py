"""Learning: from a handful of demonstrations to a motion, and from a motion and a scene to a flow tube.

``learn_motion`` decides which motion variables are relevant at the two ends (`relevance`, `decisions`), and
``Motion.flow_tube`` carries the demonstrations into a scene and takes mean and covariance there (`robust`).
"""

from pft_exec.learning.flow_tube import AlignedDemonstrations, FlowTube, TubeState
from pft_exec.learning.library import MotionLibrary, learn_library
from pft_exec.learning.motion import METHODS, Motion, learn_motion
from pft_exec.learning.variables import EndDecision, FrameDecision, MotionVariables

__all__ = [
    "METHODS",
    "AlignedDemonstrations",
    "EndDecision",
    "FlowTube",
    "FrameDecision",
    "Motion",
    "MotionLibrary",
    "MotionVariables",
    "TubeState",
    "learn_library",
    "learn_motion",
]
