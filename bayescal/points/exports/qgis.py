"""Control points of QGIS's georeferencer (.points): map and image, two coordinates each.

Columns mapX, mapY, sourceX, sourceY (pixelX, pixelY before QGIS 3.26), enable, dX, dY, residual.
An image's rows are negative there, and the map is a plane.
"""

from __future__ import annotations

from bayescal.points.exports.found import Found
from bayescal.points.tables.content import Content
from bayescal.points.tables.sniffing import Line, TextTable, parse_table, to_float
from bayescal.rounding import counted

NAME = "QGIS control points"
HEADS = (b"mapX,mapY,sourceX,sourceY", b"mapX,mapY,pixelX,pixelY")


def recognises(content: Content) -> bool:
    """Whether a line of the beginning names QGIS's columns."""
    return any(head in content.raw[:4096] for head in HEADS)


def read(content: Content, _view: str | None) -> Found:
    """Read map coordinates as x, y, with z = 0; leave out points that are switched off."""
    table = parse_table(content.name, content.text(), "mapX,mapY,sourceX,sourceY")
    header = table.header
    enabled = header.index("enable") if "enable" in header else None
    kept = [row for row in table.rows if enabled is None or row.fields[enabled] != "0"]
    below = all((to_float(row.fields[3]) or 0) <= 0 for row in kept)
    lines = tuple(
        Line(row.line, (*row.fields[:2], "0", row.fields[2], _turned(row.fields[3], below)))
        for row in kept
    )
    off = len(table.rows) - len(kept)
    notes = [f"{content.name} holds {NAME}: the map is the plane z = 0, so state the camera's z"]
    if below:
        notes.append("sourceY is negative, as QGIS counts; c is its opposite, from the top")
    if off:
        notes.append(f"{counted(off, 'point')} switched off in QGIS left out")
    named = TextTable(content.name, ("x", "y", "z", "r", "c"), lines, table.line)
    return Found(named, None, ("; ".join(notes),))


def _turned(text: str, below: bool) -> str:
    """Change the sign of a number in text."""
    if not below or to_float(text) is None:
        return text
    return text[1:] if text.startswith("-") else f"-{text}"
