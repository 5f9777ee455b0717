"""`check robot` finds what is broken in a user's robot and says what to mend; one broken robot per finding."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from shutil import copytree
from typing import Any

import numpy as np
import pytest

from pft_exec.description import load_robot_description
from pft_exec.exceptions import UnknownNameError
from pft_exec.geometry import Pose
from pft_exec.report import check
from pft_exec.report.check import check_description
from pft_exec.simulation.reading import ArmReading, read_arm


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """A copy of the WAM that a test may break."""
    source = load_robot_description("wam").urdf.parent
    return Path(copytree(source, tmp_path / "mine"))


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def findings(robot: Path) -> dict[str, str]:
    """What failed, and what is said of it."""
    return {row["check"]: row["detail"] for row in check_description("robot", str(robot)) if not row["ok"]}


def test_an_intact_robot_passes_every_check_in_both_engines(robot: Path) -> None:
    rows = check_description("robot", str(robot))
    assert all(row["ok"] for row in rows)
    checks = [row["check"] for row in rows]
    for what in ("in the simulator", "limits", "tool pose", "gravity held without friction", "one simulated second"):
        assert any(what in name for name in checks)


def test_a_joint_that_the_urdf_has_not_is_named(robot: Path) -> None:
    edit(robot / "wam.urdf", '<joint name="elbow_pitch_joint"', '<joint name="elbow_joint"')
    assert any("elbow_pitch_joint" in detail for detail in findings(robot).values())


def test_a_tool_frame_that_the_urdf_has_not_is_named(robot: Path) -> None:
    edit(robot / "robot.toml", 'tool_frame = "', 'tool_frame = "no_')
    assert any("no_" in detail for detail in findings(robot).values())


@pytest.mark.parametrize(
    ("pattern", "value", "words"),
    [(r'<mass value="[^"]*"', '<mass value="-1"', "mass is -1"), (r'ixx="[^"]*"', 'ixx="-1"', "moment")],
)
def test_a_link_that_no_body_can_be_is_named(pattern: str, value: str, words: str, robot: Path) -> None:
    """Also where it does not move, so that no engine would notice."""
    text = (robot / "wam.urdf").read_text(encoding="utf-8")
    (robot / "wam.urdf").write_text(re.sub(pattern, value, text, count=1), encoding="utf-8")
    assert words in findings(robot)["inertials"]


def test_a_link_without_inertia_weighs_a_kilogram_in_the_simulator_alone(robot: Path) -> None:
    """The last link's ``<inertial>`` is taken out: the model knows no mass, the engine makes one up."""
    text = (robot / "wam.urdf").read_text(encoding="utf-8")
    begin = text.index('<link name="wrist_palm_link">')
    first, last = text.index("<inertial>", begin), text.index("</inertial>", begin) + len("</inertial>")
    (robot / "wam.urdf").write_text(text[:first] + text[last:], encoding="utf-8")
    found = findings(robot)
    assert "give every link an <inertial>" in found["arm arm, gravity held without friction"]


def test_motors_too_weak_for_the_arm_are_named(robot: Path) -> None:
    text = (robot / "wam.urdf").read_text(encoding="utf-8")
    begin = text.index('<joint name="shoulder_pitch_joint"')
    place = text.index('effort="', begin) + len('effort="')
    (robot / "wam.urdf").write_text(text[:place] + "1" + text[text.index('"', place) :], encoding="utf-8")
    found = findings(robot)
    assert "shoulder_pitch_joint holds with" in found["arm arm, 'work'"]


def test_a_configuration_beyond_the_limits_is_named(robot: Path) -> None:
    edit(robot / "robot.toml", "elbow_pitch_joint = 1.849", "elbow_pitch_joint = 9.0")
    assert any("elbow_pitch_joint" in detail for detail in findings(robot).values())


Change = Callable[[ArmReading], dict[str, Any]]


@pytest.mark.parametrize(
    ("change", "name", "detail"),
    [
        (lambda _: {"missing": ("wrist_yaw_joint",)}, "arm arm in the simulator", "'wrist_yaw_joint' does not move"),
        (lambda seen: {"upper": seen.upper - 1.0}, "arm arm, limits", "upper limit is 0.95 beyond the simulator's"),
        (lambda seen: {"torque": seen.torque - 1.0}, "arm arm, limits", "torque limit is 1 beyond"),
        (
            lambda seen: {"tool": Pose(seen.tool.position + np.array([0.0, 0.0, 0.01]))},
            "arm arm, tool pose",
            "1.0e+01 mm",
        ),
        (lambda seen: {"acceleration": seen.acceleration + 1.0}, "arm arm, gravity held without friction", "lacks"),
    ],
)
def test_engines_that_disagree_are_reported(
    monkeypatch: pytest.MonkeyPatch, change: Change, name: str, detail: str
) -> None:
    def other(*arguments: Any) -> ArmReading:
        seen = read_arm(*arguments)
        return replace(seen, **change(seen))

    monkeypatch.setattr(check, "read_arm", other)
    found = {row["check"]: row["detail"] for row in check_description("robot", "wam") if not row["ok"]}
    assert set(found) == {name}
    assert detail in found[name]


def test_an_arm_that_does_not_stay_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    from pft_exec.model import Arm

    gravity = Arm.gravity
    monkeypatch.setattr(Arm, "gravity", lambda arm, q: np.asarray(gravity(arm, q)) * 0.8)
    found = {row["check"]: row["detail"] for row in check_description("robot", "wam") if not row["ok"]}
    assert "drifts by" in found["gravity compensation for one simulated second"]
    assert "gravity held without friction" in " ".join(found)


def test_there_is_no_other_kind_of_description() -> None:
    with pytest.raises(UnknownNameError, match="kind of description"):
        check_description("robt", "wam")
