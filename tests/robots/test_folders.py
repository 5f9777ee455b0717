"""Every robot folder is whole: its files, a README in order, a picture, a sound URDF; and the robot stands still."""

from __future__ import annotations

import struct
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pybullet
import pytest

from pft_exec.assets import robot_file, robot_names
from pft_exec.description import load_robot_description
from pft_exec.description.urdf import UrdfJoint, read_urdf
from pft_exec.model import RobotModel, load_robot

HEADINGS = ("## Provenance", "## Derivation", "## Not measured", "## Licence")


@pytest.fixture(params=robot_names())
def folder(request: pytest.FixtureRequest) -> Path:
    return robot_file(request.param).parent


@pytest.fixture(params=[(name, tool) for name in robot_names() for tool in (None, *load_robot_description(name).tools)])
def robot(request: pytest.FixtureRequest) -> RobotModel:
    return load_robot(*request.param)


def tree(urdf: Path) -> ElementTree.Element:
    return ElementTree.parse(urdf).getroot()  # noqa: S314  a file of this repository


def links(robot: RobotModel) -> list[ElementTree.Element]:
    return tree(robot.description.urdf).findall("link")


def test_a_folder_holds_the_same_files(folder: Path) -> None:
    expected = {"README.md", "LICENSE", "robot.toml", "preview.png", f"{folder.name}.urdf"}
    extra = {path.name for path in folder.iterdir()} - expected
    assert expected <= {path.name for path in folder.iterdir()}
    assert all(name.endswith(".urdf") for name in extra)


def test_a_robot_is_named_as_its_folder(folder: Path) -> None:
    assert load_robot_description(folder.name).name == folder.name


def test_a_readme_shows_the_robot_and_says_where_it_is_from(folder: Path) -> None:
    text = (folder / "README.md").read_text(encoding="utf-8")
    places = [text.index(heading) for heading in HEADINGS]
    assert places == sorted(places)
    assert "](preview.png)" in text
    assert "1. " in text[places[1] : places[2]]
    for file in folder.glob("*.urdf"):
        assert f"`{file.name}`" in text


def test_a_readme_names_the_upstream_and_its_commit(folder: Path) -> None:
    provenance = load_robot_description(folder.name).provenance
    assert len(provenance.commit) == 40
    assert provenance.commit in (folder / "README.md").read_text(encoding="utf-8")


def test_a_preview_is_a_picture(folder: Path) -> None:
    data = (folder / "preview.png").read_bytes()
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    width, height = struct.unpack(">II", data[16:24])
    assert width >= 480
    assert height >= 360
    assert len(data) < 200_000


def test_every_number_of_a_simulation_has_a_source(robot: RobotModel) -> None:
    for arm in robot.description.arms.values():
        for graded in (arm.acceleration, arm.jerk, arm.coulomb, arm.viscous):
            assert graded.source.strip()


def test_every_link_has_an_inertial_that_is_not_rotated(robot: RobotModel) -> None:
    for link in links(robot):
        inertial = link.find("inertial")
        assert inertial is not None, link.attrib["name"]
        origin = inertial.find("origin")
        assert origin is not None
        assert origin.attrib["rpy"] == "0 0 0"


def test_every_inertia_is_that_of_a_body_that_could_exist(robot: RobotModel) -> None:
    """Principal moments are positive and none exceeds the sum of the others; fixed torsos and heads do not matter."""
    moving = {joint.child for arm in robot.arms for joint in _chain(robot, arm)}
    for link in links(robot):
        mass, moments = _inertial(link)
        if mass == 0.0:
            assert (moments == 0.0).all()
        elif link.attrib["name"] in moving:
            assert moments[0] > 0.0, link.attrib["name"]
            assert moments[2] <= moments[0] + moments[1] + 1e-9, link.attrib["name"]


def _chain(robot: RobotModel, arm: str) -> list[UrdfJoint]:
    chain = read_urdf(robot.description.urdf).chain(robot.arm(arm).tool_frame)
    return [joint for joint in chain if joint.kind != "fixed"]


