"""The motion library: grouping, storage, scenes that lack an object."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from pft_exec.demonstration import Scene
from pft_exec.exceptions import LearningError, MissingObjectError, StorageError, UnknownMotionError, UnknownNameError
from pft_exec.learning import METHODS, MotionLibrary, learn_library
from tests.learning.taught import TRUTH, all_lessons, lesson, taught

NEW = taught("reach", np.random.default_rng(99))


def test_demonstrations_are_grouped_by_label_in_order_of_appearance() -> None:
    library = learn_library(all_lessons())
    assert library.labels == tuple(TRUTH)
    assert len(library) == 4
    assert "reach" in library
    assert [library[label].label for label in library] == list(TRUTH)


def test_a_library_of_nothing_is_refused() -> None:
    with pytest.raises(LearningError, match="got none"):
        learn_library([])


def test_an_unknown_label_is_refused_with_the_nearest_choice() -> None:
    with pytest.raises(UnknownMotionError, match="Did you mean 'reach'"):
        learn_library(all_lessons())["reech"]


@pytest.mark.parametrize("method", METHODS)
def test_a_loaded_library_equals_the_saved_one_bit_for_bit(method: str, tmp_path: Path) -> None:
    library = learn_library(all_lessons(), method)
    library.save(tmp_path / "library.h5")
    loaded = MotionLibrary.load(tmp_path / "library.h5")
    assert loaded.labels == library.labels
    assert loaded.describe() == library.describe()
    saved_tubes, tubes = library.flow_tubes(NEW.scene, NEW.start), loaded.flow_tubes(NEW.scene, NEW.start)
    for label, tube in tubes.items():
        np.testing.assert_array_equal(tube.position, saved_tubes[label].position)
        np.testing.assert_array_equal(tube.covariance, saved_tubes[label].covariance)


def test_a_foreign_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "library.h5").write_text("no library")
    with pytest.raises(StorageError):
        MotionLibrary.load(tmp_path / "library.h5")


@pytest.mark.parametrize("part", ["motions", "motions/0/method", "motions/0/demonstrations/1/label"])
def test_a_file_that_lacks_a_part_is_called_damaged(part: str, tmp_path: Path) -> None:
    path = learn_library(all_lessons()).save(tmp_path / "library.h5")
    with h5py.File(path, "r+") as file:
        del file[part]
    with pytest.raises(StorageError, match="damaged"):
        MotionLibrary.load(path)


def test_a_file_of_an_unknown_method_is_called_damaged(tmp_path: Path) -> None:
    path = learn_library(all_lessons()).save(tmp_path / "library.h5")
    with h5py.File(path, "r+") as file:
        del file["motions/0/method"]
        file["motions/0"].create_dataset("method", data="next year's")
    with pytest.raises(StorageError, match="no learning method"):
        MotionLibrary.load(path)


def test_a_motion_whose_object_is_missing_is_left_out_with_a_warning() -> None:
    library = learn_library(all_lessons())
    with pytest.warns(RuntimeWarning, match="motion 'reach' is left out.*'bottle'"):
        tubes = library.flow_tubes(Scene({"mat": NEW.scene["mat"]}), NEW.start)
    assert set(tubes) == set(TRUTH) - {"reach"}


def test_a_mirrored_library_has_the_same_motions() -> None:
    library = learn_library(all_lessons())
    assert library.mirrored().labels == library.labels


def test_the_published_method_regularizes_all_motions_of_a_library_alike() -> None:
    library = learn_library(all_lessons(), "dong2012")
    values = {motion.options["regularization"] for motion in library.motions.values()}
    assert len(values) == 1


def _library_with_a_motion_that_knows_no_bottle() -> MotionLibrary:
    others = [d for d in all_lessons() if d.label != "reach"]
    blind = [replace(d, objects={"mat": d.objects["mat"]}) for d in others if d.label == "move_left"]
    return learn_library([*lesson("reach"), *blind])


def test_a_substitution_concerns_the_motions_that_know_the_object_and_no_others() -> None:
    library = _library_with_a_motion_that_knows_no_bottle()
    scene = Scene({"mat": NEW.scene["mat"], "carton": NEW.scene["bottle"]})
    tubes, plain = library.flow_tubes(scene, NEW.start, {"bottle": "carton"}), library.flow_tubes(NEW.scene, NEW.start)
    assert list(tubes) == ["reach", "move_left"]
    for label, tube in tubes.items():
        np.testing.assert_array_equal(tube.position, plain[label].position)
        alone = library.flow_tube(label, scene, NEW.start, {"bottle": "carton"})
        np.testing.assert_array_equal(alone.position, tube.position)
    with pytest.raises(UnknownNameError, match="no object of motion 'move_left' is named 'bottle'"):
        library["move_left"].flow_tube(scene, NEW.start, {"bottle": "carton"})
    with pytest.raises(MissingObjectError, match="'jug'"):
        library.flow_tube("reach", scene, NEW.start, {"bottle": "jug"})


def test_a_substitute_for_what_no_motion_knows_is_refused() -> None:
    library = _library_with_a_motion_that_knows_no_bottle()
    for ask in (library.flow_tubes, lambda *given: library.flow_tube("reach", *given)):
        with pytest.raises(UnknownNameError, match=r"no object of the library's motions is named 'botle'.*'bottle'"):
            ask(NEW.scene, NEW.start, {"botle": "mat"})
    with pytest.raises(UnknownMotionError, match="Did you mean 'reach'"):
        library.flow_tube("reech", NEW.scene, NEW.start)
