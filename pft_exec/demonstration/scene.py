"""A scene: where the objects are, in the world frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from pft_exec.exceptions import InvalidSceneError, MissingObjectError
from pft_exec.geometry import Pose


@dataclass(frozen=True)
class Scene:
    """Named objects and their poses, world frame.

    Parameters
    ----------
    objects : mapping of name to Pose
        World frame, m and quaternion (x, y, z, w).

    Raises
    ------
    InvalidSceneError
        If the objects are no mapping, or a value is not a `Pose`.
    """

    objects: Mapping[str, Pose] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.objects, Mapping):
            raise InvalidSceneError(f"a scene is a mapping of names to poses; got {type(self.objects).__name__}.")
        for name, pose in self.objects.items():
            if not isinstance(pose, Pose):
                raise InvalidSceneError(
                    f"object {name!r} of a scene must be a Pose; got {type(pose).__name__}. "
                    f"Wrap it: Pose(position, quaternion)."
                )
        object.__setattr__(self, "objects", MappingProxyType(dict(self.objects)))

    def __getitem__(self, name: str) -> Pose:
        try:
            return self.objects[name]
        except KeyError:
            raise MissingObjectError("object of the scene", name, self.objects) from None

    def __contains__(self, name: object) -> bool:
        return name in self.objects

    def __iter__(self) -> Iterator[str]:
        return iter(self.objects)

    def __len__(self) -> int:
        return len(self.objects)

    def __reduce__(self) -> tuple[type[Scene], tuple[dict[str, Pose]]]:
        return Scene, (dict(self.objects),)

    def mirrored(self, plane: Pose | None = None) -> Scene:
        """Every object mirrored in the xz plane of `plane` (identity where None)."""
        return Scene({name: pose.mirrored(plane) for name, pose in self.objects.items()})