def _inertial(link: ElementTree.Element) -> tuple[float, np.ndarray]:
    mass = float(link.find("inertial/mass").attrib["value"])
    i = {key: float(value) for key, value in link.find("inertial/inertia").attrib.items()}
    matrix = [[i["ixx"], i["ixy"], i["ixz"]], [i["ixy"], i["iyy"], i["iyz"]], [i["ixz"], i["iyz"], i["izz"]]]
    return mass, np.linalg.eigvalsh(matrix)


def test_shapes_are_primitive(robot: RobotModel) -> None:
    shapes = {child.tag for link in links(robot) for child in link.iterfind(".//geometry/*")}
    assert shapes <= {"box", "cylinder", "sphere"}


def test_no_joint_is_damped_by_the_urdf(robot: RobotModel) -> None:
    for dynamics in tree(robot.description.urdf).iterfind("joint/dynamics"):
        assert dynamics.attrib == {"damping": "0", "friction": "0"}


def test_grippers_open_as_wide_as_their_fingers_travel(robot: RobotModel) -> None:
    joints = {joint.attrib["name"]: joint for joint in tree(robot.description.urdf).findall("joint")}
    for arm in robot.description.arms.values():
        if arm.gripper is not None:
            travel = sum(float(joints[name].find("limit").attrib["upper"]) for name in arm.gripper.joints)
            assert 0.0 <= arm.gripper.closed_width < arm.gripper.open_width <= travel


def test_an_attachment_leaves_the_arm_as_it_is() -> None:
    """Every link and joint of the bare WAM stands in the other URDF, word for word."""
    bare, armed = (tree(robot_file("wam").parent / name) for name in ("wam.urdf", "wam_gripper.urdf"))
    for kind in ("link", "joint", "material"):
        present = {element.attrib["name"]: ElementTree.tostring(element).strip() for element in armed.findall(kind)}
        for element in bare.findall(kind):
            assert present[element.attrib["name"]] == ElementTree.tostring(element).strip()


def test_a_robot_held_against_gravity_stands_still_for_a_second(robot: RobotModel) -> None:
    """Exact gravity torque at 1 kHz, no friction, every arm in its work configuration.

    A bare arm drifts by rounding errors alone; fingers held by the simulator's own motors give way a little.
    """
    client = pybullet.connect(pybullet.DIRECT)
    try:
        has_gripper = any(arm.gripper is not None for arm in robot.description.arms.values())
        assert _drift(robot, client) < (1e-3 if has_gripper else 1e-9)
    finally:
        pybullet.disconnect(client)


def _drift(robot: RobotModel, client: int) -> float:
    urdf, flags = str(robot.description.urdf), pybullet.URDF_USE_INERTIA_FROM_FILE
    body = pybullet.loadURDF(urdf, useFixedBase=True, flags=flags, physicsClientId=client)
    pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
    pybullet.setTimeStep(1e-3, physicsClientId=client)
    pybullet.changeDynamics(body, -1, linearDamping=0, angularDamping=0, physicsClientId=client)
    every = range(pybullet.getNumJoints(body, physicsClientId=client))
    joints = {pybullet.getJointInfo(body, i, physicsClientId=client)[1].decode(): i for i in every}
    held = {name: list(map(joints.get, robot.arm(name).joint_names)) for name in robot.arms}
    for name, indices in held.items():
        for index, value in zip(indices, robot.arm(name).configuration("work"), strict=True):
            pybullet.resetJointState(body, index, value, physicsClientId=client)
            pybullet.setJointMotorControl2(body, index, pybullet.VELOCITY_CONTROL, force=0, physicsClientId=client)
    for _ in range(1000):
        for name, indices in held.items():
            states = pybullet.getJointStates(body, indices, physicsClientId=client)
            torque = robot.arm(name).gravity([state[0] for state in states])
            pybullet.setJointMotorControlArray(
                body, indices, pybullet.TORQUE_CONTROL, forces=torque, physicsClientId=client
            )
        pybullet.stepSimulation(physicsClientId=client)
    return max(
        abs(state[0] - value)
        for name, indices in held.items()
        for state, value in zip(
            pybullet.getJointStates(body, indices, physicsClientId=client),
            robot.arm(name).configuration("work"),
            strict=True,
        )
    )
