"""Learning: from a handful of demonstrations to a motion, and from a motion and a scene to a flow tube.

In the order of the flow, ``learn_motion`` (`motion`) decides which motion variables are relevant at the two ends:
`frames` sees them from everywhere, `relevance` lets the frames compete, `directions` splits axes, `carrying` names what
was carried, `decisions` says why, `variables` holds it and `report` prints it. ``method="robust"`` (`robust`) reads the
demonstrations at common steps (`alignment`, `landmarks`, `dynamic_time_warping`, `resampling`), finds what was handled
on the way (`handling`), lets `experts` predict each from the others (`normalization`, `endpoint`, `averaging`), leaves
each out to see which help (`leave_one_out`), asks which objects are passed between the ends (`passing`), blends the
experts by their errors (`stacking`, `blending`) and takes what is left as the tube's `covariance`, with what a new
scene leaves open about their weights (`leverage`); `signals` adds gripper and switches. Compiled beneath them:
`turning`, `averaging`, `smoothing`, `frame_product`, `stacking_kernel`.
``method="dong2012"`` is the published method (`published_variables`, `fast_dtw`, `dong2012`). Keyframes make `compound`
motions, `coaching` advises the teacher, `library` keeps all motions and their file. What comes out, for the recognizer
and the controller, is the `flow_tube` with its `events`.
"""

from pft_exec.learning.coaching import Coaching
from pft_exec.learning.dong2012 import Dong2012Options
from pft_exec.learning.events import TubeEvent
from pft_exec.learning.flow_tube import AlignedDemonstrations, FlowTube, TubeState
from pft_exec.learning.library import MotionLibrary, learn_library
from pft_exec.learning.motion import METHODS, Motion, learn_motion
from pft_exec.learning.variables import EndDecision, FrameDecision, MotionVariables, Passage

__all__ = [
    "METHODS",
    "AlignedDemonstrations",
    "Coaching",
    "Dong2012Options",
    "EndDecision",
    "FlowTube",
    "FrameDecision",
    "Motion",
    "MotionLibrary",
    "MotionVariables",
    "Passage",
    "TubeEvent",
    "TubeState",
    "learn_library",
    "learn_motion",
]
