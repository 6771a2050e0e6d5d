"""Data frames (pandas, polars) as tables, without importing either."""

from __future__ import annotations

import numbers
from typing import Any

from bayescal.errors import InputError
from bayescal.points.tables.sniffing import Line, TextTable
from bayescal.points.tables.text import quoted


def is_frame(value: object) -> bool:
    """Whether a value has named columns, as data frames have."""
    return hasattr(value, "columns") and hasattr(value, "__getitem__") and hasattr(value, "shape")


def frame_table(frame: Any, name: str, *, first: int = 1, place: str = ", row ") -> TextTable:
    """Make a table of a data frame; an index of words becomes its first column.

    Parameters
    ----------
    name : str
        The source, for messages.
    first : int
        Number of the first row, likewise.
    place : str
        What stands before a row's number.

    Raises
    ------
    InputError
        Where two columns have the same name.
    """
    names = [str(column).strip() for column in frame.columns]
    twice = next((n for n in names if names.count(n) > 1), None)
    if twice is not None:
        raise InputError(f"{name}: column {quoted(twice)} stands twice; keep one")
    columns = [[_text(value) for value in frame[column]] for column in frame.columns]
    index = list(getattr(frame, "index", ()))
    if any(isinstance(value, str) for value in index):
        names, columns = ["", *names], [[_text(value) for value in index], *columns]
    rows = zip(*columns, strict=True)
    lines = tuple(Line(number, fields) for number, fields in enumerate(rows, first))
    return TextTable(name, tuple(names), lines, max(first - 1, 1), place=place)


def _text(value: object) -> str:
    """Write a cell as a table of text has it: nothing where it is missing."""
    if value is None or value != value:  # NaN
        return ""
    if isinstance(value, numbers.Real) and not isinstance(value, bool):
        return repr(float(value))
    try:
        return str(value).strip()
    except ValueError:
        return ""
