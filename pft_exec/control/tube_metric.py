r"""How far the tool is from a tube, in the tube's own deviations: the distance of Mahalanobis, and its parts.

.. math:: d^2 = e^T (\Sigma + F)^{-1} e = \lVert U e \rVert^2,

with the error e as in the tube's covariance, (position in base axes; rotation vector of ``reference^-1 * tool`` in the
reference tool frame), and a floor F of errors that are ordinary.
"""

from __future__ import annotations

import math
from bisect import bisect_left

import numpy as np
import pinocchio

from pft_exec.control.compliance import FLOOR, UNTAUGHT_ROTATION
from pft_exec.control.reference import JointReference
from pft_exec.geometry import Array
from pft_exec.learning.flow_tube import FlowTube
from pft_exec.model import Arm


class TubeMetric:
    """Measure errors of the tool by a tube.

    Parameters
    ----------
    tube : FlowTube
        Base frame.
    floor : (float, float), m, rad
        Deviations added to the tube's own.
    untaught_rotation : float, rad
        Deviation of the orientation along tubes that have none.
    """

    def __init__(
        self, tube: FlowTube, floor: tuple[float, float] = FLOOR, untaught_rotation: float = UNTAUGHT_ROTATION
    ) -> None:
        size = tube.covariance.shape[-1]
        covariance = np.zeros((len(tube), 6, 6))
        covariance[:, range(3, 6), range(3, 6)] = untaught_rotation**2
        covariance[:, :size, :size] = tube.covariance
        precision: Array = np.linalg.inv(covariance + np.diag(np.repeat(np.square(floor), 3))).astype(float)
        self._precision = list(precision)
        self._roots = list(np.linalg.cholesky(precision).swapaxes(1, 2))
        self._phases: list[float] = tube.phase.tolist()

    def distance(self, phase: float, error: Array) -> float:
        """Mahalanobis distance of an error (6,), m and rad, from the tube at a phase."""
        return math.sqrt(max(float(error.dot(self._precision[self._place(phase)]).dot(error)), 0.0))

    def deviation(self, arm: Arm, reference: JointReference, q: Array) -> tuple[Array, Array]:
        """Error (6,) of the tool at q (n,), rad, from a reference, in deviations U e, and its derivative (6, n), 1/rad.

        The derivative of the rotation is that of a small one.
        """
        position, rotation, jacobian = arm.kinematics(q)
        on_position, on_rotation, _ = arm.kinematics(reference.configuration)
        root = self._roots[self._place(reference.phase)]
        error = np.concatenate([position - on_position, pinocchio.log3(on_rotation.T @ rotation)])
        derivative: Array = root[:, :3] @ jacobian[:3] + root[:, 3:] @ on_rotation.T @ jacobian[3:]
        return root @ error, derivative

    def _place(self, phase: float) -> int:
        """Index of the step at a phase."""
        return min(bisect_left(self._phases, phase), len(self._phases) - 1)
