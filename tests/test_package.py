"""The package as a whole: light to import, whole in a wheel, layered, documented, and short."""

from __future__ import annotations

import ast
import inspect
import json
import pkgutil
import re
import statistics
import subprocess
import sys
import zipfile
from importlib import import_module
from pathlib import Path
from types import GenericAlias
from typing import Any

import pytest

import pft_exec

ROOT = Path(__file__).parent.parent
HEAVY = (
    "daqp",
    "h5py",
    "imageio",
    "joblib",
    "matplotlib",
    "numba",
    "osqp",
    "pinocchio",
    "pybullet",
    "qpsolvers",
    "rich",
    "ruckig",
    "scipy",
    "typer",
)
MODULES = sorted(ROOT.glob("pft_exec/**/*.py"))
PACKAGES = ("pft_exec", *(f"pft_exec.{item.name}" for item in pkgutil.iter_modules(pft_exec.__path__) if item.ispkg))


@pytest.mark.parametrize("name", ["pft_exec", "pft_exec.geometry", "pft_exec.demonstration", "pft_exec.cli"])
def test_an_import_reaches_no_heavy_library(name: str) -> None:
    """The command line needs typer and rich, nothing else."""
    code = f"import json, sys, {name}; print(json.dumps(sorted(sys.modules)))"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    loaded = {module.split(".")[0] for module in json.loads(shown)}
    allowed = {"rich", "typer"} if name == "pft_exec.cli" else {"scipy"} if name != "pft_exec" else set()
    assert loaded & set(HEAVY) <= allowed


def test_every_public_name_is_importable_and_documented() -> None:
    for name in pft_exec.__all__:
        assert inspect.getdoc(getattr(pft_exec, name)), name


def test_public_names_are_sorted_and_the_table_of_homes_has_the_same() -> None:
    assert list(pft_exec._HOMES) == pft_exec.__all__ == sorted(pft_exec.__all__)
    assert set(pft_exec.__all__) <= set(dir(pft_exec))


def test_the_contract_of_names_is_kept() -> None:
    contract = """Arm Belief Demonstration ExecutionLog FlowTube MotionLibrary OnlineRecognizer Pose Push Scene World
    assist execute learn_library learn_motion load_demonstrations load_robot load_task save_demonstrations teach"""
    assert set(contract.split()) <= set(pft_exec.__all__)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'pft_exec' has no attribute 'Wrold'"):
        _ = pft_exec.Wrold  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", PACKAGES)
def test_each_folder_has_a_chapter_and_a_sorted_list_of_names_that_exist(name: str) -> None:
    module = import_module(name)
    assert module.__doc__
    names = module.__all__
    assert len(set(names)) == len(names)
    missing = [item for item in names if not hasattr(module, item)]
    assert not missing


@pytest.mark.parametrize("name", PACKAGES)
def test_each_public_name_and_method_has_a_docstring(name: str) -> None:
    module = import_module(name)
    undocumented = []
    for item in module.__all__:
        value = getattr(module, item)
        is_class = inspect.isclass(value) and not isinstance(value, GenericAlias)
        if is_class or inspect.isfunction(value):
            undocumented += [item] if not inspect.getdoc(value) else []
        if is_class:
            undocumented += [f"{item}.{method}" for method in _public_methods(value) if not _documented(value, method)]
    assert not undocumented


def _public_methods(value: type) -> list[str]:
    kinds = (staticmethod, classmethod, property)
    return [
        name
        for name, member in vars(value).items()
        if not name.startswith("_") and (inspect.isfunction(member) or isinstance(member, kinds))
    ]


