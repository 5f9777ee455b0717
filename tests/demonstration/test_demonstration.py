"""Demonstrations and scenes: what they refuse, what they mend, and their invariances."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import FrozenInstanceError
from typing import Any

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.exceptions import InvalidDemonstrationError, InvalidSceneError, MissingObjectError
from pft_exec.geometry import Pose, geodesic_distance, normalize_quaternion

COUNT = 20


def arrays(**changes: Any) -> dict[str, Any]:
    """A valid demonstration's arguments, with changes."""
    generator = np.random.default_rng(7)
    walk = np.cumsum(0.05 * generator.normal(size=(COUNT, 4)), axis=0) + np.array([0.0, 0.0, 0.0, 2.0])
    values: dict[str, Any] = {
        "label": "reach",
        "time": np.linspace(0.0, 2.0, COUNT),
        "position": generator.normal(size=(COUNT, 3)),
        "quaternion": normalize_quaternion(walk),
        "continuous": {"gripper": np.linspace(0.0, 0.08, COUNT)},
        "discrete": {"closed": np.arange(COUNT) // 10},
        "objects": {
            "bottle": np.array([0.5, 0.1, 0.8, 0.0, 0.0, 0.0, 1.0]),
            "mat": np.tile([0.6, -0.2, 0.7, 0.0, 0.0, 1.0, 0.0], (COUNT, 1)),
        },
        "configuration": generator.normal(size=(COUNT, 7)),
        "keyframes": (0.5, 1.5),
    }
    return {**values, **changes}


def broken(name: str, index: Any, value: float) -> dict[str, Any]:
    changed = np.array(arrays()[name], dtype=float)
    changed[index] = value
    return arrays(**{name: changed})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (arrays(label=""), "needs a label"),
        (arrays(position=np.zeros((COUNT, 2))), r"position must have shape \(20, 3\).*got \(20, 2\)"),
        (arrays(position=[["a", "b", "c"]] * COUNT), "position must be numbers"),
        (broken("position", (3, 1), np.nan), r"position must be finite; sample 3 .*\(1 such values\).*interpolate"),
        (broken("time", 4, np.inf), "time must be finite; sample 4"),
        (broken("time", 4, 0.0), "time must increase.*at sample 4.*Sort the samples"),
        (
            {"label": "reach", "time": [0.0], "position": np.zeros((1, 3))},
            "at least 2 samples are needed; got 1",
        ),
        (arrays(quaternion=np.zeros((COUNT, 3))), r"quaternion must have shape \(20, 4\)"),
        (broken("quaternion", 5, 0.9), r"\(x, y, z, w\) must have length 1 within 0.001; sample 5 has 1.8.*Normalize"),
        (broken("configuration", (2, 2), np.nan), "configuration must be finite"),
        (arrays(configuration=np.zeros(COUNT)), "configuration must have shape"),
        (arrays(continuous={"gripper": np.zeros(3)}), "continuous 'gripper' must have shape"),
        (arrays(discrete={"closed": np.full(COUNT, 0.5)}), "discrete 'closed' must be whole numbers"),
        (arrays(objects={"mat": np.zeros((3, 7))}), r"object 'mat' must have shape \(20, 7\)"),
        (arrays(objects={"mat": np.zeros(7)}), "quaternion of object 'mat'.*has 0"),
        (arrays(keyframes=(2.5,)), "keyframe must lie inside the recording, 0 to 2 s; got 2.5 s"),
        (arrays(keyframes=(0.0,)), "keyframe must lie inside"),
    ],
)
def test_refuses_what_makes_no_demonstration(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidDemonstrationError, match=message):
        Demonstration(**arguments)


def test_every_message_names_the_motion() -> None:
    with pytest.raises(InvalidDemonstrationError, match="demonstration of 'reach'"):
        Demonstration(**arrays(position=np.zeros(3)))


def test_single_precision_is_ordinary_input() -> None:
    full = Demonstration(**arrays())
    single = Demonstration(
        **arrays(position=full.position.astype(np.float32), quaternion=np.asarray(full.quaternion, dtype=np.float32))
    )
    assert single.position.dtype == np.float64
    np.testing.assert_allclose(single.position, full.position, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(single.quaternion, axis=1), 1.0, atol=1e-15)


def test_mends_sign_flips_of_quaternions() -> None:
    smooth = arrays()["quaternion"]
    flipped = smooth.copy()
    flipped[[3, 4, 9, 15]] *= -1.0
    demonstration = Demonstration(**arrays(quaternion=flipped))
    np.testing.assert_allclose(demonstration.quaternion, smooth, atol=1e-15)


def test_mends_sign_flips_of_moving_objects() -> None:
    poses = arrays()["objects"]["mat"].copy()
    poses[::2, 3:] *= -1.0
    quaternions = Demonstration(**arrays(objects={"mat": poses})).objects["mat"][:, 3:]
    assert (np.sum(quaternions[1:] * quaternions[:-1], axis=1) > 0.0).all()


def test_unit_quaternions_stay_bit_for_bit() -> None:
    """Making a demonstration from a demonstration's own arrays changes no bit."""
    once = Demonstration(**arrays())
    twice = Demonstration(**arrays(quaternion=once.quaternion))
    np.testing.assert_array_equal(once.quaternion, twice.quaternion)


