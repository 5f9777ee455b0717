"""A page holds all that it shows, and nothing of it is read as markup."""

from __future__ import annotations

from base64 import b64encode
from pathlib import Path

import pytest

from pft_exec.exceptions import StorageError
from pft_exec.report import page


def test_words_are_shown_as_they_are() -> None:
    assert page.paragraph("a < b & c") == "<p>a &lt; b &amp; c</p>"
    assert "<td>&lt;i&gt;</td>" in page.table([{"what": "<i>"}])


def test_a_table_has_the_columns_of_its_first_row_and_none_without_rows() -> None:
    text = page.table([{"a": 1, "b": True}, {"a": 2.0}], "numbers")
    assert text.count("<tr>") == 3
    assert "<th>a</th><th>b</th>" in text
    assert "<td>1</td><td>yes</td>" in text
    assert "<caption>numbers</caption>" in text
    assert page.table([]) == ""


def test_a_picture_is_part_of_the_page(tmp_path: Path) -> None:
    picture = tmp_path / "dot.png"
    picture.write_bytes(b"picture")
    written = page.write_page(tmp_path / "page.html", "Title", [page.section(page.image(picture, "a dot"))])
    text = written.read_text(encoding="utf-8")
    assert b64encode(b"picture").decode() in text
    assert "<title>Title</title>" in text
    picture.unlink()
    with pytest.raises(StorageError, match="cannot read"):
        page.image(picture, "a dot")


def test_a_page_goes_to_a_folder_that_exists(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="cannot write"):
        page.write_page(tmp_path / "nowhere" / "page.html", "Title", [])
