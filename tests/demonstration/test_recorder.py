"""The recorder: one sample a period, the same channels throughout, and a file that survives a killed process."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pft_exec.demonstration import Recorder, recover_recording
from pft_exec.exceptions import InvalidDemonstrationError, StorageError


def sample(time: float) -> dict[str, Any]:
    return {
        "time": time,
        "position": np.array([time, 1.0 / 3.0, np.sin(time)]),
        "quaternion": np.array([0.0, 0.0, 0.6, 0.8]),
        "continuous": {"gripper": 0.08 - time / 100.0},
        "discrete": {"closed": int(time > 0.5)},
        "objects": {"mat": np.array([0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 1.0])},
        "configuration": np.full(7, time),
    }


def record(recorder: Recorder, times: Any) -> list[bool]:
    return [recorder.add(**sample(float(time))) for time in times]


def test_keeps_one_sample_a_period_of_a_faster_clock() -> None:
    recorder = Recorder("reach", period=0.01)
    kept = record(recorder, 5.0 + 0.001 * np.arange(1001))
    assert sum(kept) == len(recorder) == 101
    demonstration = recorder.demonstration()
    np.testing.assert_allclose(demonstration.time, 0.01 * np.arange(101), atol=1e-9)


def test_keeps_every_sample_of_a_slower_clock() -> None:
    recorder = Recorder("reach", period=0.01)
    assert all(record(recorder, [0.0, 0.033, 0.066, 0.1]))


def test_a_repeated_time_is_not_kept() -> None:
    assert record(Recorder("reach"), [0.0, 0.0, 0.02]) == [True, False, True]


def test_time_counts_from_the_first_sample_and_keyframes_with_it() -> None:
    recorder = Recorder("reach")
    record(recorder, np.linspace(10.0, 11.0, 101))
    recorder.mark_keyframe(10.4)
    demonstration = recorder.demonstration()
    assert demonstration.time[0] == 0.0
    assert demonstration.keyframes == (pytest.approx(0.4),)


def test_the_demonstration_holds_every_channel() -> None:
    recorder = Recorder("reach")
    record(recorder, np.linspace(0.0, 1.0, 101))
    demonstration = recorder.demonstration()
    assert demonstration.label == "reach"
    assert demonstration.quaternion.shape == (101, 4)
    assert demonstration.configuration.shape == (101, 7)
    assert demonstration.objects["mat"].shape == (101, 7)
    assert set(demonstration.discrete["closed"]) == {0, 1}
    assert demonstration.continuous["gripper"][0] == 0.08


def test_channels_that_were_not_given_stay_out() -> None:
    recorder = Recorder("line")
    recorder.add(0.0, [0.0, 0.0, 0.0])
    recorder.add(0.1, [1.0, 0.0, 0.0])
    demonstration = recorder.demonstration()
    assert demonstration.quaternion is None
    assert demonstration.configuration is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [({"label": ""}, "needs a label"), ({"label": "reach", "period": 0.0}, "period must be positive, in s; got 0.0")],
)
def test_refuses_a_label_or_period_that_is_none(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidDemonstrationError, match=message):
        Recorder(**arguments)


def test_refuses_samples_that_are_not_finite() -> None:
    recorder = Recorder("reach")
    with pytest.raises(InvalidDemonstrationError, match=r"must be finite; got 0.0 s and \[nan.* at sample 0"):
        recorder.add(0.0, [np.nan, 0.0, 0.0])


def test_refuses_time_that_goes_back() -> None:
    recorder = Recorder("reach")
    recorder.add(1.0, [0.0, 0.0, 0.0])
    with pytest.raises(InvalidDemonstrationError, match=r"time must not go back; it goes from 1 s to 0.5 s"):
        recorder.add(0.5, [0.0, 0.0, 0.0])


def test_refuses_other_channels_than_the_first_sample_had() -> None:
    recorder = Recorder("reach")
    recorder.add(0.0, [0.0, 0.0, 0.0], continuous={"gripper": 0.1})
    with pytest.raises(InvalidDemonstrationError, match=r"missing \[\"continuous 'gripper'\"\], new \['quaternion'\]"):
        recorder.add(0.1, [0.0, 0.0, 0.0], quaternion=[0.0, 0.0, 0.0, 1.0])


def test_refuses_to_make_a_demonstration_of_one_sample() -> None:
    recorder = Recorder("reach")
    recorder.add(0.0, [0.0, 0.0, 0.0])
    with pytest.raises(InvalidDemonstrationError, match=r"at least 2 samples are needed; got 1. Record longer"):
        recorder.demonstration()


def test_the_file_gives_the_same_demonstration_bit_for_bit(tmp_path: Path) -> None:
    with Recorder("reach", path=tmp_path / "r.jsonl") as recorder:
        record(recorder, np.linspace(3.0, 4.0, 101))
        recorder.mark_keyframe(3.5)
        kept = recorder.demonstration()
    recovered = recover_recording(tmp_path / "r.jsonl")
    for name in ("time", "position", "quaternion", "configuration"):
        np.testing.assert_array_equal(getattr(kept, name), getattr(recovered, name))
    np.testing.assert_array_equal(kept.continuous["gripper"], recovered.continuous["gripper"])
    np.testing.assert_array_equal(kept.objects["mat"], recovered.objects["mat"])
    assert kept.keyframes == recovered.keyframes


def test_a_killed_process_loses_nothing_that_was_added(tmp_path: Path) -> None:
    program = (
        "import os, signal\n"
        "from pft_exec.demonstration import Recorder\n"
        f"recorder = Recorder('reach', path={str(tmp_path / 'r.jsonl')!r})\n"
        "for index in range(57):\n"
        "    recorder.add(0.01 * index, [0.1 * index, 0.0, 0.0])\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode != 0
    assert len(recover_recording(tmp_path / "r.jsonl")) == 57


@pytest.mark.parametrize("cut", [1, 20, 150])
def test_a_line_cut_short_is_left_out(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "r.jsonl"
    with Recorder("reach", path=path) as recorder:
        record(recorder, np.linspace(0.0, 0.1, 11))
    path.write_bytes(path.read_bytes()[:-cut])
    expected = 11 if cut == 1 else 10
    assert len(recover_recording(path)) == expected


def test_refuses_what_is_no_recording(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="cannot be read"):
        recover_recording(tmp_path / "gone.jsonl")
    for content in ("", "time,x,y\n", "[1]\n"):
        (tmp_path / "r.jsonl").write_text(content)
        with pytest.raises(StorageError, match="is no recording: its first line does not name the format"):
            recover_recording(tmp_path / "r.jsonl")


def test_refuses_a_newer_recording(tmp_path: Path) -> None:
    header = {"format": "pft_exec recording", "version": 2, "label": "reach", "period": 0.01}
    (tmp_path / "r.jsonl").write_text(json.dumps(header) + "\n")
    with pytest.raises(StorageError, match="written by a newer pft_exec: its schema has version 2"):
        recover_recording(tmp_path / "r.jsonl")


def test_refuses_a_recording_of_less_than_two_samples(tmp_path: Path) -> None:
    with Recorder("reach", path=tmp_path / "r.jsonl") as recorder:
        recorder.add(0.0, [0.0, 0.0, 0.0])
    with pytest.raises(InvalidDemonstrationError, match="at least 2 samples"):
        recover_recording(tmp_path / "r.jsonl")


def test_refuses_a_path_where_nothing_can_be_written(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="the recording cannot be written to"):
        Recorder("reach", path=tmp_path / "nowhere" / "r.jsonl")
