"""Where chance comes from: one seed, and a stream of its own for each purpose.

What is taught and what is evaluated never share a stream: a scene drawn to evaluate is none that was drawn to teach,
whatever the two seeds are.
"""

from __future__ import annotations

import zlib
from typing import Literal

import numpy as np

Purpose = Literal["teach", "evaluate", "assist", "camera", "mismatch", "fault"]


def random_stream(seed: int, purpose: Purpose, *keys: str | int) -> np.random.Generator:
    """A generator that depends on the seed, the purpose and further keys, and on nothing else.

    Parameters
    ----------
    seed : int
        Not negative.
    purpose : "teach", "evaluate", "assist", "camera", "mismatch" or "fault"
        "teach" is for demonstrations alone; scenes of any evaluation come from "evaluate", the person who begins a
        motion there from "assist"; noise of sensors from "mismatch", what is broken on purpose from "fault".
    *keys : str or int
        What within the purpose, such as a label or a number of a scene.

    Notes
    -----
    The purpose and the keys are the spawn key of a ``numpy.random.SeedSequence``, whose streams are independent.
    """
    words = (purpose, *keys)
    spawn_key = tuple(zlib.crc32(f"{type(word).__name__}:{word}".encode()) for word in words)
    return np.random.default_rng(np.random.SeedSequence(entropy=seed, spawn_key=spawn_key))
