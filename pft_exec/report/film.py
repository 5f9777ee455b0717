"""A film of several runs: states are recorded while they run, pictures are made meanwhile in a process of their own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pft_exec.exceptions import StorageError
from pft_exec.report.video import write_video
from pft_exec.simulation import World
from pft_exec.simulation.replay import WorldState, render_states

FPS = 15.0
"""Frames per second of the film, and states recorded per second of a run."""
SIZE = (640, 480)


@dataclass
class Scenes:
    """States of one run, recorded by handing it `observe` as its observer."""

    caption: str
    states: list[WorldState] = field(default_factory=list)
    _next: float = 0.0

    def observe(self, world: World) -> None:
        """Record the world's state, `FPS` times a second."""
        if not self.states:
            self._next = world.time
        if world.time >= self._next - 1e-9:
            self.states.append(world.record_state())
            self._next += 1.0 / FPS


class Film:
    """A film that is rendered and encoded in a process of its own while the runs go on.

    Parameters
    ----------
    path : str or Path
        Ends in .mp4.
    robot, task : str
        Names or paths; the renderer opens a world of them.

    Raises
    ------
    StorageError
        On leaving, if the film could not be made.
    """

    def __init__(self, path: str | Path, robot: str, task: str) -> None:
        self.path = Path(path)
        context = get_context("spawn")
        self._queue = context.Queue()
        self._process = context.Process(target=_render, args=(self._queue, self.path, robot, task), daemon=True)

    def __enter__(self) -> Film:
        self._process.start()
        return self

    def add(self, scenes: Scenes) -> None:
        """Append a run."""
        if scenes.states:
            self._queue.put((scenes.caption, scenes.states))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._queue.put(None)
        self._process.join()
        if error is None and self._process.exitcode != 0:
            raise StorageError(f"{self.path} could not be made: the renderer ended with {self._process.exitcode}.")


def _render(queue: Any, path: Path, robot: str, task: str) -> None:
    """Take runs from a queue until None comes, and write their pictures."""
    with World(robot, task) as world:
        write_video(_frames(world, queue.get), path, FPS)


def _frames(world: World, get: Callable[[], Any]) -> Iterator[NDArray[np.uint8]]:
    while (part := get()) is not None:
        caption, states = part
        for frame in render_states(world, states, SIZE):
            yield captioned(frame, caption)


def captioned(frame: NDArray[np.uint8], caption: str) -> NDArray[np.uint8]:
    """The picture (h, w, 3) with a line of text in its upper left corner."""
    from PIL import Image, ImageDraw, ImageFont

    image = Image.fromarray(frame)
    drawing = ImageDraw.Draw(image)
    font = ImageFont.load_default(size=max(12, frame.shape[0] // 28))
    box = drawing.textbbox((10, 8), caption, font=font)
    drawing.rectangle((box[0] - 5, box[1] - 4, box[2] + 5, box[3] + 4), fill=(255, 255, 255))
    drawing.text((10, 8), caption, fill=(20, 20, 20), font=font)
    return np.asarray(image)
