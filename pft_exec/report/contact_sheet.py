"""A contact sheet: many small pictures in rows, each framed in the color of what came of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pft_exec.exceptions import StorageError

GOOD, BAD = (0, 158, 115), (213, 94, 0)
"""Frame colors, red, green, blue, which color-blind people tell apart."""
_COLUMNS = 8  # tiles in a row; of more a page's width would leave too little of each
_MARGIN, _EDGE, _BAND = 6, 4, 18  # pixels: between tiles, of the frame, of the text above a row


@dataclass(frozen=True)
class Tile:
    """One small picture.

    Parameters
    ----------
    picture : Path
    is_good : bool
        Colors its frame.
    caption : str
    """

    picture: Path
    is_good: bool
    caption: str = ""


def write_contact_sheet(rows: Mapping[str, Sequence[Tile]], path: str | Path) -> Path:
    """Write one picture (.png) with tiles under each title, all of the first one's size; many go on in a further row.

    Raises
    ------
    StorageError
        If there is no tile, one cannot be read, or nothing can be written there.
    """
    from PIL import Image, ImageDraw, ImageFont

    path = Path(path)
    lines = [line for title, row in rows.items() for line in _wrapped(title, row)]
    tiles = [tile for _, line in lines for tile in line]
    if not tiles:
        raise StorageError(f"cannot write {path}: a contact sheet needs at least one picture.")
    try:
        with Image.open(tiles[0].picture) as first:
            width, height = first.size
        step = (width + 2 * _EDGE + _MARGIN, height + 2 * _EDGE + _MARGIN + _BAND)
        columns = max(len(line) for _, line in lines)
        sheet = Image.new("RGB", (columns * step[0] + _MARGIN, len(lines) * step[1] + _MARGIN), "white")
        drawing, font = ImageDraw.Draw(sheet), ImageFont.load_default(size=13)
        for number, (title, line) in enumerate(lines):
            top = number * step[1]
            drawing.text((_MARGIN, top + 2), title, fill=(20, 20, 20), font=font)
            for place, tile in enumerate(line):
                corner = (_MARGIN + place * step[0], top + _BAND)
                size = (width + 2 * _EDGE, height + 2 * _EDGE)
                sheet.paste(GOOD if tile.is_good else BAD, (*corner, corner[0] + size[0], corner[1] + size[1]))
                with Image.open(tile.picture) as picture:
                    sheet.paste(picture.resize((width, height)), (corner[0] + _EDGE, corner[1] + _EDGE))
                drawing.text((corner[0] + _EDGE + 3, corner[1] + _EDGE + 2), tile.caption, fill=(20, 20, 20), font=font)
        sheet.save(path)
    except OSError as error:
        raise StorageError(f"cannot write {path}: {error}.") from error
    return path


def _wrapped(title: str, row: Sequence[Tile]) -> list[tuple[str, Sequence[Tile]]]:
    """A row as lines that a page can show: the title stands over the first."""
    starts = range(0, max(len(row), 1), _COLUMNS)
    return [(title if not start else "", row[start : start + _COLUMNS]) for start in starts]
