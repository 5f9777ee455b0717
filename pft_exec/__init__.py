"""Teach a robot arm by hand; learn, recognize and execute motions as probabilistic flow tubes.

The way of the data, one folder per arrow:

    hand guiding -> Recorder -> Demonstration --+                     teach (simulation or a file)
                                                v
                 relevant motion variables, alignment -> Motion       learn, once per motion
                                                v
           Scene (objects now) + start pose  -> FlowTube per motion   generalize, per scene
                                                v
              stream of samples -> OnlineRecognizer -> Belief         recognize, per sample
                                                v
                 policy: take over? -> Transition onto the tube       handoff
                                                v
          TrackingController: the tube's covariance as cost -> torque execute, per control period

>>> import pft_exec as pft                                            # doctest: +SKIP
>>> library = pft.learn_library(pft.load_demonstrations("demonstrations.h5"))  # doctest: +SKIP
>>> tubes = library.flow_tubes(scene, start=tool_pose)                # doctest: +SKIP

SI units and radians; world z up; quaternions (x, y, z, w). Names load on first use, so the import itself is light.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pft_exec.demonstration import (
        Demonstration,
        Recorder,
        Scene,
        convert_recordings,
        load_demonstrations,
        save_demonstrations,
    )
    from pft_exec.description import RobotDescription, TaskDescription, load_task
    from pft_exec.exceptions import PFTError
    from pft_exec.execution import ExecutionLog, assist, execute, prepare, teach
    from pft_exec.geometry import Pose
    from pft_exec.learning import FlowTube, Motion, MotionLibrary, MotionVariables, learn_library, learn_motion
    from pft_exec.model import Arm, RobotModel, load_robot
    from pft_exec.recognition import Belief, OnlineRecognizer
    from pft_exec.simulation import Push, World

__version__ = "0.1.0"

_HOMES = {
    "Arm": "model",
    "Belief": "recognition",
    "Demonstration": "demonstration",
    "ExecutionLog": "execution",
    "FlowTube": "learning",
    "Motion": "learning",
    "MotionLibrary": "learning",
    "MotionVariables": "learning",
    "OnlineRecognizer": "recognition",
    "PFTError": "exceptions",
    "Pose": "geometry",
    "Push": "simulation",
    "Recorder": "demonstration",
    "RobotDescription": "description",
    "RobotModel": "model",
    "Scene": "demonstration",
    "TaskDescription": "description",
    "World": "simulation",
    "assist": "execution",
    "convert_recordings": "demonstration",
    "execute": "execution",
    "learn_library": "learning",
    "learn_motion": "learning",
    "load_demonstrations": "demonstration",
    "load_robot": "model",
    "load_task": "description",
    "prepare": "execution",
    "save_demonstrations": "demonstration",
    "teach": "execution",
}

__all__ = [
    "Arm",
    "Belief",
    "Demonstration",
    "ExecutionLog",
    "FlowTube",
    "Motion",
    "MotionLibrary",
    "MotionVariables",
    "OnlineRecognizer",
    "PFTError",
    "Pose",
    "Push",
    "Recorder",
    "RobotDescription",
    "RobotModel",
    "Scene",
    "TaskDescription",
    "World",
    "assist",
    "convert_recordings",
    "execute",
    "learn_library",
    "learn_motion",
    "load_demonstrations",
    "load_robot",
    "load_task",
    "prepare",
    "save_demonstrations",
    "teach",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its folder on first use (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module 'pft_exec' has no attribute {name!r}")
    value = getattr(import_module(f"pft_exec.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Public names, loaded or not, and the module's own."""
    return sorted({*__all__, *globals()})
