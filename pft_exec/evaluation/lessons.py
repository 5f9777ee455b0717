"""Lessons: demonstrations that an evaluation asks for by description, taught once and kept in a folder.

Teaching is simulated and takes time. A lesson that has its file is read back bit for bit; one whose robot, task or
version differs has another file, so that nothing stale is ever read.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path

from joblib import Parallel, delayed

from pft_exec import __version__
from pft_exec.assets import robot_file, task_file
from pft_exec.demonstration import Demonstration, load_demonstrations, save_demonstrations
from pft_exec.description import load_task
from pft_exec.evaluation.protocol import Progress, silent
from pft_exec.execution import teach
from pft_exec.model import load_robot
from pft_exec.simulation import World

Taught = Mapping["Lesson", tuple[Demonstration, ...]]


@dataclass(frozen=True)
class Lesson:
    """One motion, taught several times.

    Parameters
    ----------
    robot, task : str
        Names or paths.
    label : str
    seed : int
        Of the person and the placements.
    count : int
        Demonstrations.
    arm : str or None
        None is the only one, else "right".
    tool : str or None
        Attachment of the robot.
    same_scene : bool
        All demonstrations in one scene; only the tool's start and the person vary.
    """

    robot: str
    task: str
    label: str
    seed: int
    count: int = 5
    arm: str | None = None
    tool: str | None = None
    same_scene: bool = False

    @property
    def fingerprint(self) -> str:
        """Eight hexadecimal digits that change with anything these demonstrations depend on, the code apart."""
        content = sha256(repr(sorted(asdict(self).items())).encode())
        content.update(described(self.robot, self.task).encode())
        return content.hexdigest()[:8]

    @property
    def file_name(self) -> str:
        """Of the demonstrations in a folder of lessons."""
        return f"{self.label}_seed{self.seed}_{self.fingerprint}.h5"

    def teach(self) -> list[Demonstration]:
        """Simulate the lesson.

        Raises
        ------
        UnreachableError
            If the arm cannot be led through it.
        """
        with World(load_robot(self.robot, tool=self.tool), self.task, seed=self.seed) as world:
            scene = world.draw_scene(self.seed, self.arm) if self.same_scene else None
            return teach(world, self.label, self.arm, self.count, seed=self.seed, scene=scene)


@dataclass(frozen=True)
class Subject:
    """What a study is about: every motion of a task, on a robot, as one person teaches it.

    Parameters
    ----------
    robot, task : str
        Names or paths.
    tool : str or None
        Attachment of the robot.
    seed : int
        Of lessons and scenes.
    count : int
        Demonstrations of each motion.
    """

    robot: str = "pr2"
    task: str = "tabletop"
    tool: str | None = None
    seed: int = 0
    count: int = 5

    @property
    def name(self) -> str:
        """Of its files."""
        return f"{Path(self.robot).name}_{Path(self.task).name}_{self.seed}_{self.count}"

    @property
    def lessons(self) -> list[Lesson]:
        """Of every motion, with the arm that tasks are written for."""
        return self.lessons_of(self.seed)

    def lessons_of(self, seed: int) -> list[Lesson]:
        """The same with another seed."""
        labels = load_task(self.task).labels
        return [Lesson(self.robot, self.task, label, seed, self.count, tool=self.tool) for label in labels]


def described(robot: str, task: str) -> str:
    """A digest of the package's version and of every file that describes a robot and a task."""
    content = sha256(__version__.encode())
    for folder in (robot_file(robot).parent, task_file(task).parent):
        for path in sorted(folder.iterdir()):
            if path.suffix in (".toml", ".urdf"):
                content.update(path.name.encode() + path.read_bytes())
    return content.hexdigest()


def give_lessons(
    lessons: Sequence[Lesson], folder: Path | None = None, jobs: int = 1, progress: Progress = silent
) -> Taught:
    """Demonstrations of every lesson: read where the folder has them, else taught, and kept there.

    Parameters
    ----------
    lessons : sequence of Lesson
    folder : Path or None
        Made where missing; None keeps nothing.
    jobs : int
        Processes.
    progress : callable
        Takes the stage and the share that is done.

    Raises
    ------
    UnreachableError
        If a lesson cannot be given.
    StorageError
        If a file of the folder is damaged, or nothing can be written there.
    """
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    given = Parallel(n_jobs=jobs, return_as="generator")(delayed(_give)(lesson, folder) for lesson in lessons)
    taught = {}
    for number, (lesson, demonstrations) in enumerate(zip(lessons, given, strict=True), start=1):
        taught[lesson] = tuple(demonstrations)
        progress(f"taught {lesson.label}, seed {lesson.seed}", number / len(lessons))
    return taught


def _give(lesson: Lesson, folder: Path | None) -> list[Demonstration]:
    if folder is None:
        return lesson.teach()
    path = folder / lesson.file_name
    if not path.exists():
        save_demonstrations(path, lesson.teach())
    return load_demonstrations(path)
