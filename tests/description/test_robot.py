"""Robot descriptions: what ships loads from name and path, and a mended copy says exactly what is wrong with it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from pft_exec.assets import robot_file, robot_names
from pft_exec.description import RobotDescription, load_robot_description
from pft_exec.exceptions import DescriptionError, UnknownNameError, UnknownRobotError


@pytest.fixture
def pr2(tmp_path: Path) -> Path:
    """A user's own copy of the PR2's folder."""
    folder = tmp_path / "mine"
    shutil.copytree(robot_file("pr2").parent, folder)
    return folder


def changed(folder: Path, old: str, new: str, file: str = "robot.toml") -> Path:
    text = (folder / file).read_text(encoding="utf-8")
    assert old in text
    (folder / file).write_text(text.replace(old, new), encoding="utf-8")
    return folder


def refusal(folder: Path) -> str:
    with pytest.raises(DescriptionError) as caught:
        load_robot_description(folder)
    return str(caught.value)


def test_the_shipped_robots_are_the_two_of_the_paper() -> None:
    assert robot_names() == ("pr2", "wam")


def test_a_robot_loads_from_its_folder_and_from_its_file(pr2: Path) -> None:
    by_folder, by_file = load_robot_description(pr2), load_robot_description(pr2 / "robot.toml")
    assert by_folder == by_file
    assert by_folder.folder == pr2
    assert by_folder.urdf == pr2 / "pr2.urdf"


def test_arms_stand_in_the_order_of_the_file() -> None:
    assert tuple(load_robot_description("pr2").arms) == ("left", "right")


def test_the_left_arm_takes_what_it_does_not_state_from_the_right_one_mirrored() -> None:
    robot = load_robot_description("pr2")
    left, right = robot.arms["left"], robot.arms["right"]
    assert (left.mirror_arm, right.mirror_arm) == ("right", "left")
    assert left.mirror_signs == right.mirror_signs == (-1, 1, -1, 1, -1, 1, -1)
    assert left.configurations["work"] == (1.12, 0.70, 1.53, -1.37, 0.62, -0.93, -1.45)
    assert left.acceleration == right.acceleration
    assert left.counterbalance is not None
    assert left.counterbalance.joints == ("l_shoulder_lift_joint", "l_upper_arm_roll_joint", "l_elbow_flex_joint")
    assert left.counterbalance.frozen["l_wrist_flex_joint"] == -1.0
    assert left.gripper is not None
    assert left.gripper.open_width == 0.086


def test_an_arm_may_state_a_configuration_of_its_own(pr2: Path) -> None:
    joints = (
        "shoulder_pan",
        "shoulder_lift",
        "upper_arm_roll",
        "elbow_flex",
        "forearm_roll",
        "wrist_flex",
        "wrist_roll",
    )
    own = "".join(f"l_{joint}_joint = {-0.5 if 'flex' in joint else 0.1}\n" for joint in joints)
    arms = load_robot_description(
        changed(pr2, "[arms.left.gripper]", f"[arms.left.configurations.work]\n{own}[arms.left.gripper]")
    ).arms
    assert arms["left"].configurations["work"] == (0.1, 0.1, 0.1, -0.5, 0.1, -0.5, 0.1)
    assert arms["left"].configurations["home"][0] == -arms["right"].configurations["home"][0]


def test_a_tool_changes_urdf_tool_frame_and_gripper() -> None:
    bare, armed = load_robot_description("wam"), load_robot_description("wam", tool="gripper")
    assert bare.tools == armed.tools == ("gripper",)
    assert (bare.tool, armed.tool) == (None, "gripper")
    assert bare.arms["arm"].gripper is None
    assert armed.arms["arm"].gripper is not None
    assert armed.urdf.name == "wam_gripper.urdf"
    assert armed.arms["arm"].tool_frame != bare.arms["arm"].tool_frame


def test_an_unknown_robot_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(UnknownRobotError, match=r"no robot is named 'pr3'\. Did you mean 'pr2'\?"):
        load_robot_description("pr3")


def test_an_unknown_tool_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(UnknownNameError, match=r"no tool is named 'griper'\. Did you mean 'gripper'\?"):
        load_robot_description("wam", tool="griper")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[arms.right.jerk]", "[arms.right.jerq]", ("arms.right.jerq: unknown key", "Did you mean 'jerk'?")),
        ('base_frame = "base_footprint"', "", ("base_frame: missing key",)),
        (
            'base_frame = "base_footprint"',
            'base_frame = "base_link"',
            ("base_frame: ", "'base_footprint'", "'base_link'"),
        ),
        (
            'tool_frame = "r_gripper_tool_frame"',
            'tool_frame = "r_gripper_tol_frame"',
            ("arms.right.tool_frame", "Did you mean"),
        ),
        (
            '    "r_wrist_roll_joint",\n',
            "",
            ("arms.right.acceleration.values: expected 6 numbers, one a joint, got 7",),
        ),
        (
            "values = [6, 6, 8, 8, 10, 10, 10]",
            "values = [6, 6]",
            ("arms.right.acceleration.values: expected 7 numbers", "got 2"),
        ),
        ("values = [6, 6, 8", "values = [-6, 6, 8", ("arms.right.acceleration.values", "at least 0", "-6")),
        ('grade = "B"', 'grade = "D"', ("arms.right.counterbalance.grade: 'D' is not a choice", "'A', 'B', 'C'")),
        (
            "r_wrist_flex_joint = -0.93",
            "r_wrist_flexx_joint = -0.93",
            ("arms.right.configurations.work", "r_wrist_flexx_joint", "Did you mean 'r_wrist_flex_joint'?"),
        ),
        ("r_wrist_flex_joint = -0.93\n", "", ("arms.right.configurations.work.r_wrist_flex_joint: missing key",)),
        (
            "r_wrist_flex_joint = -0.93",
            "r_wrist_flex_joint = -2.1",
            ("configurations.work", "wrist_flex_joint", "soft limits, [-2, -0.1]", "-2.1"),
        ),
        (
            "r_forearm_roll_joint = 0.0\nr_wrist_flex_joint = -1.0",
            "r_rol = 0.0\nr_wrist_flex_joint = -1.0",
            ("arms.right.counterbalance.frozen", "'r_rol'"),
        ),
        ('mirrors = "right"', 'mirrors = "rihgt"', ("arms.left.mirrors", "Did you mean 'right'?")),
        (
            "mirror_signs = [-1, 1, -1, 1, -1, 1, -1]",
            "mirror_signs = [-1, 1]",
            ("arms.left.mirror_signs: expected 7 signs", "[-1.0, 1.0]"),
        ),
        ("mirror_signs = [-1, 1,", "mirror_signs = [-2, 1,", ("arms.left.mirror_signs", "each 1 or -1")),
        ('mirrors = "right"\n', "", ("arms.left.mirror_signs", "`mirrors`")),
        ('    "l_wrist_roll_joint",\n', "", ("arms.left.joints", "7 joints; got 6")),
        ('palm_link = "r_gripper_palm_link"', 'palm_link = "r_palm"', ("arms.right.gripper.palm_link", "'r_palm'")),
        (
            '["r_gripper_l_finger_joint", ',
            '["r_griper_l_finger_joint", ',
            ("arms.right.gripper.joints", "Did you mean 'r_gripper_l_finger_joint'?"),
        ),
        ("open_width = 0.086", "open_width = 0.0", ("arms.right.gripper.open_width", "got 0.0")),
        ("closed_width = 0.0\n", "", ("arms.right.gripper: missing key", "`closed_width`")),
        ('urdf = "pr2.urdf"', 'urdf = "pr3.urdf"', ("pr3.urdf: cannot be read",)),
    ],
)
def test_a_mistake_in_the_toml_is_named_with_file_key_and_choice(
    pr2: Path, old: str, new: str, words: tuple[str, ...]
) -> None:
    message = refusal(changed(pr2, old, new))
    assert "robot.toml" in message or "cannot be read" in message
    for word in words:
        assert word in message


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            'name="r_wrist_roll_joint" type="revolute"',
            'name="r_wrist_roll_joint" type="continuous"',
            ("'r_wrist_roll_joint' is 'continuous'", "+-1000 rad"),
        ),
        (
            'name="r_wrist_roll_joint" type="revolute"',
            'name="r_wrist_turn_joint" type="revolute"',
            ("no joint 'r_wrist_roll_joint'", "Did you mean"),
        ),
        ('soft_lower_limit="-2.1213"', 'soft_lower_limit="-9"', ("elbow_flex_joint", "soft ones inside the hard")),
        ('effort="30" velocity="3.3"', 'effort="0" velocity="3.3"', ("elbow_flex_joint", "above 0")),
        ('name="r_wrist_roll_link"', 'name="r_wrist_lost_link"', ("one root link",)),
        ("<robot", "<robo", ("is not a URDF",)),
        ('<child link="r_wrist_flex_link"/>', "", ("is not a URDF", "has no child")),
    ],
)
def test_a_mistake_in_the_urdf_is_named(pr2: Path, old: str, new: str, words: tuple[str, ...]) -> None:
    message = refusal(changed(pr2, old, new, "pr2.urdf"))
    for word in words:
        assert word in message


def test_joints_out_of_chain_order_are_refused(pr2: Path) -> None:
    pair = '    "r_shoulder_pan_joint",\n    "r_shoulder_lift_joint",\n'
    swapped = '    "r_shoulder_lift_joint",\n    "r_shoulder_pan_joint",\n'
    message = refusal(changed(pr2, pair, swapped))
    assert "arms.right.joints: expected the joints from base to 'r_gripper_tool_frame' in order" in message


def test_a_robot_without_arms_is_refused(tmp_path: Path) -> None:
    (tmp_path / "robot.toml").write_text(
        'name = "a"\ntitle = "A"\nurdf = "a.urdf"\nbase_frame = "b"\narms = {}\n'
        'provenance = { upstream = "", commit = "", license = "" }',
        encoding="utf-8",
    )
    assert "arms: expected at least one arm" in refusal(tmp_path)


def test_an_arm_without_limits_is_refused(pr2: Path) -> None:
    text = (pr2 / "robot.toml").read_text(encoding="utf-8")
    start, end = text.index("[arms.right.jerk]"), text.index("[arms.right.coulomb]")
    message = refusal(changed(pr2, text[start:end], ""))
    assert "arms.right.jerk: missing key; an arm that mirrors no other must state it" in message


def test_an_arm_without_joints_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "wam"
    shutil.copytree(robot_file("wam").parent, folder)
    text = (folder / "robot.toml").read_text(encoding="utf-8")
    start, end = text.index("joints = ["), text.index("[arms.arm.acceleration]")
    changed(folder, text[start:end], "joints = []\n")
    assert "arms.arm.joints: expected at least one joint" in refusal(folder)


def test_an_arm_without_springs_and_gripper_has_a_mirror_image_without_them(pr2: Path) -> None:
    text = (pr2 / "robot.toml").read_text(encoding="utf-8")
    for first, last in (
        ("[arms.left.gripper]", "[arms.right]"),
        ("[arms.right.counterbalance]", "[arms.right.configurations.work]"),
    ):
        changed(pr2, text[text.index(first) : text.index(last)], "")
    left = load_robot_description(pr2).arms["left"]
    assert left.counterbalance is None
    assert left.gripper is None


def test_two_arms_cannot_mirror_the_same_one(pr2: Path) -> None:
    text = (pr2 / "robot.toml").read_text(encoding="utf-8")
    start, end = text.index("[arms.left]"), text.index("[arms.left.gripper]")
    message = refusal(
        changed(pr2, "[arms.left.gripper]", text[start:end].replace("arms.left", "arms.third") + "[arms.left.gripper]")
    )
    assert "arms.third.mirrors: no arm to mirror is named 'right'" in message


def test_a_tool_for_an_arm_that_is_not_there_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "wam"
    shutil.copytree(robot_file("wam").parent, folder)
    changed(folder, "tools.gripper.arms.arm", "tools.gripper.arms.amr")
    with pytest.raises(
        DescriptionError, match=r"tools\.gripper\.arms\.amr: no arm is named 'amr'\. Did you mean 'arm'\?"
    ):
        load_robot_description(folder, tool="gripper")


def test_a_description_cannot_be_written_to() -> None:
    robot: RobotDescription = load_robot_description("pr2")
    with pytest.raises(TypeError):
        robot.arms["third"] = robot.arms["left"]  # type: ignore[index]
    with pytest.raises(AttributeError):
        robot.name = "other"  # type: ignore[misc]
