"""The same seed gives the same bits in every process: what is taught, what is learned from it, and what is executed."""

from __future__ import annotations

import subprocess
import sys

import pytest

SCRIPT = """
import hashlib
import numpy as np
from pft_exec import World, assist, learn_library, prepare, teach

digest = hashlib.sha256()
with World("pr2", "tabletop", seed=5) as world:
    taught = [item for label in ("reach", "go_home") for item in teach(world, label, count=2)]
    for item in taught:
        for values in (item.time, item.position, item.quaternion, item.configuration, *item.objects.values()):
            digest.update(np.ascontiguousarray(values).tobytes())
    library = learn_library(taught)
    prepare(world, "go_home")
    for tube in library.flow_tubes(world.scene, world.tool()).values():
        digest.update(tube.position.tobytes() + tube.covariance.tobytes())
    log = assist(world, library, "go_home")
    for values in (log.configuration, log.velocity, log.torque, log.reference_position, log.belief.probability):
        digest.update(np.ascontiguousarray(values).tobytes())
print(digest.hexdigest())
"""


@pytest.mark.slow
def test_the_whole_way_is_the_same_bit_for_bit_in_two_processes() -> None:
    runs = [subprocess.Popen([sys.executable, "-c", SCRIPT], stdout=subprocess.PIPE, text=True) for _ in range(2)]
    digests = [run.communicate(timeout=600)[0].strip() for run in runs]
    assert all(run.returncode == 0 for run in runs)
    assert len(digests[0]) == 64
    assert digests[0] == digests[1]
