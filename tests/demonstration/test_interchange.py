"""Interchange: recordings of others become demonstrations, or a message says why not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pft_exec.demonstration import convert_recordings, load_demonstrations, save_demonstrations
from pft_exec.exceptions import InvalidDemonstrationError, StorageError
from pft_exec.geometry import quaternion_from_rotation_vector


def test_planar_recordings_have_no_height_and_begin_at_time_zero(tmp_path: Path) -> None:
    path = tmp_path / "r.npz"
    np.savez(path, label=np.array(["a"]), pos_0000=np.ones((3, 2), np.float32), t_0000=np.array([5.0, 6.0, 7.0]))
    (demonstration,) = convert_recordings(path, scale=0.01)
    np.testing.assert_allclose(demonstration.position, [[0.01, 0.01, 0.0]] * 3)
    np.testing.assert_array_equal(demonstration.time, [0.0, 1.0, 2.0])


def test_task_frames_become_objects(tmp_path: Path) -> None:
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    np.savez(
        tmp_path / "r.npz",
        label=np.array(["a"]),
        pos_0000=np.zeros((2, 2)),
        t_0000=np.arange(2.0),
        frame2_A_0000=turn,
        frame2_b_0000=np.array([3.0, 4.0]),
    )
    (demonstration,) = convert_recordings(tmp_path / "r.npz", scale=0.1)
    expected = [0.3, 0.4, 0.0, *quaternion_from_rotation_vector([0.0, 0.0, angle])]
    np.testing.assert_allclose(demonstration.objects["frame2"], expected, atol=1e-12)


def test_a_table_becomes_demonstrations_with_its_signals(tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text(
        "demonstration,label,time,x,y,z,qx,qy,qz,qw,gripper\n"
        "1,reach,0,0,0,1,0,0,0,1,0.08\n1,reach,0.1,1,0,1,0,0,0,1,0.07\n"
        "2,go,0,0,0,1,0,0,0,1,0.08\n2,go,0.1,1,0,1,0,0,1,0,0.07\n"
    )
    first, second = convert_recordings(tmp_path / "r.csv")
    assert (first.label, second.label) == ("reach", "go")
    np.testing.assert_array_equal(first.continuous["gripper"], [0.08, 0.07])
    np.testing.assert_array_equal(second.quaternion[1], [0.0, 0.0, 1.0, 0.0])


def test_a_table_without_labels_is_one_demonstration_named_by_its_file(tmp_path: Path) -> None:
    (tmp_path / "wave.csv").write_text("time,x,y\n1,0,0\n2,1,0\n")
    (demonstration,) = convert_recordings(tmp_path / "wave.csv")
    assert demonstration.label == "wave"
    np.testing.assert_array_equal(demonstration.position[:, 2], 0.0)


def test_refuses_files_of_other_kinds(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match=r"converted from \.npz or \.csv files; got '\.bag'"):
        convert_recordings(tmp_path / "r.bag")
    with pytest.raises(StorageError, match="there is no file"):
        convert_recordings(tmp_path / "r.npz")
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(StorageError, match="is a folder, not a file"):
        convert_recordings(tmp_path / "folder.npz")


def test_refuses_damaged_archives_and_pickles(tmp_path: Path) -> None:
    path = tmp_path / "r.npz"
    path.write_bytes(b"nothing of the kind")
    with pytest.raises(StorageError, match="truncated or no NumPy archive of plain arrays"):
        convert_recordings(path)
    np.savez(path, label=np.array(["a"], dtype=object))
    with pytest.raises(StorageError, match="truncated or no NumPy archive of plain arrays"):
        convert_recordings(path)
    np.savez(path, label=np.array(["a"]), pos_0000=np.zeros((500, 2)), t_0000=np.arange(500.0))
    path.write_bytes(path.read_bytes()[:-300])
    with pytest.raises(StorageError, match="truncated"):
        convert_recordings(path)


def test_refuses_archives_of_something_else(tmp_path: Path) -> None:
    np.savez(tmp_path / "r.npz", weights=np.zeros(3))
    with pytest.raises(StorageError, match=r"holds no recordings: the array 'label' is missing; it has \['weights'\]"):
        convert_recordings(tmp_path / "r.npz")
    np.savez(tmp_path / "r.npz", label=np.array(["a"]), t_0000=np.arange(3.0))
    with pytest.raises(StorageError, match="recording 0 lacks the array 'pos_0000'"):
        convert_recordings(tmp_path / "r.npz")


def test_refuses_recordings_that_make_no_demonstration(tmp_path: Path) -> None:
    np.savez(tmp_path / "r.npz", label=np.array(["a"]), pos_0000=np.zeros((3, 5)), t_0000=np.arange(3.0))
    with pytest.raises(InvalidDemonstrationError, match=r"positions must have 2 or 3 columns; got shape \(3, 5\)"):
        convert_recordings(tmp_path / "r.npz")
    np.savez(
        tmp_path / "r.npz",
        label=np.array(["a"]),
        pos_0000=np.zeros((2, 2)),
        t_0000=np.arange(2.0),
        quat_0000=np.zeros((2, 4)),
    )
    with pytest.raises(InvalidDemonstrationError, match="must have length 1"):
        convert_recordings(tmp_path / "r.npz")


def test_refuses_tables_without_positions_or_with_text_for_numbers(tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text("time,y\n0,1\n")
    with pytest.raises(StorageError, match=r"columns time, x, y are needed; missing \['x'\]"):
        convert_recordings(tmp_path / "r.csv")
    (tmp_path / "r.csv").write_text("time,x,y\n")
    with pytest.raises(StorageError, match=r"missing \[\], 0 rows"):
        convert_recordings(tmp_path / "r.csv")
    (tmp_path / "r.csv").write_text("time,x,y\n0,one,1\n1,2,3\n")
    with pytest.raises(StorageError, match=r"must hold numbers .*'one'"):
        convert_recordings(tmp_path / "r.csv")
    (tmp_path / "r.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(StorageError, match="is no text table"):
        convert_recordings(tmp_path / "r.csv")


def _archive(path: Path, **more: object) -> Path:
    arrays = {"label": np.array(["a"]), "pos_0000": np.zeros((3, 2)), "t_0000": np.arange(3.0)} | more
    np.savez(path / "r.npz", **arrays)
    return path / "r.npz"


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"label": np.array([])}, "'label' is empty"),
        ({"pos_0000": np.full((3, 2), "x")}, "'pos_0000' must hold real numbers"),
        ({"pos_0000": np.full((3, 2), 1j)}, "'pos_0000' must hold real numbers"),
        ({"frame1_A_0000": np.eye(2)}, "lacks the array 'frame1_b_0000'"),
        ({"frame1_b_0000": np.zeros(2)}, "lacks the array 'frame1_A_0000'"),
    ],
)
def test_refuses_archives_whose_arrays_are_no_recordings(
    arrays: dict[str, object], message: str, tmp_path: Path
) -> None:
    with pytest.raises(StorageError, match=message):
        convert_recordings(_archive(tmp_path, **arrays))


@pytest.mark.parametrize("matrix", [np.zeros((2, 2)), np.eye(4), np.diag([1.0, -1.0])])
def test_refuses_frames_that_are_no_rotation(matrix: np.ndarray, tmp_path: Path) -> None:
    with pytest.raises(InvalidDemonstrationError, match="rotation"):
        convert_recordings(_archive(tmp_path, frame1_A_0000=matrix, frame1_b_0000=np.zeros(2)))


def test_labels_of_bytes_are_read_as_text(tmp_path: Path) -> None:
    (demonstration,) = convert_recordings(_archive(tmp_path, label=np.array([b"reach"])))
    assert demonstration.label == "reach"


def test_a_table_of_a_spreadsheet_is_read(tmp_path: Path) -> None:
    """With the mark that spreadsheets begin their files with, blanks behind commas, and trailing commas."""
    (tmp_path / "r.csv").write_text("time, x, y,,\n0, 1, 2,,\n1, 2, 3,,\n", encoding="utf-8-sig")
    (demonstration,) = convert_recordings(tmp_path / "r.csv")
    np.testing.assert_array_equal(demonstration.position, [[1.0, 2.0, 0.0], [2.0, 3.0, 0.0]])


def test_an_empty_cell_is_a_lost_sample(tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text("time,x,y\n0,1,2\n1,,3\n2,3,4\n")
    with pytest.warns(RuntimeWarning, match="1 of 3 samples are left out"):
        (demonstration,) = convert_recordings(tmp_path / "r.csv")
    np.testing.assert_array_equal(demonstration.time, [0.0, 2.0])


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("time,x,y\n0,1,2\n1,2\n", "row 2 must have 3 values"),
        ("time,x,y\n0,1,2,3\n1,2,3\n", "row 1 must have 3 values"),
        ("time,x,y,x\n0,1,2,3\n1,2,3,4\n", "twice there: 'x'"),
    ],
)
def test_refuses_tables_whose_columns_are_in_doubt(table: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text(table)
    with pytest.raises(StorageError, match=message):
        convert_recordings(tmp_path / "r.csv")


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "count", "motions", "oriented"),
    [
        ("helloworld", 56, 7, False),
        ("robottasks9", 81, 9, True),
        ("letters2d", 340, 26, False),
        ("reach_target", 9, 1, False),
    ],
)
def test_recordings_of_real_people_convert_and_survive_storage(
    recordings: Path, tmp_path: Path, name: str, count: int, motions: int, oriented: bool
) -> None:
    demonstrations = convert_recordings(recordings / f"{name}.npz")
    assert len(demonstrations) == count
    assert len({item.label for item in demonstrations}) == motions
    assert all((item.quaternion is not None) == oriented for item in demonstrations)
    stored = load_demonstrations(save_demonstrations(tmp_path / "d.h5", demonstrations))
    for first, second in zip(demonstrations, stored, strict=True):
        np.testing.assert_array_equal(first.position, second.position)
        if oriented:
            np.testing.assert_array_equal(first.quaternion, second.quaternion)


def test_samples_that_cannot_be_used_are_left_out_and_counted(tmp_path: Path) -> None:
    """A repeated one, one that is late, and one that was lost; what remains is what a clean file gives."""
    time = np.array([0.0, 0.1, 0.1, 0.2, 0.15, 0.3, 0.4])
    position = np.column_stack([time, time])
    position[5] = np.nan
    np.savez(tmp_path / "r.npz", label=np.array(["a"]), pos_0000=position, t_0000=time)
    with pytest.warns(RuntimeWarning, match=r"recording 0 of r\.npz \(a\): 3 of 7 samples are left out"):
        (demonstration,) = convert_recordings(tmp_path / "r.npz")
    np.testing.assert_allclose(demonstration.time, [0.0, 0.1, 0.2, 0.4])
    np.testing.assert_allclose(demonstration.position[:, 0], [0.0, 0.1, 0.2, 0.4])


def test_a_table_leaves_out_lost_samples_with_their_signals(tmp_path: Path) -> None:
    (tmp_path / "w.csv").write_text("time,x,y,grip\n0,0,0,1\n1,nan,0,2\n2,2,0,3\n3,3,0,nan\n4,4,0,5\n")
    with pytest.warns(RuntimeWarning, match="2 of 5 samples are left out"):
        (demonstration,) = convert_recordings(tmp_path / "w.csv")
    np.testing.assert_array_equal(demonstration.continuous["grip"], [1.0, 3.0, 5.0])


def test_a_recording_of_which_nothing_can_be_used_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "r.npz", label=np.array(["a"]), pos_0000=np.full((5, 3), np.nan), t_0000=np.arange(5.0))
    with pytest.warns(RuntimeWarning, match="5 of 5"), pytest.raises(InvalidDemonstrationError):
        convert_recordings(tmp_path / "r.npz")