def test_is_frozen_and_keeps_its_own_copy() -> None:
    position = np.zeros((COUNT, 3))
    demonstration = Demonstration(**arrays(position=position))
    position[0] = 1.0
    assert demonstration.position[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        demonstration.position[0] = 1.0
    with pytest.raises(TypeError):
        demonstration.continuous["gripper"] = np.zeros(COUNT)  # type: ignore[index]
    with pytest.raises(FrozenInstanceError):
        demonstration.label = "other"  # type: ignore[misc]


def test_scene_start_end_and_duration_are_those_of_the_samples() -> None:
    demonstration = Demonstration(**arrays())
    assert set(demonstration.scene) == {"bottle", "mat"}
    np.testing.assert_array_equal(demonstration.scene["mat"].position, [0.6, -0.2, 0.7])
    np.testing.assert_array_equal(demonstration.start.position, demonstration.position[0])
    np.testing.assert_array_equal(demonstration.end.position, demonstration.position[-1])
    assert demonstration.duration == 2.0
    assert len(demonstration) == COUNT


def test_without_orientation_start_has_the_identity() -> None:
    np.testing.assert_array_equal(Demonstration(**arrays(quaternion=None)).start.quaternion, [0.0, 0.0, 0.0, 1.0])


def test_mirror_of_mirror_is_the_original() -> None:
    demonstration = Demonstration(**arrays())
    plane = Pose([0.1, 0.2, 0.3], normalize_quaternion([0.1, 0.2, 0.3, 0.9]))
    back = demonstration.mirrored(plane).mirrored(plane)
    np.testing.assert_allclose(back.position, demonstration.position, atol=1e-12)
    np.testing.assert_allclose(back.objects["mat"], demonstration.objects["mat"], atol=1e-12)
    assert geodesic_distance(back.quaternion, demonstration.quaternion).max() < 1e-7


def test_mirroring_leaves_out_the_joint_state() -> None:
    assert Demonstration(**arrays()).mirrored().configuration is None


def test_mirroring_inverts_y() -> None:
    demonstration = Demonstration(**arrays())
    np.testing.assert_allclose(demonstration.mirrored().position, demonstration.position * [1.0, -1.0, 1.0])


def test_keyframes_are_sorted_and_kept_by_a_segment_that_holds_them() -> None:
    demonstration = Demonstration(**arrays(keyframes=(1.5, 0.5)))
    assert demonstration.keyframes == (0.5, 1.5)
    assert demonstration.segment(0, 10).keyframes == (0.5,)


def test_a_segment_has_the_samples_of_its_range() -> None:
    demonstration = Demonstration(**arrays())
    part = demonstration.segment(4, 9)
    np.testing.assert_array_equal(part.time, demonstration.time[4:9])
    np.testing.assert_array_equal(part.objects["mat"], demonstration.objects["mat"][4:9])
    np.testing.assert_array_equal(part.objects["bottle"], demonstration.objects["bottle"])
    np.testing.assert_array_equal(part.configuration, demonstration.configuration[4:9])


def test_copies_deeply_and_so_travels_between_processes() -> None:
    demonstration = Demonstration(**arrays())
    copy = deepcopy(demonstration)
    np.testing.assert_array_equal(copy.quaternion, demonstration.quaternion)
    assert copy.keyframes == demonstration.keyframes
    assert set(deepcopy(demonstration.scene)) == {"bottle", "mat"}


def test_scene_refuses_what_is_no_pose() -> None:
    with pytest.raises(InvalidSceneError, match=r"object 'mat' of a scene must be a Pose; got list.*Pose\(position"):
        Scene({"mat": [0.0, 0.0, 0.0]})  # type: ignore[dict-item]


def test_scene_names_the_nearest_object() -> None:
    scene = Scene({"bottle": Pose([0.0, 0.0, 0.0]), "mat": Pose([1.0, 0.0, 0.0])})
    with pytest.raises(MissingObjectError, match=r"no object of the scene is named 'botle'\. Did you mean 'bottle'\?"):
        scene["botle"]
    assert "mat" in scene
    assert len(scene) == 2


def test_scene_mirrored_twice_is_the_original() -> None:
    scene = Scene({"mat": Pose([1.0, 2.0, 3.0], normalize_quaternion([0.3, -0.2, 0.5, 0.7]))})
    back = scene.mirrored().mirrored()
    np.testing.assert_allclose(back["mat"].position, scene["mat"].position, atol=1e-15)
    assert geodesic_distance(back["mat"].quaternion, scene["mat"].quaternion) < 1e-7


def test_scene_cannot_be_changed() -> None:
    poses = {"mat": Pose([1.0, 2.0, 3.0])}
    scene = Scene(poses)
    poses["bottle"] = Pose([0.0, 0.0, 0.0])
    assert "bottle" not in scene
    with pytest.raises(TypeError):
        scene.objects["bottle"] = poses["bottle"]  # type: ignore[index]


def test_an_object_that_stood_still_may_be_given_as_its_pose() -> None:
    pose = Pose([0.1, 0.2, 0.3], [0.0, 0.0, 1.0, 0.0])
    demonstration = Demonstration("reach", [0.0, 1.0], np.zeros((2, 3)), objects={"cup": pose})
    assert demonstration.scene["cup"] == pose


@pytest.mark.parametrize("name", ["continuous", "discrete", "objects"])
def test_refuses_names_without_arrays(name: str) -> None:
    with pytest.raises(InvalidDemonstrationError, match=f"{name} must be a mapping"):
        Demonstration("reach", [0.0, 1.0], np.zeros((2, 3)), **{name: [1.0]})


def test_refuses_keyframes_that_are_no_numbers() -> None:
    with pytest.raises(InvalidDemonstrationError, match="keyframes must be numbers"):
        Demonstration("reach", [0.0, 1.0], np.zeros((2, 3)), keyframes=("half",))


def test_scene_refuses_what_is_no_mapping() -> None:
    with pytest.raises(InvalidSceneError, match="mapping"):
        Scene([Pose([0.0, 0.0, 0.0])])
