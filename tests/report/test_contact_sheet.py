"""A contact sheet shows every picture, framed by what came of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pft_exec.exceptions import StorageError
from pft_exec.report.contact_sheet import BAD, GOOD, Tile, write_contact_sheet


def tile(folder: Path, name: str, shade: int, is_good: bool) -> Tile:
    path = folder / name
    Image.new("RGB", (40, 30), (shade, shade, shade)).save(path)
    return Tile(path, is_good, name[0])


def test_each_picture_is_there_in_the_color_of_its_result(tmp_path: Path) -> None:
    rows = {
        "reach": [tile(tmp_path, "a.png", 101, True), tile(tmp_path, "b.png", 102, False)],
        "stir": [tile(tmp_path, "c.png", 103, True)],
    }
    with Image.open(write_contact_sheet(rows, tmp_path / "sheet.png")) as opened:
        sheet = np.asarray(opened.convert("RGB")).reshape(-1, 3)
    counts = {shade: int((sheet == shade).all(axis=1).sum()) for shade in (101, 102, 103)}
    assert min(counts.values()) > 800  # of 1200 pixels, some under the caption
    assert (sheet == GOOD).all(axis=1).sum() == 2 * (sheet == BAD).all(axis=1).sum() > 0


def test_many_pictures_go_on_in_further_rows(tmp_path: Path) -> None:
    rows = {"reach": [tile(tmp_path, f"{place:02d}.png", 100 + place, True) for place in range(20)]}
    with Image.open(write_contact_sheet(rows, tmp_path / "sheet.png")) as opened:
        sheet = np.asarray(opened.convert("RGB"))
    assert sheet.shape[1] == 8 * (40 + 14) + 6
    assert sheet.shape[0] == 3 * (30 + 32) + 6
    assert all((sheet == 100 + place).all(axis=-1).sum() > 800 for place in range(20))


def test_pictures_that_are_not_there_are_named(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="needs at least one picture"):
        write_contact_sheet({"reach": []}, tmp_path / "sheet.png")
    with pytest.raises(StorageError, match=r"gone\.png"):
        write_contact_sheet({"reach": [Tile(tmp_path / "gone.png", True)]}, tmp_path / "sheet.png")
