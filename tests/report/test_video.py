"""Frames become a video that reads back, or an error."""

from __future__ import annotations

import warnings
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest

from pft_exec.exceptions import StorageError
from pft_exec.report import write_video


def frames(count: int, size: tuple[int, int] = (48, 64)) -> list[np.ndarray]:
    return [np.full((*size, 3), 8 * number, np.uint8) for number in range(count)]


def read(path: Path) -> list:
    """What the video says of itself, then its frames as bytes; the decoder is closed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # pipes of the decoder's process
        return list(imageio_ffmpeg.read_frames(path))


def test_a_video_reads_back_with_as_many_frames_of_the_same_size(tmp_path: Path) -> None:
    write_video(iter(frames(12)), tmp_path / "a.mp4", fps=20.0)
    count, seconds = imageio_ffmpeg.count_frames_and_secs(tmp_path / "a.mp4")
    assert (count, seconds) == (12, pytest.approx(12 / 20.0, abs=0.02))
    about, first, *_, last = read(tmp_path / "a.mp4")
    assert about["source_size"] == (64, 48)
    assert np.frombuffer(first, np.uint8).mean() == pytest.approx(0, abs=6)
    assert np.frombuffer(last, np.uint8).mean() == pytest.approx(88, abs=6)
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]


def test_no_frame_or_frames_that_differ_are_refused_and_leave_nothing(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="at least one frame"):
        write_video([], tmp_path / "a.mp4")
    with pytest.raises(StorageError, match=r"frame 4 has shape \(24, 64, 3\)"):
        write_video([*frames(3), *frames(1, (24, 64))], tmp_path / "a.mp4")
    with pytest.raises(StorageError, match=r"frame 1 has shape .* float64"):
        write_video([np.zeros((48, 64, 3))], tmp_path / "a.mp4")  # type: ignore[list-item]
    assert not list(tmp_path.iterdir())


def test_an_old_video_stays_when_the_new_one_fails(tmp_path: Path) -> None:
    write_video(frames(3), tmp_path / "a.mp4")
    before = (tmp_path / "a.mp4").read_bytes()
    with pytest.raises(StorageError):
        write_video([], tmp_path / "a.mp4")
    assert (tmp_path / "a.mp4").read_bytes() == before


def test_another_suffix_or_a_missing_folder_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "a.gif", tmp_path / "nowhere" / "a.mp4"):
        with pytest.raises(StorageError, match=r"ends in \.mp4"):
            write_video(frames(1), path)
