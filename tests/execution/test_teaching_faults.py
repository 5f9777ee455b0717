"""What breaks while a person teaches: nothing recorded is lost, and no demonstration holds what was not so."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pft_exec.demonstration import recover_recordings
from pft_exec.exceptions import StorageError
from pft_exec.execution import teach
from pft_exec.execution.faults import Fault
from pft_exec.simulation import World

_ROOT = Path(__file__).parents[2]
_PROGRAM = """
import sys
from pft_exec import World, teach
with World("pr2", "tabletop", seed=0) as world:
    teach(world, "go_home", count=3, seed=1, record=sys.argv[1])
"""


def test_a_killed_process_loses_nothing_that_was_recorded(tmp_path: Path) -> None:
    """Killed while it records; what it had recorded is the beginning of what it records when nobody kills it."""
    process = subprocess.Popen([sys.executable, "-c", _PROGRAM, str(tmp_path)], cwd=_ROOT)
    second = tmp_path / "go_home_right_001.recording"
    try:
        while process.poll() is None and not (second.is_file() and second.read_text().count("\n") > 20):
            time.sleep(0.02)
        assert process.poll() is None, "the process ended before it was killed"
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
    recovered = recover_recordings(tmp_path)
    assert len(recovered) >= 2
    with World("pr2", "tabletop", seed=0) as world:
        whole = teach(world, "go_home", count=3, seed=1)
    for cut, full in zip(recovered, whole, strict=False):
        np.testing.assert_array_equal(cut.position, full.position[: len(cut)])
        np.testing.assert_array_equal(cut.configuration, full.configuration[: len(cut)])
    assert len(recovered[0]) == len(whole[0])
    assert len(recovered[1]) >= 20


def test_what_is_recorded_is_what_is_taught(shared_world: World, tmp_path: Path) -> None:
    taught = teach(shared_world, "go_home", count=1, seed=1, record=tmp_path)
    (recovered,) = recover_recordings(tmp_path)
    np.testing.assert_array_equal(recovered.position, taught[0].position)


def test_single_wrong_readings_are_not_taught(shared_world: World) -> None:
    (whole,) = teach(shared_world, "go_home", count=1, seed=1)
    (spiked,) = teach(shared_world, "go_home", count=1, seed=1, faults=[Fault("encoder_spike", 0.5, 1.0)])
    place = np.interp(spiked.time, whole.time, whole.position[:, 0])
    assert np.abs(spiked.position[:, 0] - place).max() < 0.005


def test_a_demonstration_in_which_the_arm_had_to_stop_is_left_out(shared_world: World) -> None:
    with pytest.warns(RuntimeWarning, match="is left out: the encoder of joint"):
        taught = teach(shared_world, "go_home", count=1, seed=1, faults=[Fault("encoder_jump", 0.5)])
    assert taught == []


def test_a_lost_object_is_recorded_where_it_was_seen_last(shared_world: World) -> None:
    name = sorted(shared_world.scene)[0]
    (taught,) = teach(shared_world, "go_home", count=1, seed=1, faults=[Fault("object_lost", 0.5, name=name)])
    np.testing.assert_allclose(taught.objects[name][-1], taught.objects[name][0], atol=1e-3)


def test_a_folder_that_cannot_be_made_is_refused(shared_world: World, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match="cannot be made"):
        teach(shared_world, "go_home", count=1, seed=1, record=tmp_path / "file" / "inside")


def test_a_folder_without_recordings_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="no folder"):
        recover_recordings(tmp_path / "missing")
