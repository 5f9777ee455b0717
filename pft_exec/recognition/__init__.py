"""Recognition: from a stream of samples to a belief over the motions, in the current scene.

`OnlineRecognizer` takes the flow tubes that `learning` made for this scene and one sample at a time, and answers with
a `Belief`: which motion, how far along, when done, and whether it is none of them. Two methods stand behind it:

- ``"phase"`` (default, `phase_filter`): a forward filter over (pace, phase) of each tube. `motion_clock` reads
  demonstrations and stream alike, so that standing costs nothing; `evidence`, `emission` and `signals` make the
  densities, `timing` the transitions, `unknown` what is usual; `phase_model` packs it all for `phase_kernel`.
- ``"dong2012"`` (`dong2012`): Algorithm 4 of [Dong2012]_, one new column of the alignment a sample.

Neither grows with elapsed time, and both are compiled and warm once constructed.
"""

from pft_exec.recognition.belief import Belief, LabelValues
from pft_exec.recognition.dong2012 import Dong2012Settings, IncrementalAlignment
from pft_exec.recognition.phase_filter import PhaseFilter
from pft_exec.recognition.recognizer import METHODS, OnlineRecognizer
from pft_exec.recognition.settings import PhaseSettings

__all__ = [
    "METHODS",
    "Belief",
    "Dong2012Settings",
    "IncrementalAlignment",
    "LabelValues",
    "OnlineRecognizer",
    "PhaseFilter",
    "PhaseSettings",
]
