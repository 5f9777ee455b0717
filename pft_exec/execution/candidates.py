"""The candidates: the motions that the library knows, made ready for the scene as it stands, a little each period.

For every motion there is its tube, the gains and weights of the tube, and, once the motion leads in the recognizer's
belief, the joint path that the arm would take: begun where the arm is, extended by a few samples each control period.
So when the robot takes over, everything is there. Where an object moved, the tubes are made anew, one motion at a time.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from pft_exec.control import Compliance, RollingTrajectory, TubeMetric, compute_compliance, smooth_tube
from pft_exec.demonstration import Scene
from pft_exec.exceptions import MissingObjectError
from pft_exec.execution.control_loop import ControlLoop
from pft_exec.geometry import Array, Pose
from pft_exec.learning import FlowTube, MotionLibrary

SAMPLES_PER_PERIOD = 4
"""Samples of joint path (10 ms each) that are computed in a control period: 0.15 ms."""
HORIZON = 1.0
"""s of joint path that must be known when the robot takes over."""
BEHIND = 0.2
"""s of tube time before the place of the motion at which its joint path begins: the phase may step back."""
STRAYED = 0.4
"""rad; where the arm's joints are farther than this from the path, another path is begun."""
PATIENCE = 0.3
"""s that a path is kept at least."""


class Candidate:
    """One motion in the present scene, with all that it takes to finish it.

    Parameters
    ----------
    loop : ControlLoop
    tube : FlowTube
        World frame.
    softness : float, s^4/m^2
        See `pft_exec.control.compute_compliance`.
    """

    def __init__(self, loop: ControlLoop, tube: FlowTube, softness: float) -> None:
        in_base = tube.transformed(loop.world.base.inverse())
        self.label = tube.label
        self.tube = tube
        self.compliance: Compliance = compute_compliance(in_base, softness)
        self.metric = TubeMetric(in_base)
        self._loop = loop
        self._smooth = smooth_tube(in_base, loop.arm.forward(loop.sense()[0]).quaternion)
        self._path: RollingTrajectory | None = None
        self._begun = -np.inf

    def tube_time(self, phase: float) -> float:
        """Tube time, s, of a phase."""
        return float(np.interp(phase, self.tube.phase, self.tube.time))

    def path(self, phase: float) -> RollingTrajectory:
        """The joint path from a phase on; begun anew where there is none, or not one near where the arm is."""
        theta, q = self.tube_time(phase), self._loop.sense()[0]
        if self._path is None or self._is_stale(self._path, theta, q):
            self._path = RollingTrajectory(
                self._loop.arm, self._smooth, q, max(theta - BEHIND, float(self.tube.time[0]))
            )
            self._begun = self._loop.time
        return self._path

    def lead(self, phase: float) -> None:
        """Get on with the joint path: the motion leads, and is at a phase."""
        self.path(phase).extend(SAMPLES_PER_PERIOD)

    def is_ready(self, phase: float) -> bool:
        """Whether the path is known far enough to take over at a phase."""
        path = self.path(phase)
        return path.is_complete or path.known_until >= self.tube_time(phase) + HORIZON

    def _is_stale(self, path: RollingTrajectory, theta: float, q: Array) -> bool:
        if self._loop.time - self._begun < PATIENCE or path.known_until <= theta:
            return theta < path.begin
        planned = path.reference(max(theta, path.begin), 0.0, 0.0).configuration
        return theta < path.begin or float(np.max(np.abs(planned - q))) > STRAYED


class Candidates:
    """All motions of a library in the present scene.

    Parameters
    ----------
    loop : ControlLoop
    library : MotionLibrary
    scene : Scene
        Objects now, world frame.
    start : Pose
        Of the tool where the motion began, world frame.
    softness : float, s^4/m^2
    substitute : {name: name}, optional
        Taught object to the one that takes its place.
    """

    def __init__(
        self,
        loop: ControlLoop,
        library: MotionLibrary,
        scene: Scene,
        start: Pose,
        softness: float,
        substitute: Mapping[str, str] | None = None,
    ) -> None:
        self._loop, self._library, self._softness = loop, library, softness
        self.substitute = dict(substitute or {})
        tubes = library.flow_tubes(scene, start, self.substitute)
        self.by_label = {label: Candidate(loop, tube, softness) for label, tube in tubes.items()}
        self._renewal: Iterator[Candidate | None] | None = None
        self._renewed: dict[str, Candidate] = {}

    @property
    def tubes(self) -> dict[str, FlowTube]:
        """Tubes of all motions, world frame."""
        return {label: candidate.tube for label, candidate in self.by_label.items()}

    def renew(self, scene: Scene, start: Pose) -> None:
        """Begin to make all tubes anew, in another scene or from another start; `work` goes on with it."""
        self._renewed = {}
        self._renewal = self._make(scene, start)

    def work(self) -> bool:
        """Make one motion anew; True where that was the last, and the candidates are others from now on."""
        if self._renewal is None:
            return False
        made = next(self._renewal, None)
        if made is not None:
            self._renewed[made.label] = made
            return False
        self._renewal = None
        self.by_label = self._renewed
        return True

    def _make(self, scene: Scene, start: Pose) -> Iterator[Candidate]:
        """One candidate after the other; a motion whose object is gone keeps the tube that it had."""
        for label, before in list(self.by_label.items()):
            try:
                tube = self._library.flow_tube(label, scene, start, self.substitute)
            except MissingObjectError:
                yield before
            else:
                yield Candidate(self._loop, tube, self._softness)
