"""The tidy table: a row per point, with the view it is seen in.

Columns view, x, y, z, r, c and optionally label, sigma_r, sigma_c; width and height, or a
comment such as "# image: 640 x 480", state the image size; "# sigma: relative" says that the
deviations only compare the points.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.exports.stored_tables import stored_table
from bayescal.points.tables.columns import PIXEL_SIGMAS, Columns
from bayescal.points.tables.frames import frame_table
from bayescal.points.tables.table import Row, Rows, number, read_rows, rows_of
from bayescal.points.tables.text import quoted
from bayescal.points.views.formats.source import Source
from bayescal.points.views.views import Views

NAME = "table of views"
REQUIRED = ("view", "x", "y", "z", "r", "c")
SIZE = ("width", "height")
COLUMNS = Columns(REQUIRED, (*REQUIRED, "label", *PIXEL_SIGMAS, *SIZE))
_SIZE_COMMENT = re.compile(r"\s*#\s*image:\s*(\d{1,9})\s*[x ]\s*(\d{1,9})\s*(?:px)?\s*")
_RELATIVE = re.compile(r"\s*#\s*sigma:\s*relative\s*")
COMMENTS = 100  # lines at the top among which such comments are looked for


def recognises(_: Source) -> bool:
    """Take whatever no other format takes."""
    return True


def read(source: Source) -> Views:
    """Read the table.

    Raises
    ------
    InputError
        Where it can't be used; the message names its line.
    """
    source.refuse_board()
    stored = stored_table(source)
    if stored is not None:
        return _views(source.name, rows_of(stored, COLUMNS, source.columns), "", source.sha256)
    text = source.text()
    rows = read_rows(source.name, text, COLUMNS, source.columns)
    return _views(source.name, rows, text, source.sha256)


def from_frame(frame: Any, columns: Mapping[str, str] | None) -> Views:
    """Take views from a data frame.

    Raises
    ------
    InputError
        Where it can't be used.
    """
    name = type(frame).__name__
    views = _views(name, rows_of(frame_table(frame, name), COLUMNS, columns), "", "")
    return dataclasses.replace(views, lines=None)


def _views(name: str, table: Rows, text: str, sha256: str) -> Views:
    """Make views of rows; a text's comments may state the image size."""
    found = list(table.rows)
    if not found:
        raise InputError(f"{name}: there are no points below the header; add views of at least 4")
    for row in found:
        if not row.fields["view"]:
            raise InputError(f"{name}{row.place}{row.line}: view is empty; name the photograph")
    given = found[0].fields
    sds = [column for column in PIXEL_SIGMAS if column in given]
    if len(sds) == 1:
        raise InputError(f"{name}: has {sds[0]} alone; give both {' and '.join(PIXEL_SIGMAS)}")
    width, height = _size(name, text, found)
    return Views.from_rows(
        [row.fields["view"] for row in found],
        _numbers(name, found, ("x", "y", "z")),
        _numbers(name, found, ("r", "c")),
        sigma=_numbers(name, found, PIXEL_SIGMAS) if sds else None,
        relative_sigma=bool(sds) and _comment(text, _RELATIVE) is not None,
        labels=[row.fields["label"] for row in found] if "label" in given else None,
        width=width,
        height=height,
        source=name,
        lines=[row.line for row in found],
        sha256=sha256,
        notes=table.notes,
    )


def _numbers(name: str, found: list[Row], columns: tuple[str, ...]) -> Array:
    return np.array([[number(name, row, column) for column in columns] for row in found])


def _comment(text: str, pattern: re.Pattern[str]) -> re.Match[str] | None:
    lines = (pattern.fullmatch(line) for line in text.split("\n", COMMENTS)[:COMMENTS])
    return next(filter(None, lines), None)


def _size(name: str, text: str, found: list[Row]) -> tuple[float | None, float | None]:
    """Image size by the columns, else by a comment; all views must agree on it."""
    stated = [column for column in SIZE if column in found[0].fields]
    if not stated:
        match = _comment(text, _SIZE_COMMENT)
        return (float(match[1]), float(match[2])) if match else (None, None)
    if len(stated) == 1:
        raise InputError(f"{name}: has {stated[0]} alone; give both {' and '.join(SIZE)}")
    sizes = [tuple(number(name, row, column) for column in SIZE) for row in found]
    for row, size in zip(found, sizes, strict=True):
        if size != sizes[0]:
            raise InputError(
                f"{name}:{row.line}: view {quoted(row.fields['view'])} is of an image of "
                f"{size[0]:g} by {size[1]:g} px, those before of {sizes[0][0]:g} by "
                f"{sizes[0][1]:g} px; give the views of one camera at a time"
            )
    return sizes[0][0], sizes[0][1]
