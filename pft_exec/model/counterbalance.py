r"""Springs that carry an arm, as a potential: the arm's own gravity potential with the wrist held in a fixed posture.

.. math:: \tau_{cb}(q) = f \, \partial V / \partial q \,|_{q_{wrist} = frozen}

A torque that is a gradient can be made by passive springs, and one that ignores the wrist can be made in the shoulder.
It carries no payload: the springs do not know of one. Derivation ours; the published qualification that the residual
passes is that of ``pr2_counterbalance_check`` [PR2SelfTest]_.
"""

from __future__ import annotations

import numpy as np
import pinocchio

from pft_exec.description import CounterbalanceDescription
from pft_exec.geometry import Array


class Counterbalance:
    """Spring torque of an arm as a function of its configuration.

    Parameters
    ----------
    model : pinocchio.Model
        The bare arm, n joints.
    description : CounterbalanceDescription or None
        None: no springs, zero torque.
    joints : tuple of str
        The arm's joint names in order.
    """

    def __init__(
        self, model: pinocchio.Model, description: CounterbalanceDescription | None, joints: tuple[str, ...]
    ) -> None:
        self._model = model
        self._data = model.createData()
        self._fraction = np.zeros(len(joints))
        self._is_frozen = np.zeros(len(joints), dtype=bool)
        self._posture = np.zeros(len(joints))
        self._is_absent = description is None
        self._latest: tuple[bytes, Array] = b"", self._posture
        if description is not None:
            self._fraction[[joints.index(name) for name in description.joints]] = description.fraction
            for name, value in description.frozen.items():
                self._is_frozen[joints.index(name)] = True
                self._posture[joints.index(name)] = value

    def torque(self, q: Array) -> Array:
        """Spring torque (n,), N m, on the joints at configuration `q` (n,), rad."""
        if self._is_absent:
            return np.zeros_like(self._posture)
        posture = q.tobytes()
        if posture != self._latest[0]:
            frozen = np.where(self._is_frozen, self._posture, q)
            self._latest = (
                posture,
                self._fraction * pinocchio.computeGeneralizedGravity(self._model, self._data, frozen),
            )
        return self._latest[1].copy()
