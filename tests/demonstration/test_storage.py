"""Storage: bit-exact round trips, refusals that say why, and an old file that survives a failed write."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, hdf5, load_demonstrations, save_demonstrations
from pft_exec.demonstration.storage import FORMAT, VERSION
from pft_exec.exceptions import StorageError
from pft_exec.geometry import normalize_quaternion


def example(label: str = "reach", count: int = 400, seed: int = 1) -> Demonstration:
    generator = np.random.default_rng(seed)
    return Demonstration(
        label=label,
        time=np.cumsum(generator.uniform(0.005, 0.015, count)),
        position=generator.normal(size=(count, 3)),
        quaternion=normalize_quaternion(generator.normal(size=(count, 4))),
        continuous={"gripper width": generator.uniform(size=count)},
        discrete={"closed/left": generator.integers(0, 2, count)},
        objects={
            "mat": np.array([0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 1.0]),
            "a/b": np.hstack([generator.normal(size=(count, 3)), np.tile([0.0, 0.0, 0.6, 0.8], (count, 1))]),
        },
        configuration=generator.normal(size=(count, 7)),
        keyframes=(0.5, 1.0),
    )


def assert_same(first: Demonstration, second: Demonstration) -> None:
    assert (first.label, first.keyframes) == (second.label, second.keyframes)
    for name in ("time", "position", "quaternion", "configuration"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    for name in ("continuous", "discrete", "objects"):
        assert list(getattr(first, name)) == list(getattr(second, name))
        for key, values in getattr(first, name).items():
            np.testing.assert_array_equal(values, getattr(second, name)[key])
            assert values.dtype == getattr(second, name)[key].dtype


def test_round_trip_is_bit_exact_and_keeps_the_order(tmp_path: Path) -> None:
    written = [example("reach", seed=1), example("grüße/5 %", seed=2), example("reach", seed=3).segment(0, 2)]
    save_demonstrations(tmp_path / "d.h5", written)
    read = load_demonstrations(tmp_path / "d.h5")
    assert len(read) == 3
    for first, second in zip(written, read, strict=True):
        assert_same(first, second)


def test_a_demonstration_of_positions_alone_stays_one(tmp_path: Path) -> None:
    bare = Demonstration("line", [0.0, 1.0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    (read,) = load_demonstrations(save_demonstrations(tmp_path / "d.h5", [bare]))
    assert read.quaternion is None
    assert read.configuration is None
    assert read.keyframes == ()
    assert not read.objects


def test_no_demonstrations_are_a_valid_file(tmp_path: Path) -> None:
    assert load_demonstrations(save_demonstrations(tmp_path / "d.h5", [])) == []


def test_nothing_but_the_file_is_left_behind(tmp_path: Path) -> None:
    save_demonstrations(tmp_path / "d.h5", [example()])
    save_demonstrations(tmp_path / "d.h5", [example()])
    assert [path.name for path in tmp_path.iterdir()] == ["d.h5"]


def test_refuses_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match=r"there is no file .*gone\.h5"):
        load_demonstrations(tmp_path / "gone.h5")


def test_refuses_a_folder(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="is a folder, not a file of pft_exec demonstrations"):
        load_demonstrations(tmp_path)
    with pytest.raises(StorageError, match=r"it is a folder. Name a file in it"):
        save_demonstrations(tmp_path, [])


def test_refuses_to_write_into_a_folder_that_does_not_exist(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match=r"the folder .*nowhere does not exist. Make it first"):
        save_demonstrations(tmp_path / "nowhere" / "d.h5", [])


@pytest.mark.parametrize("share", [0.0, 0.0001, 0.01, 0.3, 0.7, 0.99])
def test_refuses_a_truncated_file(tmp_path: Path, share: float) -> None:
    path = save_demonstrations(tmp_path / "d.h5", [example()])
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(StorageError, match="truncated"):
        load_demonstrations(path)


def test_refuses_a_file_with_a_flipped_bit_in_its_numbers(tmp_path: Path) -> None:
    path = save_demonstrations(tmp_path / "d.h5", [example()])
    with h5py.File(path, "r") as file:
        dataset = file["demonstrations/0/position"]
        offset, size = dataset.id.get_chunk_info(0).byte_offset, dataset.id.get_chunk_info(0).size
    content = bytearray(path.read_bytes())
    content[offset + size // 2] ^= 1
    path.write_bytes(bytes(content))
    with pytest.raises(StorageError, match="truncated or damaged"):
        load_demonstrations(path)


def test_refuses_what_is_not_hdf5(tmp_path: Path) -> None:
    path = tmp_path / "d.h5"
    path.write_text("time,x,y,z\n0,0,0,0\n")
    with pytest.raises(
        StorageError, match=r"is not an HDF5 file; expected pft_exec demonstrations.*convert them first"
    ):
        load_demonstrations(path)


def test_refuses_an_hdf5_file_of_others(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "d.h5", "w") as file:
        file["data"] = np.zeros(3)
    with pytest.raises(StorageError, match=r"foreign file: .*found no format that this package writes"):
        load_demonstrations(tmp_path / "d.h5")


def test_refuses_another_format_of_ours(tmp_path: Path) -> None:
    hdf5.write_file(tmp_path / "d.h5", {}, "pft_exec execution log", 1)
    with pytest.raises(StorageError, match="expected format 'pft_exec demonstrations', found 'pft_exec execution log'"):
        load_demonstrations(tmp_path / "d.h5")


def test_refuses_a_newer_version(tmp_path: Path) -> None:
    hdf5.write_file(tmp_path / "d.h5", {"demonstrations": []}, FORMAT, VERSION + 1)
    with pytest.raises(StorageError, match=r"written by a newer pft_exec: its schema has version 2.*Update pft_exec"):
        load_demonstrations(tmp_path / "d.h5")


def test_refuses_a_version_that_is_no_number(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "d.h5", "w") as file:
        file.attrs["format"], file.attrs["version"] = FORMAT, "new"
    with pytest.raises(StorageError, match="has no valid schema version: expected 1 to 1, found 'new'"):
        load_demonstrations(tmp_path / "d.h5")


@pytest.mark.parametrize(
    "contents",
    [
        {},
        {"demonstrations": None},
        {"demonstrations": [{"label": "reach"}]},
        {"demonstrations": [3.0]},
    ],
)
def test_refuses_contents_that_make_no_demonstration(tmp_path: Path, contents: dict[str, Any]) -> None:
    hdf5.write_file(tmp_path / "d.h5", contents, FORMAT, VERSION)
    with pytest.raises(StorageError, match="is damaged: its contents make no demonstration"):
        load_demonstrations(tmp_path / "d.h5")


def test_an_interrupted_write_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = save_demonstrations(tmp_path / "d.h5", [example(seed=1)])
    before = path.read_bytes()

    def interrupted(_self: Path, _target: Path) -> Path:
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        save_demonstrations(path, [example(seed=2)])
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["d.h5"]


def test_a_full_disk_is_a_storage_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_self: Path, _target: Path) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(StorageError, match=r"cannot write .*No space left on device"):
        save_demonstrations(tmp_path / "d.h5", [example()])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (object(), "'x' is a object; expected arrays, text, numbers, None or mappings"),
        (np.array(["a"]), "'x' has dtype <U1, which has no place in the file"),
        (np.array([object()]), "'x' has dtype object"),
        ("a\x00b", "text under 'x' holds a NUL"),
        ({"a\x00b": 1}, "a name must be text without NUL"),
        ({3: 1}, "a name must be text without NUL; got 3"),
    ],
)
def test_refuses_values_without_a_place_and_keeps_the_old_file(tmp_path: Path, value: Any, message: str) -> None:
    path = hdf5.write_file(tmp_path / "t.h5", {"x": 1}, "tree", 1)
    with pytest.raises(StorageError, match=message):
        hdf5.write_file(path, {"w": np.zeros(5), "x": value}, "tree", 1)
    assert hdf5.read_file(path, "tree", 1) == {"x": 1}


def test_a_tree_comes_back_with_its_kinds_and_its_order(tmp_path: Path) -> None:
    tree = {
        "z": 1,
        "a": None,
        "flag": True,
        "number": 0.1,
        "text": "für %2F / .",
        "empty text": "",
        "group": {"q/x": {}, "%": [], ".": 1, "": ["a", None, {"b": 2.5}], "..": 2},
    }
    hdf5.write_file(tmp_path / "t.h5", tree, "tree", 1)
    read = hdf5.read_file(tmp_path / "t.h5", "tree", 1)
    assert read == tree
    assert list(read) == list(tree)
    assert type(read["z"]) is int
    assert type(read["flag"]) is bool


@pytest.mark.parametrize("shape", [(), (0,), (3, 0, 2), (7,), (40, 40)])
@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int64, np.uint8, np.bool_])
def test_arrays_come_back_with_shape_dtype_and_bits(tmp_path: Path, shape: tuple[int, ...], dtype: type) -> None:
    array = np.random.default_rng(3).integers(0, 255, shape).astype(dtype)
    array = np.asarray(array / 3 if dtype is np.float64 else array)
    hdf5.write_file(tmp_path / "t.h5", {"x": array}, "tree", 1)
    read = hdf5.read_file(tmp_path / "t.h5", "tree", 1)["x"]
    assert isinstance(read, np.ndarray)
    assert (read.shape, read.dtype) == (array.shape, array.dtype)
    np.testing.assert_array_equal(read, array)


def test_values_that_are_not_finite_survive(tmp_path: Path) -> None:
    hdf5.write_file(tmp_path / "t.h5", {"x": np.array([np.nan, np.inf, -0.0])}, "tree", 1)
    read = hdf5.read_file(tmp_path / "t.h5", "tree", 1)["x"]
    assert read.tobytes() == np.array([np.nan, np.inf, -0.0]).tobytes()
