"""Where robots/ and tasks/ are on disk: the only module that knows paths of the package."""

from __future__ import annotations

from pathlib import Path

from pft_exec.exceptions import UnknownRobotError, UnknownTaskError

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


def _located(name_or_path: str | Path, marker: str) -> Path | None:
    path = Path(name_or_path)
    if path.is_file() and path.suffix == ".toml":
        return path.resolve()
    if (path / marker).is_file() and (path.is_absolute() or len(path.parts) > 1):
        return (path / marker).resolve()
    return None


def robot_file(name_or_path: str | Path) -> Path:
    """Path of a ``robot.toml``, from a robot's name, its folder, or the file itself.

    Raises
    ------
    UnknownRobotError
        If neither a shipped robot nor a path of the user's has that name.
    """
    path = _located(name_or_path, "robot.toml")
    if path is None and str(name_or_path) in robot_names():
        path = _ROOT / "robots" / str(name_or_path) / "robot.toml"
    if path is None:
        hint = "A path to a folder with a robot.toml works too."
        raise UnknownRobotError("robot", str(name_or_path), robot_names(), hint)
    return path


def task_file(name_or_path: str | Path) -> Path:
    """Path of a ``task.toml``, from a task's name, its folder, or the file itself.

    Raises
    ------
    UnknownTaskError
        If neither a shipped task nor a path of the user's has that name.
    """
    path = _located(name_or_path, "task.toml")
    if path is None and str(name_or_path) in task_names():
        path = _ROOT / "tasks" / str(name_or_path) / "task.toml"
    if path is None:
        hint = "A path to a folder with a task.toml works too."
        raise UnknownTaskError("task", str(name_or_path), task_names(), hint)
    return path
