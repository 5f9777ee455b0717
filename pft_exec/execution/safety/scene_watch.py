"""The scene watch: says when the objects stand otherwise than the tubes were made for.

What moves within the tool's reach is carried or pushed by it: that belongs to the motion, whose tube counts from where
the object was. What moves elsewhere was moved by somebody else, and the tubes are made anew.
"""

from __future__ import annotations

import numpy as np

from pft_exec.demonstration import Scene
from pft_exec.geometry import Pose, geodesic_distance

MOVED = (0.005, 0.05)
"""m, rad; less is a camera's noise."""
SETTLED_TIME = 0.2
"""s for which an object must have stayed in its new place: a jump for a moment is not believed."""
TOUCH = 0.15
"""m from the tool's origin to an object's that the tool may be moving."""


class SceneWatch:
    """Watch objects beside a scene that tubes were made for.

    Parameters
    ----------
    scene : Scene
        World frame.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._touched: set[str] = set()
        self._moved_to: dict[str, tuple[Pose, float]] = {}

    def update(self, time: float, seen: Scene, tool: Pose) -> Scene | None:
        """Take the scene as it is seen at a time, s; another scene where tubes must be made anew.

        Parameters
        ----------
        time : float, s
        seen : Scene
            An object that is missing counts as standing where it was.
        tool : Pose
            World frame.
        """
        settled = {}
        for name, before in self.scene.objects.items():
            now = seen.objects.get(name)
            if now is None or not is_moved(before, now):
                self._moved_to.pop(name, None)
            elif np.linalg.norm(now.position - tool.position) < TOUCH or name in self._touched:
                self._touched.add(name)
            elif self._has_settled(name, now, time):
                settled[name] = now
        if not settled:
            return None
        self.scene = Scene({**self.scene.objects, **settled})
        self._moved_to.clear()
        return self.scene

    def _has_settled(self, name: str, now: Pose, time: float) -> bool:
        """Whether a moved object has stayed where it is now."""
        place, since = self._moved_to.get(name, (now, time))
        if is_moved(place, now):
            place, since = now, time
        self._moved_to[name] = place, since
        return time - since >= SETTLED_TIME


def is_moved(before: Pose, now: Pose) -> bool:
    """Whether an object has moved by more than `MOVED`."""
    if np.linalg.norm(now.position - before.position) > MOVED[0]:
        return True
    return float(geodesic_distance(before.quaternion, now.quaternion)) > MOVED[1]
