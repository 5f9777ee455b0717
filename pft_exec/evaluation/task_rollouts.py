"""One rollout: a learned motion executed in a scene that nobody taught, and what was measured of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from pft_exec.demonstration import Scene
from pft_exec.description import load_task, random_stream
from pft_exec.description.contact import inside
from pft_exec.evaluation.measurements import beyond
from pft_exec.evaluation.methods import expected_conflicts
from pft_exec.exceptions import UnreachableError
from pft_exec.execution import ExecutionLog, execute, prepare
from pft_exec.execution.log import Stage
from pft_exec.geometry import Array, geodesic_distance
from pft_exec.learning import FlowTube, MotionLibrary
from pft_exec.model import JointLimits, load_robot
from pft_exec.report.film import FPS, Scenes, captioned
from pft_exec.report.video import write_video
from pft_exec.simulation import World, default_arm, extent, render_states, whole_view

DRAWN, MIRRORED = "drawn", "mirrored"
"""Scenes drawn for the arm, and mirror images of those drawn for the taught arm."""

TILE = (240, 180)  # pixels; of the picture of an end
FRAME = (640, 480)  # pixels; of a film


@dataclass(frozen=True)
class Rollout:
    """What is to be executed.

    Parameters
    ----------
    robot, task : str
        Names or paths.
    tool : str or None
        Attachment of the robot.
    label, arm : str
    kind : "drawn" or "mirrored"
    number : int
        Of the scene.
    seed : int
        Of the study.
    """

    robot: str
    task: str
    tool: str | None
    label: str
    arm: str
    kind: str
    number: int
    seed: int

    @property
    def name(self) -> str:
        """Of its files."""
        return f"{self.arm}_{self.kind}_{self.label}_{self.number:03d}"

    @property
    def scene_seed(self) -> int:
        """Seed of its placement; differs between scenes and between studies, and is never one of a lesson."""
        return int(random_stream(self.seed, "evaluate", "rollout", self.number).integers(2**31))


@dataclass(frozen=True)
class RolloutResult:
    """What came of it.

    Parameters
    ----------
    label, arm, kind : str
    number : int
    success, refused : bool
        Refused: the arm said before anything moved that it cannot.
    reason : str
    figures : {name: float}
        See `measure_run`; empty where it was refused.
    """

    label: str
    arm: str
    kind: str
    number: int
    success: bool
    refused: bool
    reason: str
    figures: Mapping[str, float]

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self) | {"figures": dict(self.figures)}


def run_rollout(rollout: Rollout, library: Path, folder: Path, film: str = "failed") -> RolloutResult:
    """Set a world up, execute, measure, and leave a picture of the end; a film where it is asked for.

    Parameters
    ----------
    rollout : Rollout
    library : Path
        Taught with the default arm; mirrored for another.
    folder : Path
        Gets ``<name>.png`` and, perhaps, ``<name>.mp4``.
    film : str
        "none", "failed", "all", or the beginning of the names of those that are filmed.
    """
    with World(load_robot(rollout.robot, tool=rollout.tool), rollout.task, seed=rollout.seed) as world:
        scenes = Scenes(rollout.name)
        try:
            log, tube = _execute(world, rollout, library, scenes)
        except UnreachableError as error:
            result = _result(rollout, False, str(error), {}, refused=True)
        else:
            figures = measure_run(log, tube, world.arm(rollout.arm).limits) | _poured(world, rollout)
            result = _result(rollout, bool(log.success), log.reason, figures)
        _save_tile(world, rollout, folder)
        if scenes.states and is_filmed(film, result, rollout.name):
            _write_film(world, scenes, rollout, folder)
    return result


def _execute(world: World, rollout: Rollout, library: Path, scenes: Scenes) -> tuple[ExecutionLog, FlowTube]:
    """Prepare the scene and execute the motion there."""
    set_up(world, rollout)
    known = _library(library, library.stat().st_mtime_ns, rollout.arm != default_arm(world.robot), rollout.task)
    with expected_conflicts():
        tube = known[rollout.label].flow_tube(world.scene, world.tool(rollout.arm))
    return execute(world, tube, rollout.arm, observer=scenes.observe), tube


def set_up(world: World, rollout: Rollout) -> None:
    """Objects and arm as they stand before a rollout."""
    if rollout.kind == DRAWN:
        prepare(world, rollout.label, rollout.arm, seed=rollout.scene_seed)
        return
    taught = default_arm(world.robot)
    setting = prepare(world, rollout.label, taught, seed=rollout.scene_seed)
    scene = Scene(setting.objects).mirrored(world.base)
    prepare(
        world,
        rollout.label,
        rollout.arm,
        seed=rollout.scene_seed,
        scene=scene,
        start=setting.start.mirrored(world.base),
    )


@lru_cache(maxsize=4)
def _library(path: Path, _changed: int, is_mirrored: bool, task: str) -> MotionLibrary:
    """The library of a file that was last changed at that time, as the taught arm or its mirror image makes it."""
    library = MotionLibrary.load(path)
    return library.mirrored(load_task(task).robot_base) if is_mirrored else library


def measure_run(log: ExecutionLog, tube: FlowTube, limits: JointLimits) -> dict[str, float]:
    """Figures of a run: its own `details` (of what is held, ``slip``, m, among them), and:

    - ``tube_rms``, ``tube_largest``: distance of the tool from the tube's mean at the same phase, m;
    - ``tube_sigmas``: root mean square of that distance in standard deviations of the tube, per axis;
    - ``tube_turned``: largest rotation from the tube's mean, rad;
    - ``torque_share``: largest commanded torque as a share of its limit;
    - ``torque_beyond``, ``position_beyond``, ``velocity_beyond``: beyond the limits, N m, rad, rad/s, or below 0.
    """
    position_beyond, velocity_beyond = beyond(log, limits, guided=False)
    return {
        **{name: float(value) for name, value in log.details.items()},
        **_deviation(log, tube),
        "torque_share": float(np.max(np.abs(log.torque) / limits.torque)),
        "torque_beyond": float(np.max(np.abs(log.torque) - limits.torque)),
        "position_beyond": position_beyond,
        "velocity_beyond": velocity_beyond,
        "duration": float(log.time[-1]),
    }


def _poured(world: World, rollout: Rollout) -> dict[str, float]:
    """Share of the liquid that is in the vessel it should be in now; empty where nothing is poured."""
    poured = world.task.motion(rollout.label).success.poured
    if poured is None or not len(world.liquid):
        return {}
    return {"poured": float(np.mean(inside(world.task, poured.into, world.scene[poured.into], world.liquid)))}


def _deviation(log: ExecutionLog, tube: FlowTube) -> dict[str, float]:
    """How far the tool was from the tube while it followed it, 50 times a second."""
    rows = np.flatnonzero((log.stage == Stage.TUBE) & np.isfinite(log.phase))[::20]
    if not rows.size:
        return {}
    states = [tube.at(float(np.clip(log.phase[row], 0.0, 1.0))) for row in rows]
    offsets: Array = log.position[rows] - np.array([state.position for state in states])
    covariance = np.array([state.covariance[:3, :3] for state in states])
    sigmas = np.einsum("ni,ni->n", offsets, np.linalg.solve(covariance, offsets[..., None])[..., 0]) / 3.0
    distance = np.linalg.norm(offsets, axis=1)
    turned = [
        float(geodesic_distance(state.quaternion, log.quaternion[row]))
        for row, state in zip(rows, states, strict=True)
        if state.quaternion is not None
    ]
    return {
        "tube_rms": float(np.sqrt(np.mean(distance**2))),
        "tube_largest": float(distance.max()),
        "tube_sigmas": float(np.sqrt(np.mean(sigmas))),
        "tube_turned": max(turned, default=0.0),
    }


def _result(
    rollout: Rollout, success: bool, reason: str, figures: Mapping[str, float], refused: bool = False
) -> RolloutResult:
    about = (rollout.label, rollout.arm, rollout.kind, rollout.number)
    return RolloutResult(*about, success, refused, reason, dict(figures))


def is_filmed(film: str, result: RolloutResult, name: str) -> bool:
    """Whether a rollout of a name is to be filmed, where `film` is as of `run_rollout`."""
    if film in ("none", "failed", "all"):
        return film == "all" or (film == "failed" and not result.success)
    return name.startswith(film)


def _save_tile(world: World, rollout: Rollout, folder: Path) -> None:
    """A picture of the world as the rollout left it."""
    from PIL import Image

    image = world.camera.frame(TILE, whole_view(world, rollout.arm))
    Image.fromarray(image).save(folder / f"{rollout.name}.png")


def _write_film(world: World, scenes: Scenes, rollout: Rollout, folder: Path) -> None:
    """A film of a run from one place, from which all of it is seen."""
    passed = []
    for state in scenes.states:
        world.show_state(state)
        passed.append(extent(world, rollout.arm))
    view = whole_view(world, rollout.arm, passed)
    frames = (captioned(frame, scenes.caption) for frame in render_states(world, scenes.states, FRAME, view))
    write_video(frames, folder / f"{rollout.name}.mp4", FPS)