def _documented(value: type, name: str) -> bool:
    return bool(inspect.getdoc(getattr(value, name)) or inspect.getdoc(vars(value)[name]))


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_each_module_says_what_it_is_and_stays_short(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert ast.get_docstring(ast.parse(text))
    assert len(text.splitlines()) <= 400


def test_modules_and_functions_are_short_on_the_whole() -> None:
    """Median module at most 150 lines; median function body at most 10, 90 % below 25."""
    lengths = [len(path.read_text(encoding="utf-8").splitlines()) for path in MODULES]
    assert statistics.median(lengths) <= 150
    bodies = sorted(length for path in MODULES for length in _body_lengths(path))
    assert statistics.median(bodies) <= 10
    assert bodies[int(0.9 * len(bodies))] < 25


def _body_lengths(path: Path) -> list[int]:
    """Lines of each function's body, its docstring left out."""
    lengths = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            body = node.body[1:] if ast.get_docstring(node) else node.body
            if body:
                lengths.append((body[-1].end_lineno or body[-1].lineno) - body[0].lineno + 1)
    return lengths


def test_no_module_has_a_name_that_says_nothing() -> None:
    empty = {"base", "common", "core", "helper", "helpers", "manager", "misc", "utils"}
    assert not [path for path in MODULES if empty & set(path.relative_to(ROOT).with_suffix("").parts)]


def test_import_layers_hold() -> None:
    command = [str(Path(sys.executable).with_name("lint-imports")), "--no-cache"]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout


def test_the_version_is_the_same_everywhere() -> None:
    pattern = re.escape(pft_exec.__version__)
    for name, line in (
        ("pyproject.toml", rf'^version = "{pattern}"$'),
        ("CITATION.cff", rf"^version: {pattern}$"),
    ):
        assert re.search(line, (ROOT / name).read_text(encoding="utf-8"), re.MULTILINE), name


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run(command, check=True, capture_output=True)
    (built,) = folder.glob("*.whl")
    return built


def shipped(folder: str) -> set[str]:
    """Files of robots/ or tasks/ that belong to the project."""
    files = (path for path in (ROOT / folder).rglob("*") if path.is_file() and "__pycache__" not in path.parts)
    return {str(path.relative_to(ROOT)) for path in files}


@pytest.mark.slow
def test_the_wheel_carries_every_module_robot_and_task(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    for folder in ("robots", "tasks"):
        files = shipped(folder)
        assert files
        assert {f"pft_exec/_assets/{name}" for name in files} <= names
    assert {str(path.relative_to(ROOT)) for path in MODULES} <= names
    assert "pft_exec/py.typed" in names
    assert not [name for name in names if name.startswith(("tests/", "robots/", "tasks/", "scripts/"))]


@pytest.mark.slow
def test_an_installed_wheel_finds_its_robots_and_tasks(wheel: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path)
    code = (
        "import json, sys; sys.path.insert(0, sys.argv[1]); from pft_exec import assets, load_task;"
        "print(json.dumps([assets.__file__, assets.robot_names(), assets.task_names(), load_task('tabletop').labels]))"
    )
    command = [sys.executable, "-c", code, str(tmp_path)]
    shown: Any = json.loads(subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout)
    assert Path(shown[0]).is_relative_to(tmp_path)
    assert "pr2" in shown[1]
    assert "tabletop" in shown[2]
    assert "reach" in shown[3]


def test_every_citation_resolves_in_the_readme() -> None:
    listed = set(re.findall(r"^- \[(\w+\d{4}\w?)\]", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE))
    cited = {key for path in MODULES for key in re.findall(r"\[([A-Z][A-Za-z]+\d{4}[a-z]?)\]_", path.read_text())}
    assert "Dong2012" in cited
    assert cited <= listed


def test_the_readme_names_every_command() -> None:
    from pft_exec.cli import app

    text = (ROOT / "README.md").read_text(encoding="utf-8")
    commands = {command.callback.__name__ for command in app.registered_commands if command.callback}
    assert commands == set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE))


@pytest.mark.slow
def test_the_example_of_the_readme_runs(capsys: pytest.CaptureFixture[str]) -> None:
    """As it stands: two motions taught, one executed, one taken over from the hand."""
    (example,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert len([line for line in example.splitlines() if line.strip()]) <= 15
    exec(compile(example, "README.md", "exec"), {})  # noqa: S102 - our own text
    *_, executed, assisted = capsys.readouterr().out.splitlines()
    assert executed.startswith("True")
    assert assisted.startswith("go_home Event(")
