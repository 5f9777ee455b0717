"""Generation in a scene that was never taught: one motion towards nine placements of a target, one left out at a time.

Each method sees the demonstrations of some other placements, the frames of the new one (where the motion starts, and
the target) and the start of the tool, and predicts a Gaussian at each phase of the motion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2, norm

from pft_exec.demonstration import Demonstration, convert_recordings
from pft_exec.demonstration.synthetic import minimum_jerk
from pft_exec.evaluation.baselines.nearest_neighbor import warped_distance
from pft_exec.evaluation.methods import expected_conflicts, published_options
from pft_exec.evaluation.protocol import Interval, Progress, silent
from pft_exec.geometry import Array, Pose
from pft_exec.learning import learn_motion

PHASES = 100  # at which prediction and truth are compared, evenly in time
TAUGHT = 5  # demonstrations that teach
SIGMAS = (1.0, 2.0, 3.0)
TARGET = "frame2"
START = "frame1"

# What was known before: median time-normalized RMSE (px) and DTW distance (% of the path), 5 demonstrations.
KNOWN = {
    "known: similarity": (9.2, 8.4),
    "known: bending": (9.9, 9.6),
    "known: product of Gaussians": (6.6, 3.1),
    "known: stacked frames": (4.9, 3.1),
}


@dataclass(frozen=True, eq=False)
class Prediction:
    """A Gaussian in the plane at `PHASES` phases: mean (N, 2) and covariance (N, 2, 2), units of the recording."""

    mean: Array
    covariance: Array


Predict = Callable[[Sequence[Demonstration], Demonstration], Prediction]


@dataclass(frozen=True)
class Errors:
    """How one prediction compares with what the person did, units of the recording.

    Parameters
    ----------
    rmse : float
        Root mean square distance at equal shares of the time.
    warped : float
        Mean distance along the best alignment, as a share of the path's length.
    end : float
        Distance of the last points.
    coverage : (float, float, float)
        Share of samples within the regions that hold 68.3, 95.4 and 99.7 % of a Gaussian.
    log_density : float
        Mean log density of the samples.
    """

    rmse: float
    warped: float
    end: float
    coverage: tuple[float, ...]
    log_density: float


@dataclass(frozen=True, eq=False)
class ReachResult:
    """Errors of each method over placements and draws of the teaching demonstrations."""

    errors: Mapping[str, tuple[Errors, ...]]
    taught: int

    def table(self) -> list[dict[str, Any]]:
        """Rows: each method; medians of errors, means of coverage and log density; and what was known before."""
        rows: list[dict[str, Any]] = []
        for method, errors in self.errors.items():
            coverage = 100.0 * np.mean([item.coverage for item in errors], axis=0)
            rows.append(
                {
                    "method": method,
                    "RMSE px": f"{np.median([item.rmse for item in errors]):.2f}",
                    "DTW %": f"{100 * np.median([item.warped for item in errors]):.2f}",
                    "mean DTW %": f"{100 * np.mean([item.warped for item in errors]):.2f}",
                    "end px": f"{np.median([item.end for item in errors]):.2f}",
                    "within 1/2/3 sigma %": " / ".join(f"{value:.0f}" for value in coverage),
                    "log density": f"{np.mean([item.log_density for item in errors]):.2f}",
                }
            )
        known = [{"method": name, "RMSE px": f"{r:g}", "DTW %": f"{d:g}"} for name, (r, d) in KNOWN.items()]
        return rows + (known if self.taught == TAUGHT else [])

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "taught": self.taught,
            "methods": {
                method: {
                    "rmse_median": float(np.median([item.rmse for item in errors])),
                    "warped_median": float(np.median([item.warped for item in errors])),
                    "end_median": float(np.median([item.end for item in errors])),
                    "coverage": np.mean([item.coverage for item in errors], axis=0).tolist(),
                    "log_density": Interval.of([item.log_density for item in errors]).to_dict(),
                }
                for method, errors in self.errors.items()
            },
        }


def evaluate_reach(folder: Path, draws: int = 20, taught: int = TAUGHT, progress: Progress = silent) -> ReachResult:
    """Leave each placement out; teach with `taught` of the others, drawn `draws` times.

    Parameters
    ----------
    folder : Path
        Where the recordings are.
    draws, taught : int
    progress : callable
    """
    demonstrations = convert_recordings(folder / "reach_target.npz")
    errors: dict[str, list[Errors]] = {method: [] for method in PREDICTORS}
    for left_out, truth in enumerate(demonstrations):
        progress(f"reach_target, placement {left_out + 1} of {len(demonstrations)}", left_out / len(demonstrations))
        others = [item for index, item in enumerate(demonstrations) if index != left_out]
        for draw in range(draws if taught < len(others) else 1):
            chosen = np.random.default_rng([draw, left_out]).permutation(len(others))[:taught]
            for method, predict in PREDICTORS.items():
                errors[method].append(compare(predict([others[i] for i in sorted(chosen)], truth), truth))
    return ReachResult({method: tuple(values) for method, values in errors.items()}, taught)


def compare(prediction: Prediction, truth: Demonstration) -> Errors:
    """Prediction against what the person did."""
    path = resampled(truth)
    difference = path - prediction.mean
    length = float(np.linalg.norm(np.diff(truth.position[:, :2], axis=0), axis=1).sum())
    squared = np.einsum("ni,ni->n", difference, np.linalg.solve(prediction.covariance, difference[..., None])[..., 0])
    log_determinant = np.linalg.slogdet(prediction.covariance)[1]
    limits = np.atleast_1d(chi2.isf(2.0 * norm.sf(SIGMAS), 2))
    return Errors(
        rmse=float(np.sqrt(np.mean(np.sum(difference**2, axis=1)))),
        warped=warped_distance(prediction.mean, path) / length,
        end=float(np.linalg.norm(difference[-1])),
        coverage=tuple(float(np.mean(squared <= limit)) for limit in limits),
        log_density=float(np.mean(-0.5 * (squared + log_determinant) - np.log(2.0 * np.pi))),
    )


def resampled(demonstration: Demonstration) -> Array:
    """Positions (PHASES, 2) evenly in time."""
    time = demonstration.time
    grid = np.linspace(time[0], time[-1], PHASES)
    return np.stack([np.interp(grid, time, demonstration.position[:, axis]) for axis in range(2)], axis=1)


def flow_tube(train: Sequence[Demonstration], truth: Demonstration, method: str) -> Prediction:
    """The tube of a motion learned from the demonstrations, made for the new scene and start, read evenly in time."""
    options = published_options(train) if method == "dong2012" else {}
    with expected_conflicts():
        tube = learn_motion(train, method=method, **options).flow_tube(truth.scene, truth.start)
    span = max(tube.duration, 1e-12)
    grid = np.linspace(0.0, 1.0, PHASES)
    place = np.interp(grid, (tube.time - tube.time[0]) / span, tube.phase)
    states = [tube.at(float(np.clip(phase, 0.0, 1.0))) for phase in place]
    return Prediction(
        np.array([state.position[:2] for state in states]), np.array([state.covariance[:2, :2] for state in states])
    )


def straight_line(train: Sequence[Demonstration], truth: Demonstration) -> Prediction:
    """Minimum jerk from the start to where the demonstrations ended, seen from the target."""
    share = minimum_jerk(np.linspace(0.0, 1.0, PHASES))[:, None]
    end = _expected_end(train, truth)
    mean = truth.position[0, :2] + share * (end - truth.position[0, :2])
    residual = [
        resampled(item) - (item.position[0, :2] + share * (item.position[-1, :2] - item.position[0, :2]))
        for item in train
    ]
    return _gaussian(mean, np.array(residual), centered=True)


def similarity(train: Sequence[Demonstration], truth: Demonstration) -> Prediction:
    """Each demonstration scaled, turned and moved so that its ends lie where they should."""
    start, end = truth.position[0, :2], _expected_end(train, truth)
    carried = []
    for item in train:
        path = resampled(item)
        ratio = complex(*(end - start)) / complex(*(path[-1] - path[0]))
        moved = ratio * ((path - path[0]) @ np.array([1.0, 1.0j]))
        carried.append(start + np.stack([moved.real, moved.imag], axis=1))
    return _gaussian(np.mean(carried, axis=0), np.array(carried) - np.mean(carried, axis=0))


def bending(train: Sequence[Demonstration], truth: Demonstration) -> Prediction:
    """Each demonstration bent: the corrections of its two ends are spread along its arc length."""
    start, end = truth.position[0, :2], _expected_end(train, truth)
    carried = []
    for item in train:
        path = resampled(item)
        arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))[:, None]
        share = arc / max(float(arc[-1, 0]), 1e-12)
        carried.append(path + (1.0 - share) * (start - path[0]) + share * (end - path[-1]))
    return _gaussian(np.mean(carried, axis=0), np.array(carried) - np.mean(carried, axis=0))


def product_of_gaussians(train: Sequence[Demonstration], truth: Demonstration) -> Prediction:
    """A Gaussian per phase in the frame of the start and one in the frame of the target, multiplied [Calinon2016]_."""
    precision, weighted = np.zeros((PHASES, 2, 2)), np.zeros((PHASES, 2))
    for frame in (START, TARGET):
        local = np.array([_in_frame(item.scene[frame], resampled(item)) for item in train])
        here = _gaussian(local.mean(axis=0), local - local.mean(axis=0))
        turn = truth.scene[frame].rotation[:2, :2]
        mean = here.mean @ turn.T + truth.scene[frame].position[:2]
        inverse = np.linalg.inv(turn @ here.covariance @ turn.T)
        precision += inverse
        weighted += np.einsum("nij,nj->ni", inverse, mean)
    covariance: Array = np.linalg.inv(precision).astype(float)
    return Prediction(np.einsum("nij,nj->ni", covariance, weighted), covariance)


def _in_frame(frame: Pose, points: Array) -> Array:
    """Planar points (N, 2) seen from a frame."""
    local: Array = (points - frame.position[:2]) @ frame.rotation[:2, :2]
    return local


def _expected_end(train: Sequence[Demonstration], truth: Demonstration) -> Array:
    """Mean end of the demonstrations, seen from the target, where the target is now."""
    local = np.mean([_in_frame(item.scene[TARGET], item.position[-1:, :2])[0] for item in train], axis=0)
    frame = truth.scene[TARGET]
    end: Array = frame.position[:2] + frame.rotation[:2, :2] @ local
    return end


def _gaussian(mean: Array, residual: Array, centered: bool = False) -> Prediction:
    """Covariance (N, 2, 2) of residuals (K, N, 2); a thousandth of the path's extent keeps it from being singular."""
    freedom = len(residual) if centered else len(residual) - 1
    covariance = np.einsum("kni,knj->nij", residual, residual) / max(freedom, 1)
    floor = (1e-3 * float(np.linalg.norm(np.ptp(mean, axis=0)))) ** 2
    return Prediction(mean, covariance + floor * np.eye(2))


PREDICTORS: dict[str, Predict] = {
    "robust": lambda train, truth: flow_tube(train, truth, "robust"),
    "dong2012": lambda train, truth: flow_tube(train, truth, "dong2012"),
    "straight line": straight_line,
    "similarity": similarity,
    "bending": bending,
    "product of Gaussians": product_of_gaussians,
}
