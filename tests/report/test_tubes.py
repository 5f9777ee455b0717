"""Pictures of tubes, and the surface they draw."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.exceptions import StorageError
from pft_exec.geometry import Pose
from pft_exec.learning import FlowTube, MotionLibrary
from pft_exec.report import plot_demonstrations, plot_tubes, tube_surface
from pft_exec.report.style import line_of
from pft_exec.report.timing import band_over_time
from pft_exec.report.tubes import objects_near

PNG = b"\x89PNG"


def helix(count: int = 200) -> FlowTube:
    angle = np.linspace(0.0, 4.0 * np.pi, count)
    position = np.stack([np.cos(angle), np.sin(angle), 0.1 * angle], axis=1)
    covariance = np.tile(np.diag([4e-4, 1e-4, 9e-4]), (count, 1, 1))
    return FlowTube("turn", np.linspace(0.0, 5.0, count), position, covariance=covariance)


def test_every_point_of_the_surface_lies_in_the_normal_plane_of_its_step() -> None:
    surface = tube_surface(helix())
    center = surface[:, :-1].mean(axis=1)
    tangent = np.gradient(center, axis=0)
    offset = surface - center[:, None]
    np.testing.assert_allclose(np.einsum("sri,si->sr", offset, tangent), 0.0, atol=1e-12)


def test_the_surface_is_the_ellipse_of_the_covariance_cut_by_the_normal_plane() -> None:
    """Where the path runs along z, two standard deviations are 40 mm along x and 20 mm along y."""
    position = np.outer(np.linspace(0.0, 1.0, 50), [0.0, 0.0, 1.0])
    tube = FlowTube("up", np.arange(50.0), position, covariance=np.tile(np.diag([4e-4, 1e-4, 9e-4]), (50, 1, 1)))
    ring = tube_surface(tube)[0]
    np.testing.assert_allclose(np.abs(ring).max(axis=0), [0.04, 0.02, 0.0], atol=1e-3)
    np.testing.assert_allclose((ring[:, 0] / 0.04) ** 2 + (ring[:, 1] / 0.02) ** 2, 1.0, atol=1e-9)


def test_the_surface_does_not_twist() -> None:
    """Neighboring rings are near each other point by point, round a helix and along a path that doubles back."""
    surface = tube_surface(helix(), sections=200)
    step = np.linalg.norm(np.diff(surface, axis=0), axis=2)
    assert step.max() < 0.15


def test_a_path_that_stands_still_or_leaves_along_the_first_axis_has_a_surface() -> None:
    position = np.zeros((40, 3))
    position[20:, 0] = np.linspace(0.0, 1.0, 20)
    tube = FlowTube("wait", np.arange(40.0), position, covariance=np.tile(1e-4 * np.eye(3), (40, 1, 1)))
    assert np.isfinite(tube_surface(tube)).all()


def test_a_tool_that_rests_and_trembles_does_not_fold_the_surface_of_its_tube() -> None:
    """Sections are spread over the way, not over the time: nothing is drawn across the way by noise at rest."""
    rng = np.random.default_rng(0)
    position = np.zeros((200, 3))
    position[50:150, 0], position[150:, 0] = np.linspace(0.0, 1.0, 100), 1.0
    position[:50] += rng.normal(0.0, 1e-5, (50, 3))
    tube = FlowTube("go", np.arange(200.0), position, covariance=np.tile(1e-4 * np.eye(3), (200, 1, 1)))
    surface = tube_surface(tube)
    assert np.ptp(surface[2:-2, :, 0], axis=1).max() < 1e-4, "rings stand across the way"


def test_over_time_the_band_of_a_tube_holds_who_is_late() -> None:
    """At 1 m/s, 0.1 s of timing and 50 mm aside add up to sqrt(0.1^2 + 0.05^2) m, far from the ends."""
    time = np.linspace(0.0, 4.0, 400)
    ramp = np.stack([time, 0.0 * time, 0.0 * time], axis=1)
    covariance = np.tile(0.05**2 * np.eye(3), (400, 1, 1))
    tube = FlowTube("go", time, ramp, covariance=covariance, time_deviation=np.full(400, 0.1))
    at, low, high = band_over_time(tube, 0, 2.0)
    middle = (at > 1.0) & (at < 3.0)
    np.testing.assert_allclose(0.5 * (low + high)[middle], at[middle], atol=2e-3)
    np.testing.assert_allclose(0.25 * (high - low)[middle], np.hypot(0.1, 0.05), rtol=0.03)
    _, low, high = band_over_time(tube, 1, 2.0)
    np.testing.assert_allclose(0.25 * (high - low), 0.05, rtol=0.03)
    assert at[-1] == pytest.approx(4.2)


def test_a_band_over_time_never_leaves_the_way_of_a_tube_without_width() -> None:
    """However late somebody is, the tool is on a path that turns back: a first-order band would lie beyond the turn."""
    time = np.linspace(0.0, 10.0, 500)
    swing = np.stack([np.sin(2.0 * np.pi * time), 0.0 * time, 0.0 * time], axis=1)
    covariance = np.tile(1e-12 * np.eye(3), (500, 1, 1))
    tube = FlowTube("swing", time, swing, covariance=covariance, time_deviation=np.full(500, 0.7))
    _, low, high = band_over_time(tube, 0, 2.0)
    assert low.min() > -1.001
    assert high.max() < 1.001
    _, low, high = band_over_time(FlowTube("swing", time, swing, covariance=covariance), 0, 2.0)
    assert (high - low).max() < 1e-4, "no spread of timing, no band"


@pytest.mark.parametrize("suffix", ["png", "pdf", "svg"])
def test_tubes_are_drawn_with_their_demonstrations(
    suffix: str, library: MotionLibrary, demonstrations: list[Demonstration], tmp_path: Path
) -> None:
    scene = demonstrations[0].scene
    plot_tubes(library.flow_tubes(scene), demonstrations, tmp_path / f"tubes.{suffix}", scene)
    assert (tmp_path / f"tubes.{suffix}").stat().st_size > 10_000


def test_a_tube_from_plain_arrays_is_drawn_with_the_demonstrations_of_its_label(tmp_path: Path) -> None:
    taught = [Demonstration("turn", helix().time, helix().position)]
    plot_tubes({"turn": helix()}, taught, tmp_path / "tube.png")
    assert (tmp_path / "tube.png").read_bytes().startswith(PNG)


def test_demonstrations_are_drawn_by_motion(demonstrations: list[Demonstration], tmp_path: Path) -> None:
    plot_demonstrations(demonstrations, tmp_path / "demonstrations.png")
    assert (tmp_path / "demonstrations.png").read_bytes().startswith(PNG)


def test_more_labels_than_colors_still_look_different() -> None:
    looks = line_of(f"motion {number}" for number in range(24))
    assert len({(look["color"], look["linestyle"]) for look in looks.values()}) == 24
    assert {look["linestyle"] for look in list(line_of(f"{number}" for number in range(8)).values())} == {"-"}


def test_a_picture_in_a_missing_folder_or_of_an_unknown_kind_is_refused(
    demonstrations: list[Demonstration], tmp_path: Path
) -> None:
    with pytest.raises(StorageError, match=r"the folder .*nowhere does not exist"):
        plot_demonstrations(demonstrations, tmp_path / "nowhere" / "a.png")
    with pytest.raises(StorageError, match=r"ends in \.png, \.pdf or \.svg; got '\.txt'"):
        plot_demonstrations(demonstrations, tmp_path / "a.txt")
    (tmp_path / "taken.png").mkdir()
    with pytest.raises(StorageError, match="cannot write"):
        plot_demonstrations(demonstrations, tmp_path / "taken.png")


def test_no_picture_is_left_when_drawing_fails(tmp_path: Path) -> None:
    with pytest.raises(AttributeError):
        plot_demonstrations([None], tmp_path / "a.png")  # type: ignore[list-item]
    assert not (tmp_path / "a.png").exists()


def test_an_object_that_the_motion_is_relative_to_is_shown_however_far_it_is() -> None:
    scene = Scene({name: Pose((0.0, 0.0, height)) for name, height in (("near", 1.4), ("cup", 9.0), ("far", 9.0))})
    assert list(objects_near(helix().position, scene, {"cup"})) == ["near", "cup"]


def test_objects_far_from_a_path_are_left_out_of_its_picture(tmp_path: Path) -> None:
    """An object ten paths away would shrink the tube to a dot."""
    near, far = Pose((0.0, 0.0, 2.0)), Pose((0.0, 0.0, 40.0))
    plot_tubes({"turn": helix()}, [], tmp_path / "both.png", Scene({"near": near, "far": far}))
    plot_tubes({"turn": helix()}, [], tmp_path / "near.png", {"turn": Scene({"near": near})})
    plot_tubes({"turn": helix()}, [], tmp_path / "none.png")
    assert (tmp_path / "both.png").read_bytes() == (tmp_path / "near.png").read_bytes()
    assert (tmp_path / "both.png").read_bytes() != (tmp_path / "none.png").read_bytes()
