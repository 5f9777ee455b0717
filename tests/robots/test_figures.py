"""The URDFs carry the published figures, number by number, where the collection of them lies beside the project."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from pft_exec.assets import robot_file
from pft_exec.model import load_robot

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

FACTS = Path(__file__).parents[3] / "shared" / "robots" / "facts.toml"
ROTOR = {"elbow_flex_link": (0.005, 0.01, 0.005), "wrist_flex_link": (0.005, 0.01, 0.005)}  # added, kg m^2
WAM_ROTOR = (0.0, 0.0, 0.0, 0.0, 0.0035, 0.0035, 0.0012)  # added, kg m^2


@pytest.fixture(scope="module")
def facts() -> dict[str, Any]:
    if not FACTS.is_file():
        pytest.skip(f"no collection of published figures at {FACTS}")
    return tomllib.loads(FACTS.read_text(encoding="utf-8"))


@cache
def urdf(name: str) -> ElementTree.Element:
    return ElementTree.parse(robot_file(name).parent / f"{name}.urdf").getroot()  # noqa: S314  a file of this repository


def element(name: str, kind: str, called: str) -> ElementTree.Element:
    found = urdf(name).find(f"{kind}[@name='{called}']")
    assert found is not None, called
    return found


def numbers(parent: ElementTree.Element, path: str, attribute: str) -> list[float]:
    return [float(word) for word in parent.find(path).attrib[attribute].split()]


def inertia(link: ElementTree.Element) -> list[float]:
    return [numbers(link, "inertial/inertia", key)[0] for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")]


def check_inertial(link: ElementTree.Element, fact: dict[str, Any], added: tuple[float, float, float]) -> None:
    expected = np.array(fact["inertia"]) + np.array([added[0], 0, 0, added[1], 0, added[2]])
    np.testing.assert_allclose(numbers(link, "inertial/mass", "value"), [fact["mass"]], rtol=0, atol=1e-9)
    np.testing.assert_allclose(numbers(link, "inertial/origin", "xyz"), fact["com"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(inertia(link), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("side", ["left", "right"])
def test_pr2_arm_inertials_are_the_published_ones(facts: dict[str, Any], side: str) -> None:
    for fact in facts["pr2"][side]["link"]:
        check_inertial(element("pr2", "link", fact["name"]), fact, ROTOR.get(fact["name"][2:], (0.0, 0.0, 0.0)))


def test_pr2_torso_head_and_palm_inertials_are_the_published_ones(facts: dict[str, Any]) -> None:
    pr2 = facts["pr2"]
    palm = [fact for fact in pr2["gripper"]["link"] if fact["name"] == "r_gripper_palm_link"]
    for fact in [*pr2["torso_link"], *pr2["head_link"], *palm]:
        check_inertial(element("pr2", "link", fact["name"]), fact, (0.0, 0.0, 0.0))


@pytest.mark.parametrize("side", ["left", "right"])
def test_pr2_joints_are_the_published_ones(facts: dict[str, Any], side: str) -> None:
    for fact in facts["pr2"][side]["joint"]:
        joint = element("pr2", "joint", fact["name"])
        np.testing.assert_allclose(numbers(joint, "origin", "xyz"), fact["xyz"], rtol=0, atol=1e-9)
        np.testing.assert_allclose(numbers(joint, "origin", "rpy"), fact["rpy"], rtol=0, atol=1e-9)
        if fact["type"] != "fixed":
            expected = [fact.get("lower", -1000.0), fact.get("upper", 1000.0), fact["effort"], fact["velocity"]]
            found = [numbers(joint, "limit", key)[0] for key in ("lower", "upper", "effort", "velocity")]
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)
            assert numbers(joint, "axis", "xyz") == fact["axis"]


@pytest.mark.parametrize("side", ["left", "right"])
def test_pr2_soft_limits_are_the_published_ones(facts: dict[str, Any], side: str) -> None:
    movable = [fact for fact in facts["pr2"][side]["joint"] if fact["type"] != "fixed"]
    limits = load_robot("pr2").arm(side).limits
    expected = [
        [fact.get(f"soft_{end}_limit", sign * 1000.0) for fact in movable]
        for end, sign in (("lower", -1), ("upper", 1))
    ]
    np.testing.assert_allclose([limits.lower, limits.upper], expected, rtol=0, atol=1e-9)


def test_pr2_closed_gripper_weighs_what_its_parts_weigh(facts: dict[str, Any]) -> None:
    """Palm and fingers, closed, against the published lump, which has 0.021 kg of parts for another simulator in it."""
    lump = facts["pr2"]["gripper"]["lumped_palm_subtree_closed"]
    names = ("r_gripper_palm_link", "r_gripper_l_finger_link", "r_gripper_r_finger_link")
    origins = [
        np.zeros(3),
        *(np.array(numbers(element("pr2", "joint", f"r_gripper_{f}_finger_joint"), "origin", "xyz")) for f in "lr"),
    ]
    masses = [numbers(element("pr2", "link", name), "inertial/mass", "value")[0] for name in names]
    centers = [np.array(numbers(element("pr2", "link", name), "inertial/origin", "xyz")) for name in names]
    moment = sum(mass * (origin + center) for mass, origin, center in zip(masses, origins, centers, strict=True))
    assert sum(masses) == pytest.approx(lump["mass"] - 0.021, abs=1e-4)
    np.testing.assert_allclose(moment, lump["mass"] * np.array(lump["com"]), rtol=0, atol=0.021 * 0.17)


def test_wam_inertials_are_those_of_libbarrett(facts: dict[str, Any]) -> None:
    links = [link for link in urdf("wam").findall("link") if link.attrib["name"] not in ("base_link", "tool_plate")]
    for link, fact, added in zip(links, facts["wam"]["link"], WAM_ROTOR, strict=True):
        check_inertial(link, fact, (added, added, added))


def test_wam_joints_are_those_of_the_manual(facts: dict[str, Any]) -> None:
    torque = facts["wam"]["continuous_joint_torque_estimate"]
    for fact, effort in zip(facts["wam"]["joint"], torque, strict=True):
        joint = element("wam", "joint", fact["name_barrett_model"])
        for key in ("xyz", "rpy"):
            np.testing.assert_allclose(numbers(joint, "origin", key), fact[key], rtol=0, atol=1e-9)
        found = [numbers(joint, "limit", key)[0] for key in ("lower", "upper", "effort", "velocity")]
        assert found == [fact["lower"], fact["upper"], effort, fact["velocity_openrave"]]


def test_wam_tool_plate_follows_the_published_denavit_hartenberg_table(facts: dict[str, Any]) -> None:
    wam, arm = facts["wam"], load_robot("wam").arm("arm")
    generator = np.random.default_rng(9)
    for _ in range(20):
        q = generator.uniform(arm.limits.lower, arm.limits.upper)
        transform = np.eye(4)
        transform[2, 3] = wam["base_plate_to_shoulder_centre_xyz"][2]
        for angle, a, alpha, d in zip(q, wam["dh_a"], wam["dh_alpha"], wam["dh_d"], strict=True):
            transform = transform @ denavit_hartenberg(angle, a, alpha, d)
        pose = arm.forward(q)
        np.testing.assert_allclose(pose.position, transform[:3, 3], rtol=0, atol=1e-9)
        np.testing.assert_allclose(pose.rotation, transform[:3, :3], rtol=0, atol=1e-9)


def denavit_hartenberg(angle: float, a: float, alpha: float, d: float) -> np.ndarray:
    """Transform from frame i - 1 to i in the standard convention: Rz(angle) Tz(d) Tx(a) Rx(alpha)."""
    c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
    return np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])


def test_pr2_gravity_without_springs_is_of_the_published_size(facts: dict[str, Any]) -> None:
    """Largest torques over random soft-limit configurations; the published maxima are over 200 of them."""
    arm = load_robot("pr2").arm("right")
    generator = np.random.default_rng(0)
    lower, upper = np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)
    largest = np.abs([arm.gravity(generator.uniform(lower, upper)) for _ in range(2000)]).max(axis=0)
    expected = np.array(facts["pr2"]["counterbalance"]["uncompensated_max_gravity_torque"])
    np.testing.assert_allclose(largest, expected, rtol=0.1, atol=0.6)
