"""Workbooks of Excel (.xlsx), by pandas and openpyxl where they are installed."""

from __future__ import annotations

import io

from bayescal.points.exports.found import Found
from bayescal.points.exports.installed import read_frame
from bayescal.points.tables.content import Content
from bayescal.points.tables.frames import frame_table

NAME = "Excel workbook"
NEEDS = ("pandas", "openpyxl")


def recognises(content: Content) -> bool:
    """Whether it is a zip archive that holds a workbook."""
    return content.raw.startswith(b"PK\x03\x04") and b"xl/workbook.xml" in content.raw


def read(content: Content, _view: str | None) -> Found:
    """Read the first sheet, whose first row names the columns."""
    frame = read_frame(content, NAME, NEEDS, "read_excel", io.BytesIO(content.raw))
    return Found(frame_table(frame, content.name, first=2, place=":"))
