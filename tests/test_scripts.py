"""The scripts: set up once, quick when nothing changed, from any folder; locks of names and versions only."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parent.parent
LOCKS = ("requirements.lock", "requirements-dev.lock")
LINE = re.compile(r'^[a-z0-9][a-z0-9.-]*==[0-9][0-9a-z.]*( ; python_version (==|>=) "3\.\d+")?$')


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A copy of the scripts in a project whose .venv holds a stand-in that writes down how it is called."""
    shutil.copytree(ROOT / "scripts", tmp_path / "scripts")
    for name in (*LOCKS, "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path / name)
    (tmp_path / "pft_exec").mkdir()
    for name in ("python", "pft-exec"):
        stand_in = tmp_path / ".venv" / "bin" / name
        stand_in.parent.mkdir(parents=True, exist_ok=True)
        stand_in.write_text(f'#!/bin/sh\necho "{name} $*" >> "{tmp_path}/calls"\n')
        stand_in.chmod(0o755)
    return tmp_path


def calls(project: Path, script: str, *arguments: str, cwd: Path | None = None) -> list[str]:
    """What the script called, the question whether the interpreter works left out."""
    (project / "calls").unlink(missing_ok=True)
    command = [str(project / "scripts" / script), *arguments]
    subprocess.run(command, check=True, capture_output=True, cwd=cwd or project)
    return [line for line in (project / "calls").read_text().splitlines() if line.strip() != "python -c"]


@pytest.mark.parametrize("name", ["scripts/setup", "scripts/demo", "scripts/test", ".ci/run"])
def test_each_shell_script_is_executable_strict_and_parses(name: str) -> None:
    path = ROOT / name
    assert os.access(path, os.X_OK)
    assert "set -euo pipefail" in path.read_text()
    subprocess.run(["bash", "-n", str(path)], check=True)


def test_setting_up_installs_the_lock_then_the_project_without_dependencies(project: Path) -> None:
    installs = [line for line in calls(project, "setup") if " install " in line and "--dry-run" not in line]
    assert len(installs) == 2
    assert installs[0].endswith("--requirement requirements.lock")
    assert installs[1].endswith("--no-deps --editable .")


def test_compiled_kernels_are_forgotten_once_after_any_change(project: Path) -> None:
    source, kernel = project / "pft_exec" / "limits.py", project / "pft_exec" / "kernel.nbi"
    source.write_text("")
    calls(project, "setup")
    kernel.write_text("")
    calls(project, "setup")
    assert kernel.exists()
    later = (project / ".venv" / "compiled-since").stat().st_mtime + 1.0
    os.utime(source, (later, later))
    calls(project, "setup")
    assert not kernel.exists()


def test_a_second_time_nothing_is_installed(project: Path) -> None:
    calls(project, "setup", "dev")
    assert calls(project, "setup", "dev") == []
    assert calls(project, "setup") == []


def test_a_changed_lock_is_installed_again_and_only_that(project: Path) -> None:
    calls(project, "setup", "dev")
    with (project / "requirements-dev.lock").open("a") as lock:
        lock.write("six==1.17.0\n")
    assert calls(project, "setup") == []
    (install,) = calls(project, "setup", "dev")
    assert install.endswith("--requirement requirements-dev.lock")


def test_an_interrupted_installation_is_repeated(project: Path) -> None:
    python = project / ".venv" / "bin" / "python"
    works = python.read_text()
    python.write_text('#!/bin/sh\ncase "$*" in *--requirement*) exit 1 ;; esac\n')
    with pytest.raises(subprocess.CalledProcessError):
        calls(project, "setup")
    python.write_text(works)
    assert any(line.endswith("--requirement requirements.lock") for line in calls(project, "setup"))


def test_the_demo_hands_its_arguments_on_from_any_folder(
    project: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    assert (
        calls(project, "demo", "--seed", "3", "--out", "a b", cwd=elsewhere)[-1] == "pft-exec demo --seed 3 --out a b"
    )


def test_tests_run_in_parallel_unless_told_otherwise(project: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    assert calls(project, "test", cwd=elsewhere)[-1] == "python -m pytest -n auto --dist worksteal"
    assert calls(project, "test", "tests/test_cli.py", "-k", "help")[-1] == "python -m pytest tests/test_cli.py -k help"


@pytest.mark.parametrize("name", LOCKS)
def test_locks_hold_names_and_exact_versions_only(name: str) -> None:
    header, *lines = (ROOT / name).read_text().splitlines()
    assert header.startswith("#")
    assert [line for line in lines if not LINE.match(line)] == []


def test_the_locks_cover_every_dependency_and_share_none() -> None:
    runtime, development = (
        {line.split("==")[0] for line in (ROOT / name).read_text().splitlines()[1:]} for name in LOCKS
    )
    assert not runtime & development
    text = (ROOT / "pyproject.toml").read_text()
    needed = re.findall(r'^    "([A-Za-z0-9-]+)[>=]', text.split("[project.optional-dependencies]")[0], re.MULTILINE)
    assert len(needed) > 10
    assert {name.lower() for name in needed} <= runtime
    extras = re.findall(
        r'"([A-Za-z0-9-]+)>=', text.split("[project.optional-dependencies]")[1].split("[project.scripts]")[0]
    )
    assert set(extras) <= development | runtime


def locking() -> ModuleType:
    loader = SourceFileLoader("locking", str(ROOT / "scripts" / "lock"))
    spec = spec_from_loader("locking", loader)
    assert spec is not None
    module = module_from_spec(spec)
    loader.exec_module(module)
    return module


def test_versions_that_differ_between_pythons_are_told_apart() -> None:
    resolved = {"3.11": {"a": "1.0", "b": "2.1", "d": "4"}, "3.10": {"a": "1.0", "b": "2.0", "c": "3"}}
    assert locking().lines(resolved) == [
        "a==1.0",
        'b==2.0 ; python_version == "3.10"',
        'b==2.1 ; python_version >= "3.11"',
        'c==3 ; python_version == "3.10"',
        'd==4 ; python_version >= "3.11"',
    ]


def test_a_skipped_test_fails_where_the_data_are_required(tmp_path: Path) -> None:
    """`.ci/run` asks for it wherever the recordings are there."""
    shutil.copy(ROOT / "tests" / "conftest.py", tmp_path)
    (tmp_path / "test_data.py").write_text("def test_it(recordings):\n    assert False\n")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)]
    environment = os.environ | {"PFT_EXEC_DATA": str(tmp_path)}
    for required, status, line in (("0", 0, "1 skipped"), ("1", 1, "1 error")):
        environment["PFT_EXEC_REQUIRE_DATA"] = required
        result = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert result.returncode == status
        assert line in result.stdout.splitlines()[-1]
    assert "PFT_EXEC_REQUIRE_DATA=1" in (ROOT / ".ci" / "run").read_text()
