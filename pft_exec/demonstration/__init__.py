"""What was taught: demonstrations, scenes, their recording, their storage and the recordings of others.

The first room of the flow. Hand guiding fills a `Recorder`, which makes a `Demonstration`: arrays over time of the
tool, the signals and the objects, with the `Scene` at its first sample. `save_demonstrations` and
`load_demonstrations` keep them on disk bit for bit, `convert_recordings` reads what others recorded, and the
segmentation cuts a long recording into motions. Nothing here knows a robot or a simulator: the recorder is handed
arrays.
"""

from pft_exec.demonstration.demonstration import Demonstration
from pft_exec.demonstration.interchange import convert_recordings
from pft_exec.demonstration.recorder import Recorder, recover_recording, recover_recordings
from pft_exec.demonstration.scene import Scene
from pft_exec.demonstration.segmentation import (
    discrete_changes,
    moving_range,
    split_at_discrete_changes,
    split_at_keyframes,
    without_idle_ends,
)
from pft_exec.demonstration.storage import load_demonstrations, save_demonstrations

__all__ = [
    "Demonstration",
    "Recorder",
    "Scene",
    "convert_recordings",
    "discrete_changes",
    "load_demonstrations",
    "moving_range",
    "recover_recording",
    "recover_recordings",
    "save_demonstrations",
    "split_at_discrete_changes",
    "split_at_keyframes",
    "without_idle_ends",
]
