"""Recognition: from a stream of samples to a belief over the motions, in the current scene.

`OnlineRecognizer` takes the flow tubes that `learning` made for this scene and one sample at a time, and answers with
a `Belief`: which motion, how far along, when done, and whether it is none of them.
"""

from pft_exec.recognition.belief import Belief, LabelValues
from pft_exec.recognition.recognizer import METHODS, OnlineRecognizer

__all__ = ["METHODS", "Belief", "LabelValues", "OnlineRecognizer"]
