"""Frames to a video file."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
from numpy.typing import NDArray

from pft_exec.exceptions import StorageError


def write_video(frames: Iterable[NDArray[np.uint8]], path: str | Path, fps: float = 25.0) -> Path:
    """Encode frames as H.264, beside the target and renamed.

    Parameters
    ----------
    frames : iterable of (h, w, 3) uint8
        All of one size, even in both directions; taken one at a time.
    path : str or Path
        Ends in .mp4.
    fps : float
        Frames per second.

    Raises
    ------
    StorageError
        If there is no frame, frames differ in size or kind, the suffix is another, or the folder cannot be written to.
    """
    path = Path(path)
    if path.suffix != ".mp4" or not path.parent.is_dir():
        raise StorageError(f"cannot write {path}: a video ends in .mp4 and goes to a folder that exists.")
    beside = path.with_name(f".{path.stem}.{os.getpid()}.partial.mp4")
    try:
        count = _encode(frames, beside, fps)
        if not count:
            raise StorageError(f"cannot write {path}: a video needs at least one frame.")
        beside.replace(path)
    except OSError as error:
        raise error if isinstance(error, StorageError) else StorageError(f"cannot write {path}: {error}.") from error
    finally:
        beside.unlink(missing_ok=True)
    return path


def _encode(frames: Iterable[NDArray[np.uint8]], path: Path, fps: float) -> int:
    """Number of frames written; the encoder is started by the first."""
    writer: Any = None
    shape: tuple[int, ...] = ()
    count = 0
    try:
        for count, frame in enumerate(frames, start=1):
            shape = shape or frame.shape
            if frame.shape != shape or frame.ndim != 3 or frame.shape[2] != 3 or frame.dtype != np.uint8:
                raise StorageError(f"frame {count} has shape {frame.shape} {frame.dtype}; expected {shape} uint8.")
            if writer is None:
                writer = imageio.get_writer(path, fps=fps, codec="libx264", quality=7, macro_block_size=2)
            writer.append_data(frame)
    finally:
        if writer is not None:
            writer.close()
    return count
