"""Parquet files, by pandas and pyarrow where they are installed."""

from __future__ import annotations

import io

from bayescal.points.exports.found import Found
from bayescal.points.exports.installed import read_frame
from bayescal.points.tables.content import Content
from bayescal.points.tables.frames import frame_table

NAME = "Parquet file"
NEEDS = ("pandas", "pyarrow")


def recognises(content: Content) -> bool:
    """Whether it bears Parquet's mark."""
    return content.raw.startswith(b"PAR1")


def read(content: Content, _view: str | None) -> Found:
    """Read its columns."""
    frame = read_frame(content, NAME, NEEDS, "read_parquet", io.BytesIO(content.raw))
    return Found(frame_table(frame, content.name))
