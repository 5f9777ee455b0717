"""A page: text, tables and pictures in one HTML file that needs nothing else, to be read or printed."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from pft_exec.exceptions import StorageError
from pft_exec.report.tables import cell_text

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; max-width: 72em; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin-top: 2em; border-top: 1px solid #ddd; padding-top: 0.8em; }
table { border-collapse: collapse; margin: 0.8em 0; font-size: 0.92em; }
th, td { padding: 0.2em 0.7em; text-align: left; border-bottom: 1px solid #e4e4e4; vertical-align: top; }
th { border-bottom: 1.5px solid #888; } img { max-width: 100%; } caption { text-align: left; color: #555; }
section { break-inside: avoid; }
"""


def heading(text: str, level: int = 2) -> str:
    """A heading."""
    return f"<h{level}>{escape(text)}</h{level}>"


def paragraph(text: str) -> str:
    """A paragraph of plain text."""
    return f"<p>{escape(text)}</p>"


def table(rows: Sequence[Mapping[str, Any]], caption: str = "") -> str:
    """A table with a column per key of the first row; nothing where there is no row."""
    if not rows:
        return ""
    names = list(rows[0])
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell_text(row.get(name)))}</td>" for name in names) + "</tr>" for row in rows
    )
    title = f"<caption>{escape(caption)}</caption>" if caption else ""
    return f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def image(path: str | Path, description: str) -> str:
    """A picture (.png), embedded.

    Raises
    ------
    StorageError
        If it cannot be read.
    """
    try:
        data = b64encode(Path(path).read_bytes()).decode("ascii")
    except OSError as error:
        raise StorageError(f"cannot read {path}: {error}.") from error
    return f'<img alt="{escape(description)}" src="data:image/png;base64,{data}">'


def section(*parts: str) -> str:
    """Parts that a printer keeps on one sheet where it can."""
    return f"<section>{''.join(parts)}</section>"


def write_page(path: str | Path, title: str, parts: Sequence[str]) -> Path:
    """Write a page of such parts as HTML, under its title.

    Raises
    ------
    StorageError
        If nothing can be written there.
    """
    path = Path(path)
    content = (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f"<style>{_STYLE}</style></head><body>{heading(title, 1)}{''.join(parts)}</body></html>\n"
    )
    try:
        path.write_text(content, encoding="utf-8")
    except OSError as error:
        raise StorageError(f"cannot write {path}: {error}.") from error
    return path
