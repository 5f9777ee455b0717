"""Where robots/ and tasks/ are on disk: the only module that knows paths of the package."""

from __future__ import annotations

from pathlib import Path

from pft_exec.exceptions import UnknownNameError, UnknownRobotError, UnknownTaskError

_INSTALLED = Path(__file__).parent / "_assets"
_ROOT = _INSTALLED if _INSTALLED.is_dir() else Path(__file__).parent.parent


def _names(folder: str, marker: str) -> tuple[str, ...]:
    """Names of the folders below `folder` that hold the file `marker`, sorted."""
    return tuple(sorted(path.parent.name for path in (_ROOT / folder).glob(f"*/{marker}")))


def robot_names() -> tuple[str, ...]:
    """Names of the robots that ship with the package."""
    return _names("robots", "robot.toml")


def task_names() -> tuple[str, ...]:
    """Names of the tasks that ship with the package."""
    return _names("tasks", "task.toml")


def _file(kind: str, name_or_path: str | Path, missing: type[UnknownNameError]) -> Path:
    """Path of a description; a name that ships with the package is never a folder that happens to lie here."""
    marker, names = f"{kind}.toml", _names(f"{kind}s", f"{kind}.toml")
    path = Path(name_or_path)
    if path.is_file() and path.suffix == ".toml":
        return path.resolve()
    if str(name_or_path) in names:
        return _ROOT / f"{kind}s" / str(name_or_path) / marker
    if (path / marker).is_file():
        return (path / marker).resolve()
    raise missing(kind, str(name_or_path), names, f"A path to a folder with a {marker} works too.")


def robot_file(name_or_path: str | Path) -> Path:
    """Path of a ``robot.toml``, from a robot's name, its folder, or the file itself.

    Raises
    ------
    UnknownRobotError
        If neither a shipped robot nor a path of the user's has that name.
    """
    return _file("robot", name_or_path, UnknownRobotError)


def task_file(name_or_path: str | Path) -> Path:
    """Path of a ``task.toml``, from a task's name, its folder, or the file itself.

    Raises
    ------
    UnknownTaskError
        If neither a shipped task nor a path of the user's has that name.
    """
    return _file("task", name_or_path, UnknownTaskError)
