"""Compliance: how far a push moves the tool where the tube is wide and where it is narrow, and how it comes back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pft_exec.evaluation.benchmarks.stopwatch import Tables
from pft_exec.evaluation.protocol import Progress

if TYPE_CHECKING:
    from pft_exec.control import Compliance, JointTrajectory
    from pft_exec.evaluation.benchmarks.plant import Mismatch, Run
    from pft_exec.model import Arm

PUSH, PUSHED = 10.0, 0.3
"""N and s; across the tube."""
WIDE, LATE = 0.45, 0.1
"""Share of the motion at which the push in the wide part begins, and time, s, before the end of the one in the narrow
part."""
NEAR = 0.005
"""m; the tool has recovered when the push no longer shows by more than this."""
WRONG = 1.25
"""Friction of the plant: the model's is 20 % too low."""
PAYLOAD = 0.5
"""kg; at the tool, unknown."""
HOLD = 0.8
"""s of rest after the motion."""
_STATIC = (3.0, 2.5)  # N and s; force, and how long it acts, for the static stiffness


def measure_compliance(seed: int, progress: Progress) -> Tables:
    """Deviation, recovery, static stiffness and end error under pushes, with constant gains in the same run."""
    from pft_exec.control import compute_compliance, constant_compliance
    from pft_exec.evaluation.benchmarks.plant import arch_trajectory, arch_tube
    from pft_exec.model import load_robot

    arm = load_robot("pr2").arm("right")
    tube = arch_tube(arm)
    trajectory = arch_trajectory(arm, tube)
    gains = {
        "tube, softness 0.1": compute_compliance(tube, 0.1),
        "tube, softness 0.3": compute_compliance(tube, 0.3),
        "constant 400 /s2": constant_compliance(400.0),
        "constant 20 /s2": constant_compliance(20.0),
    }
    pushes, ends = [], []
    for place, (name, compliance) in enumerate(gains.items()):
        progress(f"pushing: {name}", place / len(gains))
        trial = _Trial(arm, trajectory, compliance, seed)
        pushes.append({"gains": name, **trial.push_row()})
        ends.append({"gains": name, **trial.end_row()})
    return {
        f"{PUSH:.0f} N for {PUSHED} s across the tube, friction 20 % wrong": pushes,
        "end error after the push in the wide part": ends,
    }


class _Trial:
    """One set of gains, pushed in several ways."""

    def __init__(self, arm: Arm, trajectory: JointTrajectory, compliance: Compliance, seed: int) -> None:
        from pft_exec.evaluation.benchmarks.plant import Mismatch

        self.arm, self.trajectory, self.compliance, self.seed = arm, trajectory, compliance, seed
        self.wrong = Mismatch(friction=WRONG)
        self.wide, self.narrow = WIDE * trajectory.duration, trajectory.duration - LATE

    def run(self, mismatch: Mismatch, begin: float | None = None) -> Run:
        """Follow the tube, pushed from `begin`, s, on."""
        from pft_exec.control import TrackingController
        from pft_exec.evaluation.benchmarks.plant import PERIOD, Plant, run

        controller = TrackingController(self.arm, PERIOD)
        controller.follow(self.trajectory.at, self.compliance, 0.0, blend=False)
        plant = Plant(self.arm, self.trajectory.at(0.0).configuration, mismatch, self.seed)
        push = np.array([0.0, PUSH, 0.0])
        return run(
            controller,
            plant,
            self.trajectory.duration + HOLD,
            lambda t: push * float(begin is not None and begin <= t < begin + PUSHED),
        )

    def push_row(self) -> dict[str, Any]:
        """Deviations by pushes, m, how long they last, and the static stiffness."""
        free = self.run(self.wrong)
        wide, narrow = self.run(self.wrong, self.wide), self.run(self.wrong, self.narrow)
        far, near = (1e3 * float(np.abs(_across(pushed, free)).max()) for pushed in (wide, narrow))
        soft, stiff = self.static_stiffness(0.5), self.static_stiffness(1.0)
        return {
            "wide mm": far,
            "narrow mm": near,
            "ratio": far / near,
            "recovery wide s": _recovery(wide, free, self.wide),
            "recovery narrow s": _recovery(narrow, free, self.narrow),
            "static wide N/m": soft,
            "static narrow N/m": stiff,
            "static ratio": stiff / soft,
        }

    def end_row(self) -> dict[str, Any]:
        """Distance of the tool from the tube's end at rest, mm."""
        from pft_exec.evaluation.benchmarks.plant import Mismatch

        heavy = Mismatch(payload=PAYLOAD)
        everything = Mismatch(friction=WRONG, payload=PAYLOAD, noise=1e-4, ripple=0.1, is_late=True)
        return {
            "friction 20 % wrong mm": _end(self.run(self.wrong, self.wide)),
            "payload 0.5 kg unknown mm": _end(self.run(heavy, self.wide)),
            "both, noise, ripple, delay mm": _end(self.run(everything, self.wide)),
        }

    def static_stiffness(self, phase: float) -> float:
        """Force by displacement along itself, N/m, of a tool at rest at a phase; friction would hide it, so without."""
        from pft_exec.control import JointReference, TrackingController
        from pft_exec.evaluation.benchmarks.plant import PERIOD, Plant, run, with_friction

        arm = with_friction(self.arm, 0.0)
        place = self.trajectory.at(phase * self.trajectory.duration)
        rest = np.zeros_like(place.velocity)
        held = JointReference(place.configuration, rest, rest, phase)
        controller = TrackingController(arm, PERIOD, weigh=False)
        controller.follow(lambda _: held, self.compliance, 0.0, blend=False)
        force, duration = _STATIC
        run_ = run(controller, Plant(arm, place.configuration), duration, lambda _: np.array([0.0, force, 0.0]))
        return force / abs(float(run_.error[-1, 1]))


def _across(pushed: Run, free: Run) -> Any:
    """How far a push moved the tool across the tube, (T,), m."""
    return pushed.error[:, 1] - free.error[:, 1]


def _recovery(pushed: Run, free: Run, begin: float) -> float:
    """Time, s, from the end of a push until it no longer shows by more than `NEAR`."""
    over = (np.abs(_across(pushed, free)) > NEAR) & (pushed.time > begin + PUSHED)
    return float(pushed.time[over][-1] - begin - PUSHED) if over.any() else 0.0


def _end(run: Run) -> float:
    """Distance, mm, of the tool from the reference at the end."""
    return 1e3 * float(np.linalg.norm(run.error[-1, :3]))
